// A window on a torus: cells stay where they are while the window scrolls over them, and those that scroll in are cleared.
struct Window { origin: vec2<u32>, moved: vec2<u32> }
@group(0) @binding(0) var<uniform> window: Window;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> heat: array<f32>;
@group(0) @binding(3) var<storage, read_write> pressure: array<f32>;

const SIZE = vec2<i32>(48, 40);

fn place(cell: vec2<i32>) -> u32 {
    let wrapped = ((cell % SIZE) + SIZE) % SIZE;
    return u32(wrapped.y * SIZE.x + wrapped.x);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= vec2<u32>(SIZE)) {
        return;
    }
    let cell = vec2<i32>(window.origin & vec2(0xffffu)) - 32768 + vec2<i32>(id.xy);
    heat[place(cell)] = textureLoad(input, id.xy, 0).x;
    if any(id.xy < 4u + (window.moved & vec2(7u))) {
        pressure[place(cell)] = f32(id.x) - f32(id.y) * 0.25;
    }
}
