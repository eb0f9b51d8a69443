// Every way out stores on its own: sky, unlit, lit.
@group(0) @binding(0) var depth: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(picture);
    if any(id.xy >= size) {
        return;
    }
    let z = textureLoad(depth, id.xy, 0);
    if z.x < 0.3 {
        textureStore(picture, id.xy, vec4(0.2, 0.4, 1.0, 1.0));
        return;
    }
    if z.y < 0.5 {
        textureStore(picture, id.xy, vec4(0.0, z.y, 0.0, 1.0));
        return;
    }
    var sum = 0.0;
    for (var i = 1u; i < 6u; i++) {
        if z.z > 0.9 {
            textureStore(picture, vec2<i32>(id.xy), vec4(1.0, sum, 0.0, 1.0));
            return;
        }
        sum += z.z / f32(i);
    }
    textureStore(picture, id.xy, vec4(sum, z.x, z.y, 1.0));
}
