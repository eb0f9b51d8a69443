// Light batches whose inner loop leaves out lights early, in several ways, and may end.
struct Light { position: vec3<f32>, range: f32, color: vec3<f32>, kind: u32, direction: vec3<f32>, cone: f32, }
struct Globals { eye: vec3<f32>, count: u32, ambient: vec3<f32>, cutoff: f32, }
@group(0) @binding(0) var<uniform> globals: Globals;
@group(0) @binding(1) var<storage, read> all_lights: array<Light>;
@group(1) @binding(0) var gbuffer0: texture_2d<f32>;
@group(1) @binding(1) var gbuffer1: texture_2d<f32>;
@group(1) @binding(2) var target_: texture_storage_2d<rgba16float, write>;

var<workgroup> shared_lights: array<Light, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) gid: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let pixel = vec2<i32>(gid.xy);
    let g0 = textureLoad(gbuffer0, pixel, 0);
    let g1 = textureLoad(gbuffer1, pixel, 0);
    let position = g0.xyz * 20.0 - 10.0;
    let normal = normalize(g1.xyz - 0.5 + vec3<f32>(0.0, 1e-3, 0.0));
    let rough = g1.w;
    var radiance = globals.ambient * g0.w;
    var specular = vec3<f32>(0.0);
    var shaded = 0;
    let count = min(globals.count, arrayLength(&all_lights));
    for (var base = 0u; base < count; base += 64u) {
        if base + lane < count {
            shared_lights[lane] = all_lights[base + lane];
        }
        workgroupBarrier();
        let batch = min(64u, count - base);
        for (var i = 0u; i < batch; i++) {
            let light = shared_lights[i];
            let to_light = light.position - position;
            let d2 = dot(to_light, to_light);
            if d2 > light.range * light.range {
                continue;
            }
            let l = to_light * inverseSqrt(max(d2, 1e-6));
            if light.kind == 1u && dot(-l, light.direction) < light.cone {
                continue;
            }
            let n_l = dot(normal, l);
            if n_l <= 0.0 {
                continue;
            }
            let h = normalize(l + normalize(globals.eye - position));
            specular += light.color * pow(max(dot(normal, h), 0.0), 2.0 + 64.0 * (1.0 - rough));
            radiance += light.color * n_l / (1.0 + d2);
            shaded++;
            if radiance.x + radiance.y > globals.cutoff * 100.0 {
                break;
            }
        }
        workgroupBarrier();
    }
    textureStore(target_, pixel, vec4<f32>(radiance + specular, f32(shaded)));
}
