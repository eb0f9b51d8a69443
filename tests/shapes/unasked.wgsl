// Besides the light of a loop: sound by the number of an invocation, a counter, a map of a quarter of the sides, and a place that memory
// tells, all for every pixel, since copies cannot serve them. A helper stores to both sides.
struct Frame { size: vec2<u32>, lights: u32, samples: u32 }
struct Marks { next: array<u32, 64>, seen: array<u32, 128> }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var color: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(3) var coarse: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(4) var<storage, read_write> sound: array<f32>;
@group(0) @binding(5) var<storage, read_write> frames: array<u32, 4>;
@group(0) @binding(6) var<storage, read_write> marks: Marks;

fn tone(at: u32) -> f32 {
    var sum = 0.0;
    for (var i = 1u; i < 8u; i++) {
        sum += sin(f32(at * i)) / f32(i);
    }
    return sum;
}

fn put(at: vec2<u32>, light: vec4<f32>) {
    textureStore(color, at, light);
    if all(at % 4u == vec2<u32>(0u)) {
        textureStore(coarse, at / 4u, vec4<f32>(vec2<f32>(at) / 64.0, 0.0, 1.0));
    }
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let number = (group.y * groups.x + group.x) * 64u + lane;
    if number < min(frame.samples, 256u) {
        sound[number * 2u] = tone(number);
        sound[number * 2u + 1u] = -tone(number + 1u);
    }
    if all(id == vec3<u32>(0u)) {
        frames[0] = frame.lights + 1u;
    }
    if id.x < 8u && id.y < 8u {
        let cell = id.y * 8u + id.x;
        marks.seen[(marks.next[cell] & 1u) * 64u + cell] = number;
    }
    if id.x >= frame.size.x || id.y >= frame.size.y {
        return;
    }
    let texel = textureLoad(input, id.xy, 0);
    var light = vec4<f32>(0.0);
    for (var i = 0u; i < min(frame.lights, 40u); i++) {
        light += abs(sin(texel * f32(i + 1u))) / 40.0;
    }
    put(id.xy, light);
}
