// Tiled deferred lighting: the tile's depth bounds, the lights that touch them as a bit mask, then shading.

struct Light {
    place: vec3<f32>,
    reach: f32,
    color: vec3<f32>,
    kind: u32,
}

struct Frame {
    size: vec2<u32>,
    lights: u32,
    ambient: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> lights: array<Light>;
@group(0) @binding(2) var albedo: texture_2d<f32>;
@group(0) @binding(3) var normals: texture_2d<f32>;
@group(0) @binding(4) var depths: texture_2d<f32>;
@group(0) @binding(5) var lit: texture_storage_2d<rgba16float, write>;
@group(0) @binding(6) var<storage, read_write> counts: array<u32>;

const WORDS: u32 = 2u;
var<workgroup> nearest: atomic<u32>;
var<workgroup> farthest: atomic<u32>;
var<workgroup> touching: array<atomic<u32>, WORDS>;

fn shade(light: Light, place: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let way = light.place - place;
    let fall = max(0.0, 1.0 - dot(way, way) / max(light.reach * light.reach, 0.0001));
    return light.color * fall * max(0.0, dot(normal, way) + 0.5);
}

@compute @workgroup_size(16, 16)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let count = min(min(frame.lights, arrayLength(&lights)), WORDS * 32u);
    let is_inside = all(gid.xy < frame.size);
    let depth = textureLoad(depths, gid.xy, 0).x;
    if lane == 0u {
        atomicStore(&nearest, 0xffffffffu);
        atomicStore(&farthest, 0u);
    }
    if lane < WORDS {
        atomicStore(&touching[lane], 0u);
    }
    workgroupBarrier();
    if is_inside {
        let steps = u32(clamp(depth, 0.0, 1.0) * 65535.0);
        atomicMin(&nearest, steps);
        atomicMax(&farthest, steps);
    }
    workgroupBarrier();
    let front = f32(atomicLoad(&nearest)) / 65535.0;
    let back = f32(atomicLoad(&farthest)) / 65535.0;
    let middle = (vec2<f32>(group.xy) * 16.0 + 8.0) / vec2<f32>(frame.size + 1u);
    for (var i = lane; i < count; i += 256u) {
        let light = lights[i];
        let near = light.place.z + light.reach >= front && light.place.z - light.reach <= back;
        if near && distance(light.place.xy, middle) < light.reach + 1.0 {
            atomicOr(&touching[i / 32u], 1u << (i % 32u));
        }
    }
    workgroupBarrier();
    if !is_inside {
        return;
    }
    let place = vec3<f32>(vec2<f32>(gid.xy) / vec2<f32>(frame.size + 1u), depth);
    let normal = textureLoad(normals, gid.xy, 0).xyz * 2.0 - 1.0;
    var sum = vec3<f32>(frame.ambient);
    var touched = 0u;
    for (var word = 0u; word < WORDS; word++) {
        var bits = atomicLoad(&touching[word]);
        while bits != 0u {
            let i = firstTrailingBit(bits);
            bits &= bits - 1u;
            sum += shade(lights[word * 32u + i], place, normal);
            touched++;
        }
    }
    let color = textureLoad(albedo, gid.xy, 0).rgb * sum;
    textureStore(lit, gid.xy, vec4<f32>(color, 1.0));
    counts[gid.y * frame.size.x + gid.x] = touched;
}
