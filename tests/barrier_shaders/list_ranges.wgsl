// A list for each workgroup, read in batches: the bounds of the loop come from read-only memory by the id of the group.
@group(0) @binding(0) var color: texture_2d<f32>;
@group(0) @binding(1) var shaded: texture_storage_2d<rgba16float, write>;
@group(0) @binding(2) var<storage, read> list: array<u32>;
@group(0) @binding(3) var<storage, read> offsets: array<vec2<u32>>;
var<workgroup> t: array<u32, 64>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) i: u32, @builtin(workgroup_id) w: vec3<u32>, @builtin(num_workgroups) n: vec3<u32>) {
    let range = offsets[w.y * n.x + w.x];
    var c = textureLoad(color, id.xy, 0);
    var k = range.x;
    let end = range.x + min(range.y, 200u);
    loop {
        if k >= end { break; }
        t[i] = list[k + i];
        workgroupBarrier();
        let m = min(64u, end - k);
        for (var j = 0u; j < m; j++) { c += vec4<f32>(f32(t[j] & 255u) * 0.01); }
        workgroupBarrier();
        continuing { k += 64u; }
    }
    textureStore(shaded, id.xy, c);
}
