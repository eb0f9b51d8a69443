// A loop over batches of lights: load a batch, meet, shade with it, meet again. What is summed up lives through the loop.

struct Light {
    place: vec3<f32>,
    reach: f32,
    color: vec3<f32>,
    padding: f32,
}

struct Frame {
    size: vec2<u32>,
    lights: u32,
    exposure: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> lights: array<Light>;
@group(0) @binding(2) var albedo: texture_2d<f32>;
@group(0) @binding(3) var depths: texture_2d<f32>;
@group(0) @binding(4) var lit: texture_storage_2d<rgba16float, write>;

const BATCH: u32 = 64u;
var<workgroup> batch: array<Light, BATCH>;

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let is_active = all(gid.xy < frame.size);
    let place = vec3<f32>(vec2<f32>(gid.xy) / 64.0, textureLoad(depths, gid.xy, 0).x);
    let total = min(min(frame.lights, 150u), arrayLength(&lights));
    var sum = vec3<f32>(0.0);
    for (var first = 0u; first < total; first += BATCH) {
        if first + lane < total {
            batch[lane] = lights[first + lane];
        }
        workgroupBarrier();
        if is_active {
            let count = min(BATCH, total - first);
            for (var i = 0u; i < count; i++) {
                let way = batch[i].place - place;
                let reach = batch[i].reach;
                sum += batch[i].color * max(0.0, 1.0 - dot(way, way) / max(reach * reach, 0.001));
            }
        }
        workgroupBarrier();
    }
    if is_active {
        let color = textureLoad(albedo, gid.xy, 0).rgb * sum * frame.exposure;
        textureStore(lit, gid.xy, vec4<f32>(color, 1.0));
    }
}
