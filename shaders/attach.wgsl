// The hardware-VRS image: one workgroup for 16×16 words of the shading-rate image, 128×32 pixels; one invocation for each.
//
// Its CPU twin is src/attach/cpu.rs; both make the same bytes. On each axis 1, 2 and 4 pixels are written as 00, 01 and 11:
// in that form the lattice meet of two rates is their AND, four quads at a time, and a tile's finest rate is what no quad
// lacks. Lacking bits are gathered by OR, for which workgroup memory starts right.

struct Params {
    // Quads across and down.
    quads: vec2<u32>,
    // Tiles across and down.
    tiles: vec2<u32>,
    // Words in a row of the shading-rate image.
    sri_pitch: u32,
    // Words in a row of the hardware-VRS image.
    pitch: u32,
    // The texel for each code, a byte each.
    texels: vec4<u32>,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> sri: array<u32>;
@group(0) @binding(2) var<storage, read_write> attachment: array<u32>;

const SIDE: u32 = #{TILE}u;
// A tile is so many words of four quads wide, and so many rows of quads high.
const TILE: vec2<u32> = vec2<u32>(SIDE / 8u, SIDE / 2u);
// The words that a workgroup writes, of four tiles each.
const WORDS: vec2<u32> = vec2<u32>(4u / TILE.x, 16u / TILE.y);
const WORD_COUNT: u32 = WORDS.x * WORDS.y;

// What the quads of each tile lack.
var<workgroup> lacking: array<atomic<u32>, WORD_COUNT>;

// The bytes of a word that are no code of a rate, all ones each.
fn no_codes(word: u32) -> u32 {
    let high = word >> 1u;
    // bits 0 and 2 of each byte: the axis is 1, 2 or 4 wide where both, the low or the high bit are 0, 1 or 2
    let both = word & high & 0x05050505u;
    let some = (word | high) & 0x05050505u;
    let four = high & 0x05050505u;
    // 4 beside 1
    let lone = four & ~((some >> 2u) | (some << 2u));
    var wrong = both | lone | ((word >> 4u) & 0x0f0f0f0fu);
    wrong |= wrong >> 2u;
    wrong |= wrong >> 1u;
    return (wrong & 0x01010101u) * 0xffu;
}

// What four quads lack of 4x4: bits 0 and 2 of a byte where the axis is 1, bits 1 and 3 where it is not 4.
fn lacking_of(word: u32) -> u32 {
    let code = word & ~no_codes(word);
    let some = (code | (code >> 1u)) & 0x05050505u;
    let four = code & 0x0a0a0a0au;
    return ~(some | four) & 0x0f0f0f0fu;
}

@compute @workgroup_size(16, 16)
fn attach(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
) {
    let at = group.xy * 16u + local.xy;
    let first = at.x * 4u;
    if first < params.quads.x && at.y < params.quads.y {
        // quads beyond the edge lack nothing
        let inside = min(params.quads.x - first, 4u);
        let kept = 0xffffffffu >> ((4u - inside) * 8u);
        var lacks = lacking_of(sri[at.y * params.sri_pitch + at.x]) & kept;
        lacks |= lacks >> 16u;
        lacks = (lacks | (lacks >> 8u)) & 15u;
        let tile = local.xy / TILE;
        let word = tile.y * WORDS.x + (tile.x >> 2u);
        atomicOr(&lacking[word], lacks << ((tile.x & 3u) * 8u));
    }
    workgroupBarrier();

    if index >= WORD_COUNT {
        return;
    }
    let out = group.xy * WORDS + vec2<u32>(index % WORDS.x, index / WORDS.x);
    let tile = out.x * 4u;
    if tile >= params.tiles.x || out.y >= params.tiles.y {
        return;
    }
    let has = ~atomicLoad(&lacking[index]);
    // 11 becomes 2, 01 becomes 1
    let codes = (has & 0x0a0a0a0au) | (has & ~(has >> 1u) & 0x05050505u);
    var word = 0u;
    for (var i = 0u; i < min(params.tiles.x - tile, 4u); i++) {
        let code = extractBits(codes, i * 8u, 8u);
        let texel = extractBits(params.texels[code >> 2u], (code & 3u) * 8u, 8u);
        word |= texel << (i * 8u);
    }
    attachment[out.y * params.pitch + out.x] = word;
}
