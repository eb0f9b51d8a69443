// Depth of field: the largest circle in the tile decides how far to gather; sharp tiles and sharp pixels leave early.
struct Dof { size: vec2<u32>, focus: f32, strength: f32, samples: u32, }
@group(0) @binding(0) var<uniform> dof: Dof;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var out_color: texture_storage_2d<rgba16float, write>;
@group(0) @binding(4) var<storage, read_write> coc_out: array<f32>;
var<workgroup> widest: array<f32, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) gid: vec3<u32>, @builtin(local_invocation_index) i: u32) {
    let inside = all(gid.xy < dof.size);
    var radius = 0.0;
    if inside {
        radius = abs(textureLoad(depth, gid.xy, 0).x - dof.focus) * dof.strength;
    }
    widest[i] = radius;
    workgroupBarrier();
    if i < 32u { widest[i] = max(widest[i], widest[i + 32u]); }
    workgroupBarrier();
    if i < 16u { widest[i] = max(widest[i], widest[i + 16u]); }
    workgroupBarrier();
    if i < 8u { widest[i] = max(widest[i], widest[i + 8u]); }
    workgroupBarrier();
    if i < 4u { widest[i] = max(widest[i], widest[i + 4u]); }
    workgroupBarrier();
    if i < 2u { widest[i] = max(widest[i], widest[i + 2u]); }
    workgroupBarrier();
    if i == 0u { widest[0] = max(widest[0], widest[1]); }
    workgroupBarrier();
    if !inside { return; }
    let most = widest[0];
    coc_out[gid.y * dof.size.x + gid.x] = radius;
    let center = textureLoad(color, gid.xy, 0);
    if most < 0.05 {
        textureStore(out_color, gid.xy, center);
        return;
    }
    var sum = center;
    var total = 1.0;
    for (var s = 1u; s <= min(dof.samples, 12u); s++) {
        let angle = f32(s) * 2.399963;
        let offset = vec2<f32>(cos(angle), sin(angle)) * sqrt(f32(s)) * most;
        let at = clamp(vec2<i32>(gid.xy) + vec2<i32>(offset), vec2<i32>(0), vec2<i32>(dof.size) - 1);
        let z = textureLoad(depth, at, 0).x;
        if abs(z - dof.focus) * dof.strength < length(offset) * 0.1 {
            continue;
        }
        sum += textureLoad(color, at, 0);
        total += 1.0;
    }
    textureStore(out_color, gid.xy, sum / total);
}
