// What a heavy pass looks like to the hardware: one texture read, a loop over lights, one store.

struct Frame {
    size: vec2<u32>,
    lights: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var surface: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> lights: array<vec4<f32>>;
@group(0) @binding(3) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn heavy(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let seen = textureLoad(surface, id.xy, 0);
    let normal = normalize(seen.xyz * 2.0 - 1.0);
    let at = vec3(vec2<f32>(id.xy) * 0.001, seen.w);
    var sum = vec3(0.02);
    for (var i = 0u; i < frame.lights; i++) {
        let light = lights[i];
        let to = light.xyz - at;
        sum += max(dot(normal, to) * inverseSqrt(dot(to, to) + 0.01), 0.0) * light.w / (1.0 + dot(to, to));
    }
    textureStore(picture, id.xy, vec4(sum, 1.0));
}
