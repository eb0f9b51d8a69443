// A uniform switch that holds barriers in some of its cases.
struct P { kind: u32, size: vec2<u32> }
@group(0) @binding(0) var<uniform> p: P;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var shaded: texture_storage_2d<rgba16float, write>;
var<workgroup> t: array<vec4<f32>, 64>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) i: u32) {
    var c = textureLoad(color, id.xy, 0);
    switch p.kind & 3u {
        case 0u, 1u: {
            t[i] = c;
            workgroupBarrier();
            c = t[i ^ 1u] + c;
        }
        case 2u: {
            t[i] = c * c;
            workgroupBarrier();
            c = t[i ^ 8u];
            workgroupBarrier();
            t[i] = c;
            workgroupBarrier();
            c += t[63u - i];
        }
        default: { c = c.wzyx; }
    }
    if id.x < p.size.x && id.y < p.size.y { textureStore(shaded, id.xy, c); }
}
