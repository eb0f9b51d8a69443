// What the rasteriser would leave: spheres over a floor, their normals, depth and surface numbers.

@group(0) @binding(0) var surface: texture_storage_2d<rgba16float, write>;
@group(0) @binding(1) var surfaces: texture_storage_2d<r32uint, write>;

@compute @workgroup_size(8, 8)
fn fill(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(surface);
    if any(id.xy >= size) {
        return;
    }
    let at = (vec2<f32>(id.xy) * 2.0 - vec2<f32>(size)) / f32(size.y);
    var nearest = vec4(0.0, 0.0, -1.0, 1.0 + 0.3 * at.y);
    var number = 0u;
    for (var i = 0u; i < 9u; i++) {
        let middle = vec2(f32(i % 3u) - 1.0, f32(i / 3u) - 1.0) * vec2(0.9, 0.55);
        let away = (at - middle) / 0.28;
        let rest = 1.0 - dot(away, away);
        if rest > 0.0 {
            let height = sqrt(rest);
            nearest = vec4(away, -height, 0.7 - 0.28 * height);
            number = i + 1u;
        }
    }
    textureStore(surface, id.xy, nearest);
    textureStore(surfaces, id.xy, vec4(number));
}
