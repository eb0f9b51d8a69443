@group(0) @binding(0) var sharpened: texture_storage_2d<rgba8unorm, write>;

// 64 invocations for 8 x 8 pixels, in the order of a Morton curve
fn place(lane: u32) -> vec2<u32> {
    return vec2<u32>(
        insertBits(extractBits(lane, 2u, 3u), lane, 0u, 1u),
        insertBits(extractBits(lane, 3u, 3u), extractBits(lane, 1u, 2u), 0u, 2u),
    );
}

@compute @workgroup_size(64)
fn sharpen(@builtin(local_invocation_index) lane: u32, @builtin(workgroup_id) group: vec3<u32>) {
    let at = place(lane) + group.xy * 8u;
    textureStore(sharpened, at, vec4<f32>(vec2<f32>(at) * 0.01, 0.0, 1.0)); // here
}
