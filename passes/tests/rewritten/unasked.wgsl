// One invocation writes a counter, a quarter of them a smaller picture: nothing was said of either, so every pixel stores there for itself.
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(1) var small: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(2) var<storage, read_write> frames: array<u32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    var light = vec4<f32>(0.0);
    for (var i = 0u; i < 64u; i++) {
        light += fract(vec4<f32>(id.xyxy * i) * 0.37) / 64.0;
    }
    textureStore(picture, id.xy, light);
    if all(id.xy % 2u == vec2<u32>(0u)) {
        textureStore(small, id.xy / 2u, vec4<f32>(id.xyxy) / 64.0);
    }
    if all(id == vec3<u32>(0u)) {
        frames[0] = 1u;
    }
}

// ---- becomes ----

// warning[VRCS107]: `small` is stored for every pixel, since a store to `small` runs only for some ids and does not go to the pixel's own place; what that needs, 6 of 12 statements, is not saved
//    ┌─ unasked.wgsl:14:9
//    │
// 13 │     if all(id.xy % 2u == vec2<u32>(0u)) {
//    │        --- the condition on the ids
// 14 │         textureStore(small, id.xy / 2u, vec4<f32>(id.xyxy) / 64.0);
//    │         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ a copy would be lost when the invocation that runs it is a duplicate
//    │
//    = help: `--target small=full` says that this is meant; `--target small=copy` refuses the shader instead. Invocations beyond the logical extent do not run: where they store there, too, give it whole workgroups
//
// warning[VRCS107]: `frames` is stored for every pixel, since several invocations store to one place of `frames`; what that needs, 6 of 12 statements, is not saved
//    ┌─ unasked.wgsl:17:9
//    │
// 17 │         frames[0] = 1u;
//    │         ^^^^^^^^^^^^^^ the address depends on neither x nor y
//    │
//    = help: `--target frames=full` says that this is meant; `--target frames=copy` refuses the shader instead. Invocations beyond the logical extent do not run: where they store there, too, give it whole workgroups
//

@group(0) @binding(0)
var picture: texture_storage_2d<rgba8unorm,write>;
@group(0) @binding(1)
var small: texture_storage_2d<rgba8unorm,write>;
@group(0) @binding(2)
var<storage, read_write> frames: array<u32>;

fn main_full(id: vec3<u32>) {
    var light: vec4<f32> = vec4(0f);
    var i: u32 = 0u;

    if all(((id.xy % vec2(2u)) == vec2(0u))) {
        textureStore(small, (id.xy / vec2(2u)), (vec4<f32>(id.xyxy) / vec4(64f)));
    }
    if all((id == vec3(0u))) {
        frames[0] = 1u;
        return;
    } else {
        return;
    }
}

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

fn main_inner(id_1: vec3<u32>) {
    var light_1: vec4<f32> = vec4(0f);
    var i_1: u32 = 0u;

    loop {
        let _e6 = i_1;
        if (_e6 < 64u) {
        } else {
            break;
        }
        {
            let _e9 = light_1;
            let _e11 = i_1;
            light_1 = (_e9 + (fract((vec4<f32>((id_1.xyxy * _e11)) * 0.37f)) / vec4(64f)));
        }
        continuing {
            let _e22 = i_1;
            i_1 = (_e22 + 1u);
        }
    }
    let _e25 = id_1.xy;
    let _e26 = light_1;
    vrcs_copy_picture(_e25, _e26);
    textureStore(picture, _e25, _e26);
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
