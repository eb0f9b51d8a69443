// The address goes through floats, a clamp and a conversion.
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var linear: sampler;
@group(0) @binding(2) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<f32>(textureDimensions(picture));
    if any(id.xy >= textureDimensions(picture)) {
        return;
    }
    let uv = (vec2<f32>(id.xy) + 0.5) / size;
    let at = vec2<i32>(clamp(floor(uv * size), vec2(0.0), size - 1.0));
    textureStore(picture, at, textureSampleLevel(input, linear, uv, 1.5));
}
