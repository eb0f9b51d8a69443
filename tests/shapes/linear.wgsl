// A one-dimensional dispatch over the pixels' numbers: all ids, a picture, a buffer, and a place decoded with `i32`.
struct Frame { width: u32, height: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(3) var<storage, read_write> texels: array<vec4<f32>>;
@group(0) @binding(4) var ids: texture_storage_2d<rgba32uint, write>;

fn place(number: u32) -> vec2<i32> {
    return vec2(i32(number) % i32(frame.width), i32(number) / i32(frame.width));
}

@compute @workgroup_size(64)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) count: vec3<u32>,
) {
    let number = group.x * 64u + local.x;
    if number >= frame.width * frame.height {
        return;
    }
    let at = vec2(number % frame.width, number / frame.width);
    let color = textureLoad(input, at, 0);
    textureStore(picture, place(number), color);
    texels[id.x] = color * 2.0;
    textureStore(ids, at, vec4(index, group.x + 256u * local.x, count.x, id.y + id.z + local.y + group.z));
}
