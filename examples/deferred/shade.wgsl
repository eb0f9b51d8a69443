// Three passes over one G-buffer: occlusion, lighting, and fog over both.

struct Frame {
    size: vec2<u32>,
    time: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var surface: texture_2d<f32>; // normal.xyz, depth
@group(0) @binding(2) var occlusion: texture_2d<f32>;
@group(0) @binding(3) var lit: texture_2d<f32>;
@group(0) @binding(4) var stored: texture_storage_2d<rgba16float, write>;

fn load(at: vec2<i32>) -> vec4<f32> {
    return textureLoad(surface, clamp(at, vec2(0), vec2<i32>(frame.size) - 1), 0);
}

@compute @workgroup_size(8, 8)
fn occlude(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let here = load(vec2<i32>(id.xy));
    var open = 0.0;
    for (var i = 0; i < 16; i++) {
        let turn = f32(i) * 2.399;
        let step = vec2(cos(turn), sin(turn)) * (2.0 + f32(i));
        let there = load(vec2<i32>(id.xy) + vec2<i32>(step));
        open += select(0.0, 1.0, there.w >= here.w - 0.02);
    }
    textureStore(stored, id.xy, vec4(open / 16.0));
}

@compute @workgroup_size(8, 8)
fn light(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let here = load(vec2<i32>(id.xy));
    let at = vec3((vec2<f32>(id.xy) * 2.0 - vec2<f32>(frame.size)) / f32(frame.size.y), here.w);
    var sum = vec3(0.03);
    for (var i = 0u; i < 32u; i++) {
        let turn = f32(i) * 2.399 + frame.time;
        let to = vec3(cos(turn) * (0.3 + 0.04 * f32(i)), sin(turn) * 0.8, -0.4) - at;
        let hue = vec3(1.0, 0.8, 0.6) + 0.4 * sin(vec3(0.0, 2.0, 4.0) + f32(i));
        sum += hue * max(dot(here.xyz, normalize(to)), 0.0) / (0.2 + dot(to, to)) * 0.06;
    }
    textureStore(stored, id.xy, vec4(sum * textureLoad(occlusion, id.xy, 0).x, 1.0));
}

@compute @workgroup_size(8, 8)
fn composite(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let fog = smoothstep(0.4, 1.6, load(vec2<i32>(id.xy)).w);
    let color = mix(textureLoad(lit, id.xy, 0).rgb, vec3(0.10, 0.12, 0.16), fog);
    textureStore(stored, id.xy, vec4(pow(color / (1.0 + color), vec3(1.0 / 2.2)), 1.0));
}
