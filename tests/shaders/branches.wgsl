// Stores in both arms of branches and in a switch with a case that stores nothing.
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var a: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(2) var b: texture_storage_2d<r32float, write>;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let v = textureLoad(input, id.xy, 0);
    if v.x > 0.5 {
        textureStore(a, id.xy, v);
    } else {
        textureStore(a, id.xy, v.wzyx);
        textureStore(b, id.xy, vec4(v.x * 3.0));
    }
    switch u32(v.y * 5.0) {
        case 0u: { textureStore(b, id.xy, vec4(v.z)); }
        case 1u, 2u: { textureStore(b, id.xy, vec4(-v.w)); }
        case 3u: {}
        default: { textureStore(b, id.xy, vec4(7.0)); }
    }
}
