@group(0) @binding(0) var a: texture_storage_2d<rgba8unorm, write>;
@group(1) @binding(0) var b: texture_2d<f32>;
@group(2) @binding(0) var c: texture_2d<f32>;
@group(3) @binding(0) var d: texture_2d<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(a, id.xy, textureLoad(b, id.xy, 0) + textureLoad(c, id.xy, 0) + textureLoad(d, id.xy, 0));
}

// ---- is refused ----

error[VRCS004]: the shader uses all 4 bind groups; one has to be free for the parameters and the coordinate buffer
 = help: move the bindings of two groups into one
