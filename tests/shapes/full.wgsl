// Normals, a count and a row's notes for every pixel; the light of a loop at variable rate. A helper stores to both sides.
struct Frame { size: vec2<u32>, lights: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var normals: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(3) var color: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(4) var<storage, read_write> bright: array<atomic<u32>, 4>;
@group(0) @binding(5) var<storage, read_write> note: array<u32, 16>;
@group(0) @binding(6) var<storage, read_write> history: array<f32>;

fn put(at: vec2<u32>, normal: vec4<f32>, light: vec4<f32>) -> f32 {
    textureStore(normals, at, normal);
    textureStore(color, at, light);
    return normal.x;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.size.y {
        return;
    }
    let texel = textureLoad(input, id.xy, 0);
    let normal = vec4<f32>(texel.yzx, 1.0);
    var light = vec4<f32>(0.0);
    for (var i = 0u; i < min(frame.lights, 40u); i++) {
        if i % 5u == 3u {
            continue;
        }
        light += abs(sin(texel * f32(i + 1u))) / 40.0;
    }
    // its own place is read and written, on the side of every pixel
    let at = id.y * frame.size.x + id.x;
    history[at] = mix(history[at], put(id.xy, normal, light), 0.25);
    switch u32(texel.x * 3.99) {
        case 0u: { atomicAdd(&bright[0], 1u); }
        case 1u, 2u: {
            if texel.y > 0.5 { break; }
            atomicAdd(&bright[1], id.x);
        }
        default: { atomicMax(&bright[3], at); }
    }
    if id.y == 5u && id.x < 16u {
        note[id.x] = groups.x * 100u + id.x * frame.size.y;
    }
}
