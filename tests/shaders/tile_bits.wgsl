// Leaves alone what the renderer has marked tile by tile, as fog that covers all of it, and shades other marks by what they say.
fn vrcs_user() -> u32 { return 0u; }

@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba16float, write>;

const FOG: u32 = 1u;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let marks = vrcs_user();
    if (marks & FOG) != 0u {
        return;
    }
    let size = textureDimensions(picture);
    if any(id.xy >= size) {
        return;
    }
    let color = textureLoad(input, id.xy, 0).rgb + vec3(vec2<f32>(id.xy), 0.0);
    textureStore(picture, id.xy, vec4(color, f32(marks)));
}
