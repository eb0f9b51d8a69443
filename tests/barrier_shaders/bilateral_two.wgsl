// A separable bilateral filter in one pass, with an apron of 3: rows, a barrier, columns.
struct Filter { range: f32, spatial: f32, }
@group(0) @binding(0) var<uniform> filter_: Filter;
@group(0) @binding(1) var ao_in: texture_2d<f32>;
@group(0) @binding(2) var depth_in: texture_2d<f32>;
@group(0) @binding(3) var ao_out: texture_storage_2d<r32float, write>;

const R: i32 = 3;
const W: i32 = 14; // 8 + 2 * 3

struct Sample { ao: f32, z: f32, }

var<workgroup> raw: array<Sample, 196>;
var<workgroup> rows: array<Sample, 112>;

fn weight(offset: i32, z: f32, other: f32) -> f32 {
    let d = f32(offset);
    let dz = (z - other) * filter_.range;
    return exp(-d * d * filter_.spatial - dz * dz);
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(workgroup_id) wg: vec3<u32>,
    @builtin(local_invocation_id) lid: vec3<u32>,
    @builtin(local_invocation_index) li: u32,
    @builtin(global_invocation_id) gid: vec3<u32>,
) {
    let size = vec2<i32>(textureDimensions(ao_in));
    let corner = vec2<i32>(wg.xy) * 8 - R;
    for (var k = i32(li); k < W * W; k += 64) {
        let at = clamp(corner + vec2<i32>(k % W, k / W), vec2<i32>(0), size - 1);
        raw[k] = Sample(textureLoad(ao_in, at, 0).x, textureLoad(depth_in, at, 0).x);
    }
    workgroupBarrier();

    // 8 columns of 14 rows
    for (var k = i32(li); k < 8 * W; k += 64) {
        let x = k % 8;
        let y = k / 8;
        let here = raw[y * W + x + R];
        var sum = 0.0;
        var total = 0.0;
        for (var o = -R; o <= R; o++) {
            let tap = raw[y * W + x + R + o];
            let w = weight(o, here.z, tap.z);
            sum += tap.ao * w;
            total += w;
        }
        rows[k] = Sample(sum / total, here.z);
    }
    workgroupBarrier();

    let x = i32(lid.x);
    let y = i32(lid.y);
    let here = rows[(y + R) * 8 + x];
    var sum = 0.0;
    var total = 0.0;
    for (var o = -R; o <= R; o++) {
        let tap = rows[(y + R + o) * 8 + x];
        let w = weight(o, here.z, tap.z);
        sum += tap.ao * w;
        total += w;
    }
    if all(vec2<i32>(gid.xy) < size) {
        textureStore(ao_out, gid.xy, vec4<f32>(sum / total, 0.0, 0.0, 0.0));
    }
}
