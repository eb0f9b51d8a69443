// The number of lights that touch the tile is the same for all: `workgroupUniformLoad` hands it on, and stands where a barrier
// would.

struct Light { place: vec3<f32>, reach: f32 }
@group(0) @binding(0) var<storage, read> lights: array<Light>;
@group(0) @binding(1) var image: texture_2d<f32>;
@group(0) @binding(2) var result: texture_storage_2d<rgba16float, write>;

var<workgroup> count: atomic<u32>;
var<workgroup> mask: array<atomic<u32>, 4>;
var<workgroup> turns: u32;

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let total = min(arrayLength(&lights), 128u);
    for (var i = lane; i < total; i += 64u) {
        let way = lights[i].place.xy - vec2<f32>(group.xy) / 8.0;
        if dot(way, way) < 0.6 {
            atomicOr(&mask[i / 32u], 1u << (i % 32u));
            atomicAdd(&count, 1u);
        }
    }
    workgroupBarrier();
    if lane == 0u {
        turns = 1u + atomicLoad(&count) % 5u;
    }
    let n = workgroupUniformLoad(&turns);
    var sum = vec3<f32>(0.0);
    for (var turn = 0u; turn < n; turn++) {
        if lane == turn {
            turns += 1u;
        }
        let seen = workgroupUniformLoad(&turns);
        sum += textureLoad(image, (gid.xy + seen) % textureDimensions(image), 0).rgb;
        workgroupBarrier();
    }
    textureStore(result, gid.xy, vec4<f32>(sum, f32(n)));
}
