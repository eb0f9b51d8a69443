// One pass of a radix-2 FFT along rows: 64 complex numbers a workgroup.
struct Params {
    sign: f32,
    scale: f32,
}
@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var output: texture_storage_2d<rg32float, write>;

const N: u32 = 64u;
const LOG_N: u32 = 6u;
const PI: f32 = 3.14159265;

var<workgroup> line: array<array<vec2<f32>, 64>, 2>;

fn complex_mul(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) gid: vec3<u32>, @builtin(local_invocation_id) lid: vec3<u32>) {
    let i = lid.x;
    let place = reverseBits(i) >> (32u - LOG_N);
    line[0][place] = textureLoad(input, gid.xy, 0).rg;
    workgroupBarrier();
    var source = 0u;
    for (var stage = 0u; stage < LOG_N; stage++) {
        let half = 1u << stage;
        let pair = i & (half - 1u);
        let base = (i >> (stage + 1u)) << (stage + 1u);
        let angle = params.sign * PI * f32(pair) / f32(half);
        let twiddle = vec2<f32>(cos(angle), sin(angle));
        let a = line[source][base + pair];
        let b = complex_mul(twiddle, line[source][base + pair + half]);
        if (i & half) == 0u {
            line[1u - source][i] = a + b;
        } else {
            line[1u - source][i] = a - b;
        }
        source = 1u - source;
        workgroupBarrier();
    }
    textureStore(output, gid.xy, vec4<f32>(line[source][i] * params.scale, 0.0, 0.0));
}
