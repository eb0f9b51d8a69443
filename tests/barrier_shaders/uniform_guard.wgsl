// A tile whose pixels need no work leaves as a whole; what kind of work it needs is told to all by workgroupUniformLoad.
struct Work { kind: u32, samples: u32, jitter: vec2<f32>, }
struct Frame { size: vec2<u32>, index: u32, threshold: f32, }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var variance: texture_2d<f32>;
@group(0) @binding(2) var color: texture_2d<f32>;
@group(0) @binding(3) var result: texture_storage_2d<rgba16float, write>;
var<workgroup> noisy: atomic<u32>;
var<workgroup> work: Work;

fn gather(p: vec2<i32>, count: u32, jitter: vec2<f32>) -> vec4<f32> {
    var sum = vec4<f32>(0.0);
    for (var i = 0u; i < count; i++) {
        let offset = vec2<i32>(jitter * f32(i * 3u)) - vec2<i32>(i32(i % 3u), i32(i / 3u));
        sum += textureLoad(color, clamp(p + offset, vec2<i32>(0), vec2<i32>(frame.size) - 1), 0);
    }
    return sum / f32(max(count, 1u));
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let v = textureLoad(variance, gid.xy, 0).r;
    if v > frame.threshold {
        atomicAdd(&noisy, 1u);
    }
    workgroupBarrier();
    if lane == 0u {
        let n = atomicLoad(&noisy);
        work.kind = select(select(1u, 2u, n > 40u), 0u, n == 0u);
        work.samples = 3u + n / 16u;
        work.jitter = vec2<f32>(f32(frame.index & 3u), f32(n) / 64.0);
    }
    let job = workgroupUniformLoad(&work);
    if job.kind == 0u {
        textureStore(result, gid.xy, textureLoad(color, gid.xy, 0));
        return;
    }
    if gid.x >= frame.size.x || gid.y >= frame.size.y {
        return;
    }
    var c = gather(vec2<i32>(gid.xy), job.samples, job.jitter);
    switch job.kind {
        case 2u: {
            c = mix(c, textureLoad(color, gid.xy, 0), v);
        }
        default: {
            c = c * 0.5;
        }
    }
    textureStore(result, gid.xy, c);
}
