// What the air does, by marching along each pixel's ray: clouds in a layer high above, lit through themselves, and shafts of sunlight in
// the haze, in the shadow of hills, towers and clouds. The heavy pass of an open scene, as volumetric clouds and fog are in games.
// Needs SUN, `solid`, and CLOUDS_FROM and CLOUDS_TO, the heights between which clouds are.

// Clouds are seen in the sky as well.
const TRACES_SKY: bool = true;

const CLOUD_STEPS: u32 = 40u;
const CLOUD_LIGHT_STEPS: u32 = 6u;
const SHAFT_STEPS: u32 = 14u;
const SHAFT_SHADOW_STEPS: u32 = 5u;
// Shafts end here, and the clouds' march is no longer than that.
const SHAFTS_TO: f32 = 130.0;
const CLOUDS_MOST: f32 = 900.0;

// What the pass has found for a pixel: light from the air, and how much of what lies behind is seen through it.
fn traced_at(at: vec2<i32>) -> vec4<f32> {
    return textureLoad(traced, at, 0);
}

fn chance_at_cell(cell: vec3<i32>) -> f32 {
    let c = bitcast<vec3<u32>>(cell);
    return chance(c.x * 0x85ebca6bu ^ c.y * 0xc2b2ae35u ^ c.z * 0x27d4eb2fu);
}

// Value noise in space, 0 to 1.
fn noise_in_space(p: vec3<f32>) -> f32 {
    let cell = vec3<i32>(floor(p));
    let t = smoothstep(vec3<f32>(0.0), vec3<f32>(1.0), fract(p));
    var layers: vec2<f32>;
    for (var k = 0; k < 2; k++) {
        let at = cell + vec3<i32>(0, 0, k);
        let low = mix(chance_at_cell(at), chance_at_cell(at + vec3<i32>(1, 0, 0)), t.x);
        let high = mix(chance_at_cell(at + vec3<i32>(0, 1, 0)), chance_at_cell(at + vec3<i32>(1, 1, 0)), t.x);
        layers[k] = mix(low, high, t.y);
    }
    return mix(layers.x, layers.y, t.z);
}

// How dense clouds are at a place, 0 to 1, with so many octaves of detail.
fn cloud_at(p: vec3<f32>, octaves: u32) -> f32 {
    let along = (p.y - CLOUDS_FROM) / (CLOUDS_TO - CLOUDS_FROM);
    if along <= 0.0 || along >= 1.0 {
        return 0.0;
    }
    // flat below, heaped above
    let body = smoothstep(0.0, 0.15, along) * smoothstep(1.0, 0.4, along);
    var sum = 0.0;
    var weight = 0.5;
    var at = vec3<f32>(p.x + 6.0 * frame.time, p.y * 1.6, p.z) * 0.014;
    for (var i = 0u; i < octaves; i++) {
        sum += weight * noise_in_space(at);
        at = at * 2.1 + vec3<f32>(3.1, 7.7, 1.3);
        weight *= 0.5;
    }
    // fewer octaves are as dense on the mean as all
    let mean = 0.5 - weight;
    return clamp((sum - mean + 0.06) * 4.0, 0.0, 1.0) * body;
}

// How much sunlight comes through the clouds to a place in them.
fn sun_through_clouds(p: vec3<f32>) -> f32 {
    var thick = 0.0;
    for (var i = 0u; i < CLOUD_LIGHT_STEPS; i++) {
        thick += cloud_at(p + SUN * (5.0 * (f32(i) + 0.5)), 3u);
    }
    return exp(-0.32 * thick);
}

// Clouds along a ray: light, and what is seen through them.
fn clouds(direction: vec3<f32>) -> vec4<f32> {
    if direction.y < 0.03 {
        return vec4<f32>(0.0, 0.0, 0.0, 1.0);
    }
    let origin = frame.camera.position;
    let enters = (CLOUDS_FROM - origin.y) / direction.y;
    let leaves = min((CLOUDS_TO - origin.y) / direction.y, enters + CLOUDS_MOST);
    let step = (leaves - enters) / f32(CLOUD_STEPS);
    var light = vec3<f32>(0.0);
    var clear = 1.0;
    for (var i = 0u; i < CLOUD_STEPS; i++) {
        let p = origin + direction * (enters + step * (f32(i) + 0.5));
        let dense = cloud_at(p, 4u);
        if dense > 0.01 {
            let lit = vec3<f32>(1.0, 0.9, 0.75) * (1.6 * sun_through_clouds(p)) + vec3<f32>(0.32, 0.38, 0.48);
            let through = exp(-0.05 * dense * step);
            light += clear * (1.0 - through) * lit;
            clear *= through;
            if clear < 0.02 {
                break;
            }
        }
    }
    // far clouds fade into the haze of the horizon
    let seen = smoothstep(0.03, 0.16, direction.y);
    return vec4<f32>(light * seen, mix(1.0, clear, seen));
}

// Whether the sun reaches a place in the haze: no hill, tower or cloud is in the way, as far as a few steps tell.
fn sun_reaches(p: vec3<f32>) -> f32 {
    var open = 1.0;
    var away = 1.5;
    for (var i = 0u; i < SHAFT_SHADOW_STEPS; i++) {
        let left = solid(p + SUN * away).distance;
        open = min(open, clamp(0.5 + 3.0 * left / away, 0.0, 1.0));
        away *= 1.9;
    }
    let above = p + SUN * ((CLOUDS_FROM + 12.0 - p.y) / SUN.y);
    return open * (1.0 - 0.85 * cloud_at(above, 2u));
}

// Sunlight that haze sends along a ray, up to a distance.
fn shafts(direction: vec3<f32>, far: f32) -> vec3<f32> {
    let origin = frame.camera.position;
    let step = min(far, SHAFTS_TO) / f32(SHAFT_STEPS);
    var sum = 0.0;
    for (var i = 0u; i < SHAFT_STEPS; i++) {
        let p = origin + direction * (step * (f32(i) + 0.5));
        let haze = exp(-max(p.y, 0.0) * 0.09);
        if haze > 0.02 {
            sum += haze * step * sun_reaches(p);
        }
    }
    // Henyey and Greenstein's phase function, forwards
    let cosine = dot(direction, SUN);
    let phase = 0.64 / (4.0 * PI * pow(1.36 - 1.2 * cosine, 1.5));
    return vec3<f32>(1.0, 0.82, 0.6) * (0.028 * phase * sum);
}

@compute @workgroup_size(8, 8)
fn atmosphere(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let at = vec2<i32>(id.xy);
    let along = ray(frame.camera, vec2<f32>(id.xy) + 0.5);
    let direction = normalize(along);
    let inverse = textureLoad(depth, at, 0).x;
    var found = vec4<f32>(0.0, 0.0, 0.0, 1.0);
    var far = SHAFTS_TO;
    if inverse > 0.0 {
        far = frame.camera.near / inverse * length(along);
    } else {
        found = clouds(direction);
    }
    textureStore(traced_out, at, vec4<f32>(found.rgb + shafts(direction, far), found.a));
}
