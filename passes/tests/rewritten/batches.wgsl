@group(0) @binding(0) var<uniform> count: u32;
@group(0) @binding(1) var<storage, read> lights: array<vec4<f32>>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba8unorm, write>;

var<workgroup> batch: array<vec4<f32>, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let place = vec2<f32>(id.xy);
    var sum = vec4<f32>(0.0);
    for (var first = 0u; first < count; first += 64u) {
        batch[lane] = lights[first + lane];
        workgroupBarrier();
        for (var i = 0u; i < 64u; i++) {
            sum += batch[i] / distance(batch[i].xy, place);
        }
        workgroupBarrier();
    }
    textureStore(picture, id.xy, sum);
}

// ---- becomes ----

@group(0) @binding(0)
var<uniform> count: u32;
@group(0) @binding(1)
var<storage> lights: array<vec4<f32>>;
@group(0) @binding(2)
var picture: texture_storage_2d<rgba8unorm,write>;
var<workgroup> batch: array<vec4<f32>, 64>;
var<private> vrcs_slot: u32;

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

fn main_inner(id: vec3<u32>, lane_2: u32, vrcs_own_id: vec3<u32>, vrcs_own_lane: u32) {
    var sum: vec4<f32> = vec4(0f);
    var first: u32 = 0u;
    var i: u32;
    var vrcs_own_place: vec2<f32>;

    let _e52 = vrcs_on;
    if _e52 {
        let place_1 = vec2<f32>(vrcs_own_id.xy);
        vrcs_own_place = place_1;
    }
    loop {
        let _e9 = first;
        let _e11 = count;
        if (_e9 < _e11) {
        } else {
            break;
        }
        {
            let _e16 = first;
            let _e19 = lights[(_e16 + lane_2)];
            batch[lane_2] = _e19;
            workgroupBarrier();
            let _e56 = vrcs_on;
            if _e56 {
                let _e57 = vrcs_own_place;
                i = 0u;
                loop {
                    let _e60 = i;
                    if (_e60 < 64u) {
                    } else {
                        break;
                    }
                    {
                        let _e63 = sum;
                        let _e65 = i;
                        let _e67 = batch[_e65];
                        let _e69 = i;
                        let _e71 = batch[_e69];
                        sum = (_e63 + (_e67 / vec4(distance(_e71.xy, _e57))));
                    }
                    continuing {
                        let _e79 = i;
                        i = (_e79 + 1u);
                    }
                }
            }
            workgroupBarrier();
        }
        continuing {
            let _e42 = first;
            first = (_e42 + 64u);
        }
    }
    let _e83 = vrcs_on;
    if _e83 {
        let _e84 = vrcs_own_id.xy;
        let _e86 = sum;
        vrcs_copy_picture(_e84, _e86);
        textureStore(picture, _e84, _e86);
        return;
    }
}

@compute @workgroup_size(8, 8, 1)
fn main(@builtin(workgroup_id) vrcs_group: vec3<u32>, @builtin(local_invocation_index) vrcs_lane_index: u32, @builtin(global_invocation_id) vrcs_id: vec3<u32>, @builtin(local_invocation_id) vrcs_local: vec3<u32>) {
    let _e4 = vrcs_tile_is_empty(vrcs_group);
    if _e4 {
        return;
    }
    vrcs_group_begin(vrcs_group, vrcs_id, vrcs_lane_index, vec2<u32>(8u, 8u));
    let _e8 = vrcs_pixel;
    main_inner(vrcs_id, vrcs_lane_index, _e8, (((((_e8.z % 1u) * 8u) + (_e8.y % 8u)) * 8u) + (_e8.x % 8u)));
    return;
}
