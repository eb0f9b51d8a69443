// Each invocation writes a block of four by two words, the last of a row fewer: `break` and `continue` are each word's own bounds. A
// duplicate's block may end before its primary's does, and what it leaves out would be the next row's.
struct Picture { width: u32, height: u32, gain: f32 }

@group(0) @binding(0) var<uniform> picture: Picture;
@group(0) @binding(1) var source: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> words: array<u32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    for (var row = 0u; row < 2u; row += 1u) {
        let y = id.y * 2u + row;
        if y >= picture.height { continue; }
        for (var column = 0u; column < 4u; column += 1u) {
            let x = id.x * 4u + column;
            if x >= picture.width { break; }
            let c = textureLoad(source, vec2(x, y), 0) * picture.gain;
            words[y * picture.width + x] = pack4x8unorm(c);
        }
    }
}
