// options: {"scale_gradients": true, "bias_level": ["blurred"]}
@group(0) @binding(0) var albedo: texture_2d<f32>;
@group(0) @binding(1) var blurred: texture_2d<f32>;
@group(0) @binding(2) var filtering: sampler;
@group(0) @binding(3) var picture: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn shade(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = vec2<f32>(id.xy) / 64.0;
    let color = textureSampleGrad(albedo, filtering, at, vec2(0.02, 0.0), vec2(0.0, 0.02));
    textureStore(picture, id.xy, color * textureSampleLevel(blurred, filtering, at, 1.0));
}

// ---- becomes ----

@group(0) @binding(0)
var albedo: texture_2d<f32>;
@group(0) @binding(1)
var blurred: texture_2d<f32>;
@group(0) @binding(2)
var filtering: sampler;
@group(0) @binding(3)
var picture: texture_storage_2d<rgba16float,write>;

fn vrcs_rate() -> vec2<u32> {
    let _e3 = vrcs_copies;
    let _e11 = vrcs_copies;
    let across = select(select(1u, 2u, ((_e3 & 8738u) != 0u)), 4u, ((_e11 & 52428u) != 0u));
    let _e20 = vrcs_copies;
    let _e28 = vrcs_copies;
    let down = select(select(1u, 2u, ((_e20 & 240u) != 0u)), 4u, ((_e28 & 65280u) != 0u));
    return vec2<u32>(across, down);
}

fn vrcs_sample_albedo(at: vec2<f32>, dx: vec2<f32>, dy: vec2<f32>) -> vec4<f32> {
    let _e5 = vrcs_rate();
    let _e6 = vec2<f32>(_e5);
    let _e11 = textureSampleGrad(albedo, filtering, at, (dx * _e6.x), (dy * _e6.y));
    return _e11;
}

fn vrcs_sample_blurred(at_1: vec2<f32>, level: f32) -> vec4<f32> {
    let _e4 = vrcs_rate();
    let _e11 = textureSampleLevel(blurred, filtering, at_1, (level + f32(firstLeadingBit(max(_e4.x, _e4.y)))));
    return _e11;
}

fn vrcs_copy_picture(at_2: vec2<u32>, value: vec4<f32>) {
    let _e4 = vrcs_copies;
    if ((_e4 & 2u) != 0u) {
        let _e9 = vrcs_delta(1u);
        textureStore(picture, (at_2 + vec2<u32>(_e9)), value);
    }
    if ((_e4 & 16u) != 0u) {
        let _e17 = vrcs_delta(4u);
        textureStore(picture, (at_2 + vec2<u32>(_e17)), value);
    }
    if ((_e4 & 32u) != 0u) {
        let _e25 = vrcs_delta(5u);
        textureStore(picture, (at_2 + vec2<u32>(_e25)), value);
    }
    return;
}

fn shade_inner(id: vec3<u32>) {
    let at_3 = (vec2<f32>(id.xy) / vec2(64f));
    let _e14 = vrcs_sample_albedo(at_3, vec2<f32>(0.02f, 0f), vec2<f32>(0f, 0.02f));
    let _e16 = id.xy;
    let _e20 = vrcs_sample_blurred(at_3, 1f);
    let _e21 = (_e14 * _e20);
    vrcs_copy_picture(_e16, _e21);
    textureStore(picture, _e16, _e21);
    return;
}

@compute @workgroup_size(16, 16, 1)
fn shade(@builtin(workgroup_id) vrcs_group: vec3<u32>, @builtin(local_invocation_index) vrcs_lane: u32) {
    let _e2 = vrcs_prefix(vrcs_group, vrcs_lane);
    if !(_e2) {
        return;
    }
    let _e5 = vrcs_pixel;
    shade_inner(_e5);
    return;
}
