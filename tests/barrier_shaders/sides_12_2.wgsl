// A workgroup of 12 by 2: the largest rate is what divides its sides. Each pixel meets its opposite in the workgroup.

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var result: texture_storage_2d<rgba16float, write>;

const SIZE = vec2<u32>(12u, 2u);

var<workgroup> group_colors: array<vec4<f32>, 24>;

@compute @workgroup_size(12, 2)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_id) lid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let own = textureLoad(image, gid.xy, 0);
    group_colors[lane] = own;
    workgroupBarrier();
    let across = SIZE - 1u - lid.xy;
    let opposite = group_colors[across.y * SIZE.x + across.x];
    if all(gid.xy < textureDimensions(result)) {
        textureStore(result, gid.xy, own * 0.75 + opposite + vec4(vec2<f32>(gid.xy), vec2<f32>(lid.xy)));
    }
}
