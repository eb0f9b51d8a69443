// options: {"targets": {"frames": "copy"}}
// A counter that one invocation writes would be lost when that invocation is a duplicate.
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(1) var<storage, read_write> frames: array<u32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4(1.0));
    if all(id == vec3(0u)) {
        frames[0] = 1u;
    }
}

// ---- is refused ----

error[VRCS011]: several invocations store to one place of `frames`
   ┌─ counter.wgsl:10:9
   │
10 │         frames[0] = 1u;
   │         ^^^^^^^^^^^^^^ the address depends on neither x nor y
   │
   = help: move this store to an entry point of its own
