// One store runs under a uniform, another for some pixels: where the uniform does not hold, the domain is those pixels alone.

struct Frame { gain: f32 }

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let texel = textureLoad(input, id.xy, 0);
    if frame.gain > 0.5 {
        textureStore(picture, id.xy, texel.yxzw * 0.5);
    }
    if id.x % 4u < 2u {
        textureStore(picture, id.xy, texel);
    }
}
