// Constant work, nothing but arithmetic: how long it takes tells the clock.

struct Work {
    rounds: u32,
}

@group(0) @binding(0) var<uniform> work: Work;
@group(0) @binding(1) var<storage, read_write> written: array<f32>;

@compute @workgroup_size(256)
fn control(@builtin(global_invocation_id) id: vec3<u32>) {
    var a = vec4<f32>(f32(id.x)) * vec4<f32>(0.25, 0.5, 0.75, 1.0);
    for (var i = 0u; i < work.rounds; i++) {
        a = a * 0.999 + vec4<f32>(0.125);
        a = a * 0.998 - vec4<f32>(0.25);
    }
    // never so, but the compiler cannot know
    if a.x + a.y + a.z + a.w == 1.0e30 {
        written[0] = a.x;
    }
}
