// The passes of every scene, in the order in which a frame runs them.
//
// A scene gives: `scene_distance(p, time)`, `scene_material(p, normal, surface)`, `scene_light(i)`, LIGHTS, `sky_colour(direction)`,
// `moved(p, surface)`: where a point was one frame ago, `triangle_of(p, surface)`, and the constants STEPS, LIGHTS, SHADOWS,
// SHADOW_STEPS, FOG and GRAIN. rays.wgsl, atmosphere.wgsl or, in a scene with neither, norays.wgsl gives `traced_at` and TRACES_SKY; motion.wgsl or, in a
// scene without motion vectors, nomotion.wgsl gives `note_motion_of` and `note_motion_of_sky`.

fn scene_normal(p: vec3<f32>, scale: f32) -> vec3<f32> {
    let e = vec2<f32>(1.0, -1.0) * max(0.0006, scale * 0.0006);
    let a = scene_distance(p + e.xyy, frame.time).distance;
    let b = scene_distance(p + e.yyx, frame.time).distance;
    let c = scene_distance(p + e.yxy, frame.time).distance;
    let d = scene_distance(p + e.xxx, frame.time).distance;
    return normalize(e.xyy * a + e.yyx * b + e.yxy * c + e.xxx * d + vec3<f32>(1e-9, 2e-9, 1e-9));
}

// Follows a ray. `direction` need not be a unit vector; the distance is in its units.
fn trace(origin: vec3<f32>, direction: vec3<f32>, from_distance: f32, far: f32, steps: u32) -> Hit {
    let unit = length(direction);
    var travelled = from_distance;
    for (var i = 0u; i < steps; i++) {
        let hit = scene_distance(origin + direction * travelled, frame.time);
        if hit.distance < 0.0008 * travelled * unit {
            return Hit(travelled, hit.surface);
        }
        travelled += hit.distance / unit;
        if travelled > far {
            break;
        }
    }
    return Hit(far, SKY);
}

// Stands for the rasteriser: what each pixel shows and, in a scene with motion vectors, where it was. Never variable-rate.
@compute @workgroup_size(8, 8)
fn geometry(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let camera = frame.camera;
    let direction = ray(camera, vec2<f32>(id.xy) + 0.5);
    let hit = trace(camera.position, direction, camera.near, camera.far, STEPS);
    let at = vec2<i32>(id.xy);
    if hit.surface == SKY {
        note_motion_of_sky(id.xy, direction);
        textureStore(ids_out, at, vec4<u32>(0u));
        textureStore(depth_out, at, vec4<f32>(0.0));
        textureStore(normal_out, at, vec4<f32>(0.0, 1.0, 0.0, 0.0));
        return;
    }
    let point = camera.position + direction * hit.distance;
    let normal = scene_normal(point, hit.distance);
    note_motion_of(id.xy, point, hit.surface);
    let triangle = triangle_of(point, hit.surface) & 0xffffu;
    textureStore(ids_out, at, vec4<u32>(hit.surface | triangle << 16u, 0u, 0u, 0u));
    textureStore(depth_out, at, vec4<f32>(camera.near / hit.distance, 0.0, 0.0, 0.0));
    textureStore(normal_out, at, vec4<f32>(normal, 0.0));
}

// Textures: colour, roughness and the like, of what each pixel shows.
@compute @workgroup_size(8, 8)
fn material(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let at = vec2<i32>(id.xy);
    let seen = textureLoad(ids, at, 0).x & 0xffffu;
    if seen == SKY {
        textureStore(albedo_out, at, vec4<f32>(0.0));
        textureStore(surface_out, at, vec4<f32>(1.0, 0.0, 0.0, 0.0));
        return;
    }
    let point = point_of(id.xy, textureLoad(depth, at, 0).x);
    let made = scene_material(point, textureLoad(normals, at, 0).xyz, seen);
    textureStore(albedo_out, at, vec4<f32>(made.colour, made.metal));
    textureStore(surface_out, at, vec4<f32>(made.roughness, made.emission, made.translucency, 0.0));
}

// How a surface sends light on: a diffuse part, and Trowbridge and Reitz's lobe with Schlick's Fresnel term.
fn reflected(n: vec3<f32>, v: vec3<f32>, l: vec3<f32>, colour: vec3<f32>, metal: f32, roughness: f32) -> vec3<f32> {
    let facing = max(dot(n, l), 0.0);
    let h = normalize(v + l);
    let a = max(roughness * roughness, 0.002);
    let nh = max(dot(n, h), 0.0);
    let d = nh * nh * (a * a - 1.0) + 1.0;
    let lobe = a * a / (PI * d * d);
    let k = (roughness + 1.0) * (roughness + 1.0) / 8.0;
    let nv = max(dot(n, v), 0.001);
    let visible = 1.0 / ((nv * (1.0 - k) + k) * (facing * (1.0 - k) + k) * 4.0 + 0.001);
    let f0 = mix(vec3<f32>(0.04), colour, metal);
    let fresnel = f0 + (1.0 - f0) * pow(1.0 - max(dot(h, v), 0.0), 5.0);
    return (colour * (1.0 - metal) / PI + fresnel * lobe * visible) * facing;
}

// Every light on every pixel, and shadows of the first few.
@compute @workgroup_size(8, 8)
fn lighting(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let at = vec2<i32>(id.xy);
    let direction = normalize(ray(frame.camera, vec2<f32>(id.xy) + 0.5));
    let seen = textureLoad(ids, at, 0).x & 0xffffu;
    if seen == SKY {
        textureStore(light_out, at, vec4<f32>(sky_colour(direction), 1.0));
        return;
    }
    let inverse = textureLoad(depth, at, 0).x;
    let point = point_of(id.xy, inverse);
    let n = textureLoad(normals, at, 0).xyz;
    let base = textureLoad(albedo, at, 0);
    let made = textureLoad(surface, at, 0);
    var sum = base.rgb * (0.06 * sky_colour(n) + made.g * 4.0);
    for (var i = 0u; i < LIGHTS; i++) {
        let lamp = scene_light(i);
        let away = lamp.position - point;
        let far = length(away);
        let l = away / max(far, 1e-4);
        let window = max(1.0 - pow(far / lamp.radius, 4.0), 0.0);
        let strength = window * window / (far * far + 0.3);
        var lit = reflected(n, -direction, l, base.rgb, base.a, made.r);
        // what is behind a thin leaf shines through
        lit += base.rgb * (made.b * max(-dot(n, l), 0.0) / PI);
        if i < SHADOWS && strength > 1e-4 {
            let hit = trace(point + n * 0.02, l, 0.02, min(far, 24.0), SHADOW_STEPS);
            if hit.surface != SKY {
                lit = vec3<f32>(0.0);
            }
        }
        sum += lit * lamp.colour * strength;
    }
    textureStore(light_out, at, vec4<f32>(min(sum, vec3<f32>(4000.0)), 1.0));
}

// How strong grain is, 0 to 1: it lies in the haze, so that there is none close by and none in the sky.
fn grain_at(inverse: f32) -> f32 {
    return select(0.0, smoothstep(20.0, 90.0, frame.camera.near / max(inverse, 1e-6)), inverse > 0.0);
}

// Puts the picture together: fog, tone curve, grain.
@compute @workgroup_size(8, 8)
fn composite(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let at = vec2<i32>(id.xy);
    let inverse = textureLoad(depth, at, 0).x;
    // where nothing is traced from the sky, the pass that traces may skip it
    var rays_seen = vec4<f32>(0.0, 0.0, 0.0, 1.0);
    if inverse > 0.0 || TRACES_SKY {
        rays_seen = traced_at(at);
    }
    var colour = textureLoad(light, at, 0).rgb * rays_seen.a + rays_seen.rgb;
    if FOG > 0.0 && inverse > 0.0 {
        let direction = normalize(ray(frame.camera, vec2<f32>(id.xy) + 0.5));
        let point = point_of(id.xy, inverse);
        let far = distance(point, frame.camera.position);
        // fog lies low and drifts
        var thick = 0.0;
        for (var i = 0u; i < 6u; i++) {
            let along = frame.camera.position + direction * (far * (f32(i) + 0.5) / 6.0);
            let drift = along.xz * 0.11 + vec2<f32>(frame.time * 0.4, 0.0);
            thick += exp(-max(along.y, 0.0) * 0.35) * (0.4 + 1.2 * rough_noise(drift, 3u));
        }
        let clear = exp(-FOG * far * thick / 6.0);
        colour = mix(sky_colour(vec3<f32>(direction.x, 0.08, direction.z)), colour, clear);
    }
    // Narkowicz's fit of the ACES curve, then display encoding
    let c = colour * 0.8;
    let curved = clamp(c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14), vec3<f32>(0.0), vec3<f32>(1.0));
    var shown = pow(curved, vec3<f32>(1.0 / 2.2));
    if GRAIN > 0.0 {
        shown += GRAIN * grain_at(inverse) * (chance(id.x + 8192u * id.y + 0x3779b9u * frame.number) - 0.5);
    }
    textureStore(picture, at, vec4<f32>(shown, 1.0));
}
