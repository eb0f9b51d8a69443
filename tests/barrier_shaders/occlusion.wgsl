// Ambient occlusion that first asks what its tile holds: a tile without a surface is written and left at once, by all.

struct Camera {
    size: vec2<u32>,
    far: f32,
    radius: f32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var depths: texture_2d<f32>;
@group(0) @binding(2) var occlusion: texture_storage_2d<r32float, write>;

var<workgroup> surfaces: atomic<u32>;
var<workgroup> has_surface: u32;
var<workgroup> near: array<f32, 256>;

@compute @workgroup_size(16, 16)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_id) lid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let depth = textureLoad(depths, gid.xy, 0).x;
    near[lane] = depth;
    if all(gid.xy < camera.size) && depth < camera.far {
        atomicAdd(&surfaces, 1u);
    }
    workgroupBarrier();
    if lane == 0u {
        has_surface = atomicLoad(&surfaces);
    }
    let found = workgroupUniformLoad(&has_surface);
    if found == 0u {
        textureStore(occlusion, gid.xy, vec4<f32>(1.0));
        return;
    }
    var hidden = 0.0;
    for (var y = -2; y <= 2; y++) {
        for (var x = -2; x <= 2; x++) {
            let other = clamp(vec2<i32>(lid.xy) + vec2<i32>(x, y), vec2<i32>(0), vec2<i32>(15));
            let rise = near[lane] - near[other.y * 16 + other.x];
            hidden += select(0.0, 1.0, rise > 0.0 && rise < camera.radius);
        }
    }
    let share = f32(found) / 256.0;
    textureStore(occlusion, gid.xy, vec4<f32>(1.0 - share * hidden / 25.0));
}
