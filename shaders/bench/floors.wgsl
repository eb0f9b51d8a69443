// Floors: kernels that only read, or only read and write, what a stage of ours does. Nothing of ours can be faster than the fastest of them.
// Each comes in several shapes, since nobody knows beforehand which one the hardware likes.

struct Frame {
    size: vec2<u32>,
    words: u32,
    pitch: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var colour: texture_2d<f32>;
@group(0) @binding(2) var motion: texture_2d<f32>;
@group(0) @binding(3) var<storage, read_write> written: array<u32>;
@group(0) @binding(4) var<storage, read> words: array<u32>;
@group(0) @binding(5) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(6) var in_place: texture_storage_2d<r32uint, read_write>;
@group(0) @binding(7) var<storage, read_write> wide: array<vec4<u32>>;

// Nothing, in the shape of the analysis: workgroups of 256, each for 128 x 32 pixels.
@compute @workgroup_size(256)
fn empty(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0xffffffffu {
        written[0] = 1u;
    }
}

fn seen(at: vec2<u32>) -> vec4<f32> {
    let inside = min(at, frame.size - 1u);
    return textureLoad(colour, inside, 0) + textureLoad(motion, inside, 0);
}

// The sum is stored where it can never be.
fn end(sum: vec4<f32>) {
    if sum.x == -1.0 {
        written[0] = 1u;
    }
}

// A pixel by each invocation, neighbours side by side.
@compute @workgroup_size(16, 16)
fn read_once(@builtin(global_invocation_id) id: vec3<u32>) {
    end(seen(id.xy));
}

// Eight pixels by each, neighbours side by side: 64 x 32 to a workgroup.
@compute @workgroup_size(16, 16)
fn read_grid(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let at = group.xy * vec2(64u, 32u) + local.xy;
    var sum = vec4(0.0);
    for (var i = 0u; i < 8u; i++) {
        sum += seen(at + vec2(i & 3u, i >> 2u) * 16u);
    }
    end(sum);
}

// Sixteen by each, in lines: 128 x 32 to a workgroup.
@compute @workgroup_size(128, 2)
fn read_lines(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let at = group.xy * vec2(128u, 32u) + local.xy;
    var sum = vec4(0.0);
    for (var i = 0u; i < 16u; i++) {
        sum += seen(at + vec2(0u, i * 2u));
    }
    end(sum);
}

// A square of four by each, as texture units are laid out: 32 x 32 to a workgroup.
@compute @workgroup_size(16, 16)
fn read_squares(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = id.xy * 2u;
    end(seen(at) + seen(at + vec2(1u, 0u)) + seen(at + vec2(0u, 1u)) + seen(at + 1u));
}

// Reads √luma, four pixels a word, and writes a word of rates for each 8 x 2 of them; nothing else.
@compute @workgroup_size(256)
fn read_luma(@builtin(global_invocation_id) id: vec3<u32>) {
    let column = id.x % frame.pitch;
    let row = id.x / frame.pitch;
    // `frame.words` are in a row of √luma
    if row * 2u + 1u >= frame.size.y || column * 2u + 1u >= frame.words {
        return;
    }
    let at = row * 2u * frame.words + column * 2u;
    let below = at + frame.words;
    written[id.x] = words[at] + words[at + 1u] + words[below] + words[below + 1u];
}

// Reads the shading rates and writes as many words as the builder does: `frame.words` for each word of rates.
@compute @workgroup_size(64)
fn build_words(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
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

// The same, four words at a time.
@compute @workgroup_size(64)
fn build_wide(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= arrayLength(&words) {
        return;
    }
    let word = words[index];
    for (var i = 0u; i < frame.words / 4u; i++) {
        let at = i * arrayLength(&words) + index;
        if at < arrayLength(&wide) {
            wide[at] = vec4(word + i);
        }
    }
}

fn is_coarse(quad: vec2<u32>) -> bool {
    let code = (words[quad.y * frame.pitch + quad.x / 4u] >> (8u * (quad.x % 4u))) & 15u;
    return code != 0u && all(quad * 2u + 1u < frame.size);
}

// Copies the pixels that a deblocker touches, those of coarse quads, from one texture to another.
@compute @workgroup_size(16, 16)
fn copy_pixels(@builtin(global_invocation_id) id: vec3<u32>) {
    if is_coarse(id.xy / 2u) {
        textureStore(picture, id.xy, textureLoad(colour, id.xy, 0));
    }
}

fn touch(at: vec2<u32>) {
    textureStore(in_place, at, textureLoad(in_place, at) ^ vec4(1u));
}

// Reads and writes them in place, a pixel by each invocation.
@compute @workgroup_size(16, 16)
fn touch_pixels(@builtin(global_invocation_id) id: vec3<u32>) {
    if is_coarse(id.xy / 2u) {
        touch(id.xy);
    }
}

// The same, a quad by each.
@compute @workgroup_size(16, 16)
fn touch_quads(@builtin(global_invocation_id) id: vec3<u32>) {
    if is_coarse(id.xy) {
        let at = id.xy * 2u;
        touch(at);
        touch(at + vec2(1u, 0u));
        touch(at + vec2(0u, 1u));
        touch(at + 1u);
    }
}
