@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;
var<workgroup> sums: array<u32, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    sums[lane] = id.x;
    if id.x < 100u { // here
        workgroupBarrier();
        textureStore(picture, id.xy, vec4<u32>(sums[63u - lane]));
    }
}
