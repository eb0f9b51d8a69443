// A lighting pass as anyone might have it: nothing in it knows of variable rate.

struct Frame {
    size: vec2<u32>,
    time: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

const LIGHTS: u32 = 48u;

fn light_at(index: u32) -> vec3<f32> {
    let turn = f32(index) * 2.399 + frame.time * (0.2 + 0.01 * f32(index));
    let far = 0.15 + 0.07 * f32(index);
    return vec3(cos(turn) * far, sin(turn) * far * 0.6, 0.12 + 0.01 * f32(index % 7u));
}

// A floor of tiles, smooth within a tile and sharp at its border.
fn albedo(at: vec2<f32>) -> vec3<f32> {
    let tile = floor(at * 5.0);
    let inside = fract(at * 5.0);
    let joint = smoothstep(0.01, 0.05, min(min(inside.x, inside.y), 1.0 - max(inside.x, inside.y)));
    let shade = 0.35 + 0.4 * fract(sin(dot(tile, vec2(12.99, 78.23))) * 43758.5);
    return vec3(shade, shade * 0.9, shade * 0.7) * mix(0.2, 1.0, joint);
}

@compute @workgroup_size(8, 8)
fn light(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let at = (vec2<f32>(id.xy) * 2.0 - vec2<f32>(frame.size)) / f32(frame.size.y);
    var sum = vec3(0.02);
    for (var i = 0u; i < LIGHTS; i++) {
        let to = light_at(i) - vec3(at, 0.0);
        let hue = vec3(1.0, 0.8, 0.6) + 0.4 * sin(vec3(0.0, 2.0, 4.0) + f32(i));
        sum += hue * to.z / pow(dot(to, to), 1.5) * 0.015;
    }
    let lit = albedo(at) * sum;
    textureStore(picture, id.xy, vec4(pow(lit / (1.0 + lit), vec3(1.0 / 2.2)), 1.0));
}
