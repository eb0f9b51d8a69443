// Work for the workgroup and a store of what it finds out in one region: masked, with a warning, though the laws hold.
@group(0) @binding(0) var color: texture_2d<f32>;
@group(0) @binding(1) var shaded: texture_storage_2d<rgba32float, write>;
var<workgroup> sums: array<f32, 64>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) i: u32) {
    let c = textureLoad(color, id.xy, 0);
    sums[i] = c.x;
    workgroupBarrier();
    let left = sums[(i + 63u) % 64u];
    sums[i] = left * 0.5;
    textureStore(shaded, id.xy, vec4<f32>(left, sums[i], c.y, 1.0));
    workgroupBarrier();
}
