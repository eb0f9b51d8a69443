// Stores in helpers, two calls deep, from several places with different arguments.
struct Frame { size: vec2<u32> }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var a: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(3) var b: texture_storage_2d<rgba8unorm, write>;

fn put(at: vec2<i32>, color: vec4<f32>) {
    if all(at >= vec2(0)) && all(at < vec2<i32>(frame.size)) {
        textureStore(a, at, color);
    }
}

fn put_both(at: vec2<i32>, color: vec4<f32>) {
    put(at, color);
    textureStore(b, vec2(i32(frame.size.x) - 1 - at.x, at.y), color.zyxw);
}

fn shade(at: vec2<u32>) -> vec4<f32> {
    return textureLoad(input, at, 0) * vec4(0.9, 0.8, 0.7, 1.0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let color = shade(id.xy);
    if color.x > 0.4 {
        put_both(vec2<i32>(id.xy), color);
    } else {
        put(vec2<i32>(id.xy), color * 2.0);
    }
}
