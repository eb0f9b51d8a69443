// Depth of field for one class of tiles; `vrcs_pixel` comes from the classifier's text, which stands before this one.

@group(0) @binding(0) var picture: texture_2d<f32>; // colour, and the circle of confusion in alpha
@group(0) @binding(1) var result: texture_storage_2d<rgba8unorm, write>;

// 0: nothing is blurred. 1: one radius for the whole tile will do. 2: each tap by its own.
override KIND: u32;

fn load(at: vec2<i32>) -> vec4<f32> {
    return textureLoad(picture, clamp(at, vec2(0), vec2<i32>(textureDimensions(picture)) - 1), 0);
}

@compute @workgroup_size(64)
fn blur(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let pixel = vrcs_pixel(group, index);
    if !pixel.is_inside {
        return;
    }
    let at = vec2<i32>(pixel.at);
    let here = load(at);
    var sum = vec4(here.rgb, 1.0);
    if KIND > 0u {
        for (var i = 0; i < 24; i++) {
            let turn = f32(i) * 2.399;
            let step = vec2(cos(turn), sin(turn)) * sqrt(f32(i) + 0.5) * here.a * 3.0;
            let there = load(at + vec2<i32>(round(step)));
            let weight = select(1.0, select(0.1, 1.0, there.a > here.a * 0.5), KIND == 2u);
            sum += vec4(there.rgb, 1.0) * weight;
        }
    }
    textureStore(result, pixel.at, vec4(sum.rgb / sum.w, 1.0));
}
