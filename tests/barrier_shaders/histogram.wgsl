// Local exposure: a histogram for each tile, its average by a reduction, and the picture graded by it.
struct Settings {
    min_log: f32,
    range: f32,
    key: f32,
    size: vec2<u32>,
}
@group(0) @binding(0) var<uniform> settings: Settings;
@group(0) @binding(1) var scene: texture_2d<f32>;
@group(0) @binding(2) var graded: texture_storage_2d<rgba8unorm, write>;

var<workgroup> bins: array<atomic<u32>, 256>;
var<workgroup> sums: array<vec2<u32>, 256>;

fn bin_of(color: vec3<f32>) -> u32 {
    let luminance = dot(color, vec3<f32>(0.2126, 0.7152, 0.0722));
    if luminance < 0.001 {
        return 0u;
    }
    let level = clamp((log2(luminance) - settings.min_log) / max(settings.range, 0.1), 0.0, 1.0);
    return u32(level * 254.0 + 1.0);
}

@compute @workgroup_size(16, 16)
fn main(
    @builtin(local_invocation_index) index: u32,
    @builtin(global_invocation_id) id: vec3<u32>,
) {
    atomicStore(&bins[index], 0u);
    workgroupBarrier();
    let dimensions = textureDimensions(scene);
    var color = vec3<f32>(0.0);
    if id.x < dimensions.x && id.y < dimensions.y {
        color = textureLoad(scene, id.xy, 0).rgb;
        atomicAdd(&bins[bin_of(color)], 1u);
    }
    workgroupBarrier();
    let count = atomicLoad(&bins[index]);
    sums[index] = vec2<u32>(count * index, select(count, 0u, index == 0u));
    workgroupBarrier();
    for (var step = 128u; step > 0u; step >>= 1u) {
        if index < step {
            sums[index] += sums[index + step];
        }
        workgroupBarrier();
    }
    let total = sums[0];
    let average = f32(total.x) / f32(max(total.y, 1u));
    let exposure = settings.key / exp2(average / 254.0 * settings.range + settings.min_log);
    let mapped = color * exposure;
    textureStore(graded, id.xy, vec4<f32>(mapped / (1.0 + mapped), 1.0));
}
