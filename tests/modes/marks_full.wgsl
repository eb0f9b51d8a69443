// Normals are stored for every pixel, each with its tile's marks; colours follow the rate.
fn vrcs_user() -> u32 { return 0u; }

@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var normals: texture_storage_2d<rgba32float, write>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(normals, id.xy, vec4(vec2<f32>(id.xy), f32(vrcs_user()), 1.0));
    let color = textureLoad(input, min(id.xy, textureDimensions(input) - 1u), 0).rgb;
    textureStore(picture, id.xy, vec4(color, f32(vrcs_user())));
}
