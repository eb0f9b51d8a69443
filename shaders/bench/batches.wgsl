// The commonest heavy shape with barriers: load a batch of lights into workgroup memory, meet, shade with it, meet again.

struct Frame {
    size: vec2<u32>,
    lights: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var surface: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> lights: array<vec4<f32>>;
@group(0) @binding(3) var picture: texture_storage_2d<rgba8unorm, write>;

var<workgroup> batch: array<vec4<f32>, 64>;

@compute @workgroup_size(16, 16)
fn batches(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let is_active = all(id.xy < frame.size);
    let seen = textureLoad(surface, id.xy, 0);
    let normal = normalize(seen.xyz * 2.0 - 1.0);
    let at = vec3(vec2<f32>(id.xy) * 0.001, seen.w);
    var sum = vec3(0.02);
    for (var first = 0u; first < frame.lights; first += 64u) {
        if lane < 64u {
            batch[lane] = lights[first + lane];
        }
        workgroupBarrier();
        if is_active {
            for (var i = 0u; i < 64u; i++) {
                let light = batch[i];
                let to = light.xyz - at;
                sum += max(dot(normal, to) * inverseSqrt(dot(to, to) + 0.01), 0.0) * light.w / (1.0 + dot(to, to));
            }
        }
        workgroupBarrier();
    }
    if is_active {
        textureStore(picture, id.xy, vec4(sum, 1.0));
    }
}
