// Temporal anti-aliasing with a neighbourhood in workgroup memory: min, max, variance clip, history.
struct Taa { size: vec2<f32>, blend: f32, gamma: f32, }
@group(0) @binding(0) var<uniform> taa: Taa;
@group(0) @binding(1) var current: texture_2d<f32>;
@group(0) @binding(2) var history: texture_2d<f32>;
@group(0) @binding(3) var velocity: texture_2d<f32>;
@group(0) @binding(4) var linear_sampler: sampler;
@group(0) @binding(5) var resolved: texture_storage_2d<rgba16float, write>;

const BORDER: u32 = 1u;
const SIDE: u32 = 18u;
var<workgroup> colors: array<vec3<f32>, 324>;
var<workgroup> depths: array<f32, 324>;

fn to_ycocg(c: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * c.r - 0.5 * c.b, -0.25 * c.r + 0.5 * c.g - 0.25 * c.b);
}

fn preload(index: u32, corner: vec2<i32>) {
    let at = corner + vec2<i32>(i32(index % SIDE), i32(index / SIDE));
    let texel = textureLoad(current, clamp(at, vec2<i32>(0), vec2<i32>(taa.size) - 1), 0);
    colors[index] = to_ycocg(texel.rgb);
    depths[index] = texel.a;
}

@compute @workgroup_size(16, 16)
fn main(
    @builtin(workgroup_id) group_id: vec3<u32>,
    @builtin(local_invocation_id) thread: vec3<u32>,
    @builtin(local_invocation_index) thread_index: u32,
) {
    let corner = vec2<i32>(group_id.xy * 16u) - 1;
    preload(thread_index, corner);
    if thread_index < SIDE * SIDE - 256u {
        preload(thread_index + 256u, corner);
    }
    workgroupBarrier();

    let pixel = group_id.xy * 16u + thread.xy;
    if f32(pixel.x) >= taa.size.x || f32(pixel.y) >= taa.size.y {
        return;
    }
    var m1 = vec3<f32>(0.0);
    var m2 = vec3<f32>(0.0);
    var nearest = vec3<f32>(0.0, 0.0, -1.0);
    for (var y = 0u; y < 3u; y++) {
        for (var x = 0u; x < 3u; x++) {
            let at = (thread.y + y) * SIDE + thread.x + x;
            m1 += colors[at];
            m2 += colors[at] * colors[at];
            if depths[at] > nearest.z {
                nearest = vec3<f32>(f32(x), f32(y), depths[at]);
            }
        }
    }
    let mean = m1 / 9.0;
    let deviation = sqrt(max(m2 / 9.0 - mean * mean, vec3<f32>(0.0)));
    let motion = textureLoad(velocity, vec2<i32>(pixel) + vec2<i32>(nearest.xy) - 1, 0).xy;
    let uv = (vec2<f32>(pixel) + 0.5) / taa.size - motion * 0.01;
    let old = to_ycocg(textureSampleLevel(history, linear_sampler, uv, 0.0).rgb);
    let clipped = clamp(old, mean - taa.gamma * deviation, mean + taa.gamma * deviation);
    let now = colors[(thread.y + BORDER) * SIDE + thread.x + BORDER];
    textureStore(resolved, pixel, vec4<f32>(mix(clipped, now, taa.blend), 1.0));
}
