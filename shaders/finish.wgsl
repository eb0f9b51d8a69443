// What is known only when every tile is built: the lists' lengths, the arguments of indirect dispatches, the statistics. One
// workgroup; it leaves the counters at zero for the next frame.
//
// wgpu puts zeros in place of an indirect dispatch with more than 65,535 workgroups on an axis: nothing would be shaded, and
// nobody told. So the arguments have two dimensions, and the shader makes one number of them.

struct Params {
    tile_area: u32,
    layers: u32,
    phase: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read_write> counters: array<u32>;
var<workgroup> counted: array<u32, COUNTERS_WORDS>;
#ifdef LIST
@group(0) @binding(2) var<storage, read_write> list: array<u32>;
#endif
#ifdef CLASSIFIED
@group(0) @binding(3) var<storage, read_write> classified: array<u32>;
#endif
#ifdef ARGUMENTS
@group(0) @binding(4) var<storage, read_write> arguments: array<u32>;
#endif
#ifdef STATISTICS
@group(0) @binding(5) var<storage, read_write> statistics: array<u32>;
#endif

const COUNTERS_WORDS: u32 = 64u;
// Workgroups in a row: what VRCS_ROW is in the prelude.
const ROW: u32 = 32u;
const C_LIST: u32 = 0u;
const C_TILES: u32 = 2u;
const C_MIXED: u32 = 16u;
const C_STATISTICS: u32 = 18u;

// Pixels that one primary stands for at each rate: 1x1, 1x2, 2x1, 2x2, 2x4, 4x2, 4x4.
fn pixels_of(rate: u32) -> u32 {
    return select((0x0884221u >> (rate * 4u)) & 15u, 16u, rate == 6u);
}

#ifdef ARGUMENTS
// Writes the arguments for so many workgroups.
fn argue(at: u32, groups: u32) {
    arguments[at] = min(groups, ROW);
    arguments[at + 1u] = (groups + ROW - 1u) / ROW;
    arguments[at + 2u] = params.layers;
}
#endif

@compute @workgroup_size(COUNTERS_WORDS)
fn finish(@builtin(local_invocation_index) index: u32) {
    counted[index] = counters[index];
    counters[index] = 0u;
    workgroupBarrier();
#ifdef STATISTICS
    if index < 20u {
        statistics[index] = counted[C_STATISTICS + index];
    }
#endif
    if index == 0u {
        conclude();
    }
}

// Writes the lists' heads and the arguments.
fn conclude() {
#ifdef LIST
    let covered = counted[C_LIST];
    let sky = counted[C_LIST + 1u];
    list[0] = covered;
    list[1] = sky;
    argue(0u, (covered + params.tile_area - 1u) / params.tile_area);
    argue(3u, (covered + sky + params.tile_area - 1u) / params.tile_area);
#endif
#ifdef CLASSIFIED
    let mixed = vec2<u32>(counted[C_MIXED], counted[C_MIXED + 1u]);
    classified[14] = mixed.x;
    classified[15] = mixed.y;
    // workgroups up to the end of each segment: without sky, and with it
    var groups = (vec2<u32>(mixed.x, mixed.x + mixed.y) + params.tile_area - 1u) / params.tile_area;
    for (var rate = 0u; rate < 7u; rate++) {
        let pixels = pixels_of(rate);
        let tiles = vec2<u32>(counted[C_TILES + rate], counted[C_TILES + 7u + rate]);
        groups += (vec2<u32>(tiles.x, tiles.x + tiles.y) + pixels - 1u) / pixels;
        classified[rate] = tiles.x;
        classified[rate + 7u] = tiles.y;
        classified[rate + 16u] = groups.x;
        classified[rate + 23u] = groups.y;
    }
    argue(6u, groups.x);
    argue(9u, groups.y);
    classified[30] = params.phase;
#endif
}
