// options: {"targets": {"normals": "full"}}
@group(0) @binding(0) var packed: texture_2d<u32>;
@group(0) @binding(1) var normals: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(2) var color: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let n = unpack4x8snorm(textureLoad(packed, id.xy, 0).x);
    var light = vec4<f32>(0.0);
    for (var i = 0; i < 64; i++) {
        light += max(dot(n.xyz, vec3<f32>(f32(i), 1.0, 2.0)), 0.0) / 64.0;
    }
    textureStore(color, id.xy, light);
    textureStore(normals, id.xy, n * 0.5 + 0.5);
}

// ---- becomes ----

@group(0) @binding(0)
var packed: texture_2d<u32>;
@group(0) @binding(1)
var normals: texture_storage_2d<rgba8unorm,write>;
@group(0) @binding(2)
var color: texture_storage_2d<rgba8unorm,write>;

fn main_full(id: vec3<u32>) {
    var light: vec4<f32> = vec4(0f);
    var i: i32 = 0i;

    let _e4 = textureLoad(packed, id.xy, 0i);
    let n = unpack4x8snorm(_e4.x);
    textureStore(normals, id.xy, ((n * 0.5f) + vec4(0.5f)));
    return;
}

fn vrcs_copy_color(at: vec2<u32>, value: vec4<f32>) {
    let _e4 = vrcs_copies;
    if ((_e4 & 2u) != 0u) {
        let _e9 = vrcs_delta(1u);
        textureStore(color, (at + vec2<u32>(_e9)), value);
    }
    if ((_e4 & 16u) != 0u) {
        let _e17 = vrcs_delta(4u);
        textureStore(color, (at + vec2<u32>(_e17)), value);
    }
    if ((_e4 & 32u) != 0u) {
        let _e25 = vrcs_delta(5u);
        textureStore(color, (at + vec2<u32>(_e25)), value);
    }
    return;
}

fn main_inner(id_1: vec3<u32>) {
    var light_1: vec4<f32> = vec4(0f);
    var i_1: i32 = 0i;

    let _e4 = textureLoad(packed, id_1.xy, 0i);
    let n_1 = unpack4x8snorm(_e4.x);
    loop {
        let _e12 = i_1;
        if (_e12 < 64i) {
        } else {
            break;
        }
        {
            let _e15 = light_1;
            let _e17 = i_1;
            light_1 = (_e15 + vec4((max(dot(n_1.xyz, vec3<f32>(f32(_e17), 1f, 2f)), 0f) / 64f)));
        }
        continuing {
            let _e30 = i_1;
            i_1 = (_e30 + 1i);
        }
    }
    let _e33 = id_1.xy;
    let _e34 = light_1;
    vrcs_copy_color(_e33, _e34);
    textureStore(color, _e33, _e34);
    return;
}

@compute @workgroup_size(16, 16, 1)
fn main(@builtin(workgroup_id) vrcs_group: vec3<u32>, @builtin(local_invocation_index) vrcs_lane: u32) {
    let _e2 = vrcs_place(vrcs_group, vrcs_lane);
    let _e3 = vrcs_is_inside(_e2);
    if _e3 {
        main_full(_e2);
    }
    let _e4 = vrcs_prefix(vrcs_group, vrcs_lane);
    if !(_e4) {
        return;
    }
    let _e7 = vrcs_pixel;
    main_inner(_e7);
    return;
}
