@group(0) @binding(0) var a: texture_storage_2d<rgba8unorm, write>;
@group(1) @binding(0) var b: texture_2d<f32>;
@group(2) @binding(0) var c: texture_2d<f32>;
@group(3) @binding(0) var d: texture_2d<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(a, id.xy, textureLoad(b, id.xy, 0) + textureLoad(c, id.xy, 0) + textureLoad(d, id.xy, 0));
}

// ---- becomes ----

@group(0) @binding(0)
var a: texture_storage_2d<rgba8unorm,write>;
@group(1) @binding(0)
var b: texture_2d<f32>;
@group(2) @binding(0)
var c: texture_2d<f32>;
@group(3) @binding(0)
var d: texture_2d<f32>;

fn vrcs_copy_a(at: vec2<u32>, value: vec4<f32>) {
    let _e4 = vrcs_copies;
    if ((_e4 & 2u) != 0u) {
        let _e9 = vrcs_delta(1u);
        textureStore(a, (at + vec2<u32>(_e9)), value);
    }
    if ((_e4 & 16u) != 0u) {
        let _e17 = vrcs_delta(4u);
        textureStore(a, (at + vec2<u32>(_e17)), value);
    }
    if ((_e4 & 32u) != 0u) {
        let _e25 = vrcs_delta(5u);
        textureStore(a, (at + vec2<u32>(_e25)), value);
    }
    return;
}

fn main_inner(id: vec3<u32>) {
    let _e2 = id.xy;
    let _e6 = textureLoad(b, id.xy, 0i);
    let _e10 = textureLoad(c, id.xy, 0i);
    let _e15 = textureLoad(d, id.xy, 0i);
    let _e16 = ((_e6 + _e10) + _e15);
    vrcs_copy_a(_e2, _e16);
    textureStore(a, _e2, _e16);
    return;
}

@compute @workgroup_size(16, 16, 1)
fn main(@builtin(workgroup_id) vrcs_group: vec3<u32>, @builtin(local_invocation_index) vrcs_lane: u32) {
    let _e2 = vrcs_prefix(vrcs_group, vrcs_lane);
    if !(_e2) {
        return;
    }
    let _e5 = vrcs_pixel;
    main_inner(_e5);
    return;
}
