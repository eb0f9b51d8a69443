#import lib::waves

struct Frame {
    size: vec2<u32>,
    time: f32,
}

@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(1) var<uniform> frame: Frame;

@compute @workgroup_size(8, 8)
fn shade(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let at = vec2<f32>(id.xy) / vec2<f32>(frame.size);
    let up = waves::height(at, frame.time);
    let right = waves::height(at + vec2(0.01, 0.0), frame.time);
    let down = waves::height(at + vec2(0.0, 0.01), frame.time);
    let normal = normalize(vec3(up - right, up - down, 0.02));
    let sun = max(dot(normal, normalize(vec3(1.0, 1.0, 0.5))), 0.0);
    textureStore(picture, id.xy, vec4(sun, 0.2 + 0.8 * sun, 0.5 + 0.5 * up / 4.0, 1.0));
}
