// Reflections: one invocation counts the rays of its tile; a tile that needs none leaves as a whole, and so does a pixel.
struct Camera { proj: mat4x4<f32>, inv: mat4x4<f32>, size: vec2<f32>, steps: u32, thickness: f32 }
@group(0) @binding(0) var<uniform> cam: Camera;
@group(0) @binding(1) var depth: texture_2d<f32>;
@group(0) @binding(2) var normal: texture_2d<f32>;
@group(0) @binding(3) var rough: texture_2d<f32>;
@group(0) @binding(4) var out_reflection: texture_storage_2d<rgba16float, write>;
@group(0) @binding(5) var out_mask: texture_storage_2d<r32uint, write>;
var<workgroup> needs_ray: array<u32, 64>;
var<workgroup> any_ray: u32;
fn march(origin: vec2<f32>, dir: vec2<f32>, z: f32) -> vec3<f32> {
    var p = origin;
    for (var i = 0u; i < min(cam.steps, 16u); i++) {
        p += dir;
        if any(p < vec2<f32>(0.0)) || any(p >= cam.size) { return vec3<f32>(-1.0); }
        let d = textureLoad(depth, vec2<i32>(p), 0).x;
        if d > z && d - z < cam.thickness { return vec3<f32>(p, d); }
    }
    return vec3<f32>(-1.0);
}
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) i: u32) {
    let r = textureLoad(rough, id.xy, 0).x;
    let wants = r < 0.3 && all(vec2<f32>(id.xy) < cam.size);
    needs_ray[i] = select(0u, 1u, wants);
    workgroupBarrier();
    if i == 0u {
        var sum = 0u;
        for (var k = 0u; k < 64u; k++) { sum += needs_ray[k]; }
        any_ray = sum;
    }
    workgroupBarrier();
    let count = workgroupUniformLoad(&any_ray);
    textureStore(out_mask, id.xy, vec4<u32>(count));
    if count == 0u {
        textureStore(out_reflection, id.xy, vec4<f32>(0.0));
        return;
    }
    if !wants {
        textureStore(out_reflection, id.xy, vec4<f32>(0.0, 0.0, 0.0, 1.0));
        return;
    }
    let n = textureLoad(normal, id.xy, 0).xyz * 2.0 - 1.0;
    let hit = march(vec2<f32>(id.xy), n.xy * 2.0, textureLoad(depth, id.xy, 0).x);
    textureStore(out_reflection, id.xy, vec4<f32>(hit, f32(count)));
}
