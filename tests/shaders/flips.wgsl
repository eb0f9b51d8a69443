// Uniforms say whether the place is transposed and whether it is mirrored; the pixel that is read stays its own.
@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var target_: texture_storage_2d<rgba16float, write>;
@group(0) @binding(2) var<uniform> turn: vec4<i32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(target_);
    var place = id.xy;
    if turn.x != 0 { place = place.yx; }
    if (turn.y & 1) == 1 { place.y = size.y - 1u - place.y; }
    textureStore(target_, place, textureLoad(source, id.xy, 0));
}
