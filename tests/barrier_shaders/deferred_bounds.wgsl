// Tiled deferred shading with depth bounds by atomics, a light list of its own, and pixels that leave behind the last barrier.
struct View {
    inverse_projection: mat4x4<f32>,
    view: mat4x4<f32>,
    screen: vec2<u32>,
    light_count: u32,
    exposure: f32,
}

struct PointLight {
    position: vec3<f32>,
    radius: f32,
    color: vec3<f32>,
    intensity: f32,
}

const TILE: u32 = 16u;
const MAX_LIGHTS: u32 = 128u;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> lights: array<PointLight>;
@group(0) @binding(2) var depth_texture: texture_2d<f32>;
@group(0) @binding(3) var normal_texture: texture_2d<f32>;
@group(0) @binding(4) var albedo_texture: texture_2d<f32>;
@group(0) @binding(5) var hdr: texture_storage_2d<rgba16float, write>;

var<workgroup> tile_min: atomic<u32>;
var<workgroup> tile_max: atomic<u32>;
var<workgroup> visible_count: atomic<u32>;
var<workgroup> visible: array<u32, MAX_LIGHTS>;

fn linear_depth(d: f32) -> f32 {
    return 0.1 / max(d, 1e-4);
}

fn view_position(pixel: vec2<u32>, d: f32) -> vec3<f32> {
    let uv = (vec2<f32>(pixel) + 0.5) / vec2<f32>(view.screen);
    let clip = vec4<f32>(uv * 2.0 - 1.0, d, 1.0);
    let p = view.inverse_projection * clip;
    return p.xyz / p.w;
}

fn attenuate(distance: f32, radius: f32) -> f32 {
    let x = clamp(1.0 - distance / max(radius, 1e-3), 0.0, 1.0);
    return x * x;
}

@compute @workgroup_size(16, 16, 1)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) wid: vec3<u32>,
) {
    if local == 0u {
        atomicStore(&tile_min, 0x7f7fffffu);
        atomicStore(&tile_max, 0u);
        atomicStore(&visible_count, 0u);
    }
    workgroupBarrier();

    let depth = textureLoad(depth_texture, gid.xy, 0).r;
    let z = linear_depth(depth);
    if all(gid.xy < view.screen) {
        atomicMin(&tile_min, bitcast<u32>(z));
        atomicMax(&tile_max, bitcast<u32>(z));
    }
    workgroupBarrier();

    let near = bitcast<f32>(atomicLoad(&tile_min));
    let far = bitcast<f32>(atomicLoad(&tile_max));
    let center = (vec2<f32>(wid.xy) + 0.5) * f32(TILE);

    for (var i = local; i < view.light_count; i += TILE * TILE) {
        let light = lights[i];
        let p = (view.view * vec4<f32>(light.position, 1.0)).xyz;
        let overlaps = -p.z + light.radius > near && -p.z - light.radius < far;
        if overlaps || distance(p.xy, center) < light.radius * 8.0 {
            let slot = atomicAdd(&visible_count, 1u);
            if slot < MAX_LIGHTS {
                visible[slot] = i;
            }
        }
    }
    workgroupBarrier();

    if any(gid.xy >= view.screen) {
        return;
    }
    if depth <= 0.0 {
        textureStore(hdr, gid.xy, vec4<f32>(0.0, 0.0, 0.0, 1.0));
        return;
    }
    let n = normalize(textureLoad(normal_texture, gid.xy, 0).xyz * 2.0 - 1.0 + vec3<f32>(0.0, 0.0, 1e-3));
    let albedo = textureLoad(albedo_texture, gid.xy, 0).rgb;
    let position = view_position(gid.xy, depth);
    let count = min(atomicLoad(&visible_count), MAX_LIGHTS);
    // what order the list has is chance: what is added up here must not hang on it
    var lit = 0u;
    for (var i = 0u; i < count; i++) {
        let light = lights[visible[i]];
        let to_light = light.position - position;
        let a = attenuate(length(to_light), light.radius) * max(dot(n, normalize(to_light)), 0.0);
        lit += u32(clamp(a * light.intensity, 0.0, 8.0) * 1024.0);
    }
    textureStore(hdr, gid.xy, vec4<f32>(albedo * f32(lit) * view.exposure, 1.0));
}
