// Four targets of different formats, one of them written twice.
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var albedo: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(2) var normal: texture_storage_2d<rgba16float, write>;
@group(0) @binding(3) var material: texture_storage_2d<r32uint, write>;
@group(0) @binding(4) var motion: texture_storage_2d<rg32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let texel = textureLoad(input, id.xy, 0);
    textureStore(albedo, id.xy, vec4(0.0));
    textureStore(normal, id.xy, vec4(normalize(texel.xyz - 0.5), 0.0));
    textureStore(material, id.xy, vec4(pack4x8unorm(texel), 0u, 0u, 0u));
    textureStore(motion, id.xy, vec4(texel.xy - texel.zw, 0.0, 0.0));
    if texel.w > 0.25 {
        textureStore(albedo, id.xy, texel);
    }
}
