// A workgroup of 32 invocations in a row of its own, which hands its running sums on.

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var sums: texture_storage_2d<rgba16float, write>;

var<workgroup> row: array<f32, 32>;

@compute @workgroup_size(32, 1)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_id) lid: vec3<u32>,
) {
    let color = textureLoad(image, gid.xy, 0);
    row[lid.x] = color.x;
    workgroupBarrier();
    var sum = 0.0;
    for (var i = 0u; i <= lid.x; i++) {
        sum += row[i];
    }
    textureStore(sums, gid.xy, vec4(sum, color.yzw));
}
