// What others have scattered over three planes, and beside it in one of pairs, is drawn up, and something else is left there.
struct Frame { width: u32, height: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba16float, write>;
@group(0) @binding(3) var<storage, read_write> planes: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> pairs: array<atomic<i32>>;

fn take(place: u32, mark: u32) -> f32 {
    return f32(atomicExchange(&planes[place], mark) & 0xffu);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let place = id.y * frame.width + id.x;
    let plane = frame.width * frame.height;
    let color = vec3<f32>(take(place, id.x), take(place + plane, 7u), take(place + 2u * plane, id.y)) / 255.0;
    let first = atomicExchange(&pairs[place * 2u], i32(id.x) - 7);
    let second = atomicExchange(&pairs[place * 2u + 1u], -1);
    textureStore(picture, id.xy, vec4(color, f32(first > second)) + textureLoad(input, id.xy, 0));
}
