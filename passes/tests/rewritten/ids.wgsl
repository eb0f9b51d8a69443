// All ids are impersonated as one set, in a struct and out of it.
struct Ids {
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
}
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 4)
fn main(ids: Ids, @builtin(num_workgroups) groups: vec3<u32>) {
    let at = ids.group.xy * vec2(8u, 4u) + ids.local.xy;
    textureStore(picture, at, vec4(f32(groups.x)));
}

// ---- becomes ----

struct Ids {
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
}

@group(0) @binding(0)
var picture: texture_storage_2d<rgba8unorm,write>;

fn vrcs_copy_picture(at: vec2<u32>, value: vec4<f32>) {
    let _e4 = vrcs_copies;
    if ((_e4 & 2u) != 0u) {
        let _e9 = vrcs_delta(1u);
        textureStore(picture, (at + vec2<u32>(_e9)), value);
    }
    if ((_e4 & 16u) != 0u) {
        let _e17 = vrcs_delta(4u);
        textureStore(picture, (at + vec2<u32>(_e17)), value);
    }
    if ((_e4 & 32u) != 0u) {
        let _e25 = vrcs_delta(5u);
        textureStore(picture, (at + vec2<u32>(_e25)), value);
    }
    return;
}

fn main_inner(ids: Ids, groups: vec3<u32>) {
    let at_1 = ((ids.group.xy * vec2<u32>(8u, 4u)) + ids.local.xy);
    let _e14 = vec4(f32(groups.x));
    vrcs_copy_picture(at_1, _e14);
    textureStore(picture, at_1, _e14);
    return;
}

@compute @workgroup_size(16, 16, 1)
fn main(@builtin(workgroup_id) vrcs_group: vec3<u32>, @builtin(local_invocation_index) vrcs_lane: u32) {
    let _e2 = vrcs_prefix(vrcs_group, vrcs_lane);
    if !(_e2) {
        return;
    }
    let _e5 = vrcs_pixel;
    let _e16 = vrcs_params.groups;
    main_inner(Ids((_e5 / vec3<u32>(8u, 4u, 1u)), (_e5 % vec3<u32>(8u, 4u, 1u))), _e16);
    return;
}
