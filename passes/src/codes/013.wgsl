@group(0) @binding(0) var heights: texture_storage_2d<r32float, read_write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let left = textureLoad(heights, vec2<i32>(id.xy) - vec2(1, 0)).x; // here
    textureStore(heights, id.xy, vec4(left * 0.5));
}
