// Floors: kernels that only read, or only read and write, what a stage of ours does. Nothing of ours can be faster than they are.

struct Frame {
    size: vec2<u32>,
    words: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var colour: texture_2d<f32>;
@group(0) @binding(2) var motion: texture_2d<f32>;
@group(0) @binding(3) var<storage, read_write> written: array<u32>;
@group(0) @binding(4) var<storage, read> words: array<u32>;
@group(0) @binding(5) var picture: texture_storage_2d<rgba8unorm, write>;

// Nothing, in the shape of a full-screen dispatch: workgroups of 256, each for 64 x 32 pixels.
@compute @workgroup_size(256)
fn empty(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0xffffffffu {
        written[0] = 1u;
    }
}

// Reads what the analysis reads, 4 x 2 pixels by each invocation; the sum is stored where it can never be.
@compute @workgroup_size(16, 16)
fn read_pictures(@builtin(global_invocation_id) id: vec3<u32>) {
    var sum = vec4(0.0);
    for (var i = 0u; i < 8u; i++) {
        let at = id.xy * vec2(4u, 2u) + vec2(i & 3u, i >> 2u);
        sum += textureLoad(colour, at, 0) + textureLoad(motion, at, 0);
    }
    if sum.x == -1.0 {
        written[0] = 1u;
    }
}

// The same without motion.
@compute @workgroup_size(16, 16)
fn read_colour(@builtin(global_invocation_id) id: vec3<u32>) {
    var sum = vec4(0.0);
    for (var i = 0u; i < 8u; i++) {
        sum += textureLoad(colour, id.xy * vec2(4u, 2u) + vec2(i & 3u, i >> 2u), 0);
    }
    if sum.x == -1.0 {
        written[0] = 1u;
    }
}

// Reads the shading rates and writes as many words as the builder does: `frame.words` for each word of rates.
@compute @workgroup_size(64)
fn build_traffic(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= arrayLength(&words) {
        return;
    }
    let word = words[index];
    for (var i = 0u; i < frame.words; i++) {
        let at = i * arrayLength(&words) + index;
        if at < arrayLength(&written) {
            written[at] = word + i;
        }
    }
}

// Copies the pixels that a deblocker touches: those of coarse quads.
@compute @workgroup_size(16, 16)
fn copy_coarse(@builtin(global_invocation_id) id: vec3<u32>) {
    let quad = id.xy / 2u;
    let pitch = frame.words;
    let code = (words[quad.y * pitch + quad.x / 4u] >> (8u * (quad.x % 4u))) & 15u;
    if code != 0u && all(id.xy < frame.size) {
        textureStore(picture, id.xy, textureLoad(colour, id.xy, 0));
    }
}
