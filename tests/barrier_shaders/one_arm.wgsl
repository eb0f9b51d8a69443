// Only one arm of a uniform condition fills workgroup memory and meets; behind it, both arms store. (Lavapipe takes a minute to compile a
// barrier under a condition with this around it, so that its laws are held on another driver.)

struct Tap {
    color: vec3<f32>,
    depth: f32,
}

struct Frame {
    size: vec2<u32>,
    quality: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var result: texture_storage_2d<rgba16float, write>;

var<workgroup> taps: array<Tap, 400>;

fn load(at: vec2<i32>) -> Tap {
    let inside = clamp(at, vec2<i32>(0), vec2<i32>(textureDimensions(color)) - 1);
    let texel = textureLoad(color, inside, 0);
    return Tap(texel.rgb, texel.a);
}

@compute @workgroup_size(16, 16)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    let origin = vec2<i32>(group.xy * 16u) - 2;
    var sum = vec3<f32>(0.0);
    if (frame.quality & 1u) != 0u {
        for (var i = lane; i < 400u; i += 256u) {
            taps[i] = load(origin + vec2<i32>(i32(i % 20u), i32(i / 20u)));
        }
        workgroupBarrier();
        let center = (lane / 16u + 2u) * 20u + lane % 16u + 2u;
        for (var other = center - (frame.quality & 2u); other <= center + 1u; other++) {
            sum += taps[other].color * max(0.0, 1.0 - abs(taps[center].depth - taps[other].depth));
        }
    } else {
        sum = load(vec2<i32>(id.xy)).color;
    }
    if all(id.xy < frame.size) {
        textureStore(result, id.xy, vec4<f32>(sum, 1.0));
    }
}
