// Takes as many samples as its pixel stands for, and blurs as wide.
fn vrcs_rate() -> vec2<u32> { return vec2<u32>(1u); }

@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(picture);
    if any(id.xy >= size) {
        return;
    }
    let rate = vrcs_rate();
    var sum = vec4<f32>(0.0);
    for (var y = 0u; y < rate.y; y++) {
        for (var x = 0u; x < rate.x; x++) {
            sum += textureLoad(input, min(id.xy + vec2(x, y), size - 1u), 0);
        }
    }
    let mean = sum / f32(rate.x * rate.y);
    textureStore(picture, id.xy, vec4(mean.rgb + vec3(vec2<f32>(id.xy), 0.0), f32(rate.x * 16u + rate.y)));
}
