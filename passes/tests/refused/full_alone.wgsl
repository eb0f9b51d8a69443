// options: {"targets": {"picture": "full"}}
@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4<u32>(id.x));
}

// ---- is refused ----

error[VRCS021]: every target of `main` is `full`, so nothing would be saved
 = help: leave the shader as it is, or let one of the targets be copied
