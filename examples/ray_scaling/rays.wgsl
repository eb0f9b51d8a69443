// Ambient occlusion by rays, over a floor with a grid of pillars. Where pixels share, each fires its part of the rays.

struct Frame {
    size: vec2<u32>,
    number: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(2) var<storage, read_write> fired: array<u32>;

const RAYS: u32 = 10u;

// Stubs: the rewriter gives them their meaning, and without it the shader is as valid and fires all rays.
fn vrcs_copies() -> u32 { return 0u; }

// As in the documentation of `vrcs_passes::graded`. `noise` is 0 to 1 (without 1), another value for each pixel and frame.
fn vrcs_share(rays: u32, noise: f32) -> u32 {
    let sharing = 1u + vrcs_copies();
    let one_more = noise * f32(sharing) < f32(rays % sharing);
    return max(1u, rays / sharing + u32(one_more));
}

fn hash(seed: u32) -> u32 {
    let a = seed * 747796405u + 2891336453u;
    let b = ((a >> ((a >> 28u) + 4u)) ^ a) * 277803737u;
    return (b >> 22u) ^ b;
}

fn unit(seed: u32) -> f32 {
    return f32(hash(seed) >> 8u) / 16777216.0;
}

// Whether a ray meets a pillar, a cylinder of height 1 about the middle of each cell.
fn is_stopped(start: vec3<f32>, way: vec3<f32>) -> bool {
    for (var i = 1u; i <= 24u; i++) {
        let at = start + way * 0.05 * f32(i);
        if at.z < 1.0 && length(fract(at.xy) - 0.5) < 0.22 {
            return true;
        }
    }
    return false;
}

@compute @workgroup_size(8, 8)
fn occlude(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let index = id.y * frame.size.x + id.x;
    let seed = hash(index ^ hash(frame.number));
    let rays = vrcs_share(RAYS, unit(seed));
    let at = vec2<f32>(id.xy) / f32(frame.size.y) * 5.0;
    let height = select(0.01, 1.01, length(fract(at) - 0.5) < 0.22);
    var open = 0u;
    for (var i = 0u; i < rays; i++) {
        let turn = 6.2832 * unit(seed + 2u * i + 1u);
        let up = unit(seed + 2u * i + 2u);
        let way = vec3(vec2(cos(turn), sin(turn)) * sqrt(1.0 - up * up), up);
        open += select(1u, 0u, is_stopped(vec3(at, height), way));
    }
    fired[index] = rays;
    textureStore(picture, id.xy, vec4(vec3(f32(open) / f32(rays)), 1.0));
}
