// Cascades of probes, each read in batches: two uniform loops around two barriers, matrices that grow inside.
struct Cascade { origin: vec3<f32>, spacing: f32, first: u32, probes: u32, weight: f32, pad: u32, }
struct Info { cascades: u32, size: vec2<u32>, bias: f32, }
@group(0) @binding(0) var<uniform> info: Info;
@group(0) @binding(1) var<storage, read> cascades: array<Cascade>;
@group(0) @binding(2) var<storage, read> probes: array<vec4<f32>>;
@group(0) @binding(3) var normals: texture_2d<f32>;
@group(0) @binding(4) var irradiance: texture_storage_2d<rgba32float, write>;
var<workgroup> batch: array<vec4<f32>, 128>;

@compute @workgroup_size(16, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let n = textureLoad(normals, id.xy, 0).xyz * 2.0 - 1.0;
    var bands = mat3x3<f32>();
    var best = vec2<f32>(1e9, 0.0);
    for (var c = 0u; c < min(info.cascades, 3u); c++) {
        let cascade = cascades[c];
        let last = min(cascade.probes, 300u);
        var local_sum = mat3x3<f32>();
        var first = 0u;
        while first < last {
            workgroupBarrier();
            batch[lane] = probes[cascade.first + first + lane];
            workgroupBarrier();
            for (var k = 0u; k < min(128u, last - first); k += 16u) {
                let p = batch[k];
                local_sum[0] += p.xyz * n.x;
                local_sum[1] += p.xyz * n.y;
                local_sum[2] += p.xyz * n.z;
                let d = distance(p.xyz, n);
                if d < best.x {
                    best = vec2<f32>(d, p.w);
                }
            }
            first += 128u;
        }
        bands = bands + local_sum * cascade.weight;
    }
    if all(id.xy < info.size) {
        textureStore(irradiance, id.xy, vec4<f32>(bands * n, best.y + info.bias));
    }
}
