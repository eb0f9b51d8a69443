// Short rays: ambient occlusion, and what mirror-like surfaces reflect. Needs REFLECTION_STEPS and OCCLUSION_RAYS besides.

const TRACES_SKY: bool = false;

// What the pass has found for a pixel: reflected light, and how open the place is.
fn traced_at(at: vec2<i32>) -> vec4<f32> {
    return textureLoad(traced, at, 0);
}

// A direction over a half-sphere, the same for a pixel in every frame.
fn spread(n: vec3<f32>, number: u32) -> vec3<f32> {
    let turned = f32(number) * 2.399963;
    let z = 1.0 - 2.0 * (f32(number) + 0.5) / f32(max(OCCLUSION_RAYS, 1u));
    let r = sqrt(max(1.0 - z * z, 0.0));
    return normalize(n * 1.02 + vec3<f32>(r * cos(turned), r * sin(turned), z));
}

@compute @workgroup_size(8, 8)
fn rays(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let at = vec2<i32>(id.xy);
    let seen = textureLoad(ids, at, 0).x & 0xffffu;
    if seen == SKY {
        textureStore(traced_out, at, vec4<f32>(0.0, 0.0, 0.0, 1.0));
        return;
    }
    let point = point_of(id.xy, textureLoad(depth, at, 0).x);
    let n = textureLoad(normals, at, 0).xyz;
    var open = 0.0;
    for (var i = 0u; i < OCCLUSION_RAYS; i++) {
        let hit = trace(point + n * 0.02, spread(n, i), 0.02, 1.5, 10u);
        open += select(smoothstep(0.0, 1.5, hit.distance), 1.0, hit.surface == SKY);
    }
    open = select(open / f32(max(OCCLUSION_RAYS, 1u)), 1.0, OCCLUSION_RAYS == 0u);
    var mirrored = vec3<f32>(0.0);
    let base = textureLoad(albedo, at, 0);
    let made = textureLoad(surface, at, 0);
    if REFLECTION_STEPS > 0u && made.r < 0.45 {
        let view = normalize(ray(frame.camera, vec2<f32>(id.xy) + 0.5));
        let bounced = reflect(view, n);
        let hit = trace(point + n * 0.03, bounced, 0.03, 20.0, REFLECTION_STEPS);
        let f0 = mix(vec3<f32>(0.04), base.rgb, base.a);
        let fresnel = f0 + (1.0 - f0) * pow(1.0 - max(dot(n, -view), 0.0), 5.0);
        var colour = sky_colour(bounced);
        if hit.surface != SKY {
            let there = point + n * 0.03 + bounced * hit.distance;
            let facing = scene_normal(there, hit.distance);
            let lamp = scene_light(0u);
            let away = normalize(lamp.position - there);
            let other = scene_material(there, facing, hit.surface);
            colour = other.colour * (0.25 + 0.5 * max(dot(facing, away), 0.0) + other.emission * 4.0);
        }
        mirrored = colour * fresnel * (1.0 - made.r / 0.45);
    }
    textureStore(traced_out, at, vec4<f32>(mirrored, open));
}

