// A surface with textures: detail by gradients, in a helper that is handed its texture, too; and one mip level by choice.
struct Frame { width: u32, height: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var albedo: texture_2d<f32>;
@group(0) @binding(2) var detail: texture_2d<f32>;
@group(0) @binding(3) var blurred: texture_2d<f32>;
@group(0) @binding(4) var filtering: sampler;
@group(0) @binding(5) var picture: texture_storage_2d<rgba16float, write>;

fn twice(layer: texture_2d<f32>, at: vec2<f32>, dx: vec2<f32>, dy: vec2<f32>) -> vec4<f32> {
    let first = textureSampleGrad(layer, filtering, at, dx, dy);
    return first + textureSampleGrad(layer, filtering, at * 1.5, dx, dy, vec2(1, 0));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let at = (vec2<f32>(id.xy) + 0.5) / 64.0;
    let dx = vec2(1.0 / 64.0, 0.0);
    let dy = vec2(0.0, 1.0 / 64.0);
    var color = textureSampleGrad(albedo, filtering, at, dx, dy) + twice(detail, at, dx, dy);
    color += textureSampleLevel(blurred, filtering, at, 1.0) * 0.5;
    color += textureSampleLevel(albedo, filtering, at, 0.5) * 0.25;
    textureStore(picture, id.xy, color);
}
