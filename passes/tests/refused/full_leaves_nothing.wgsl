// options: {"targets": {"picture": "full"}}
@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;
@group(0) @binding(1) var<storage, read_write> sound: array<u32, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4<u32>(id.x));
    if id.y == 0u && id.x < 64u {
        sound[id.x] = id.x;
    }
}

// ---- is refused ----

error[VRCS021]: beside `picture`, which every pixel stores, nothing is stored per pixel, so nothing would be saved
 = help: leave the shader as it is, or let the target be copied
