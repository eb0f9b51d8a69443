// Tile classification: the range of each tile, its class, and the lists and indirect arguments of all classes.
//
// src/classify/gpu.rs puts the measure, the rules and the caller's own functions in the places of the lines that start with `//!`; what it puts
// there comes from src/classify/mod.rs, and src/classify/cpu.rs is the twin.

struct Params {
    extent: vec2<u32>,
    tiles: vec2<u32>,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var source: texture_2d<f32>;
// The least and the greatest value of each tile; no range (1, -1) where a value is no number.
@group(0) @binding(2) var<storage, read_write> bounds: array<vec2<f32>>;
// Width, height, tiles that a list holds, classes; the number of tiles of each class; the lists.
@group(0) @binding(3) var<storage, read_write> lists: array<u32>;
@group(0) @binding(4) var<storage, read_write> counters: array<atomic<u32>, 8>;
@group(0) @binding(5) var<storage, read_write> arguments: array<u32>;

//!CONSTANTS

//!USER

// What is looked at, of a texel.
fn vrcs_measure(texel: vec4<f32>) -> f32 {
//!MEASURE
}

// The class of a tile with these values around it. Rules are tried in order.
fn vrcs_class(lo: f32, hi: f32) -> u32 {
//!RULES
    return CLASSES - 1u;
}

var<workgroup> least: atomic<u32>;
var<workgroup> greatest: atomic<u32>;
var<workgroup> is_doubtful: atomic<u32>;

// Floats as integers in the same order.
fn key_of(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    return select(bits | 0x80000000u, ~bits, (bits >> 31u) != 0u);
}

fn value_of(key: u32) -> f32 {
    return bitcast<f32>(select(~key, key & 0x7fffffffu, (key >> 31u) != 0u));
}

fn put(tile: vec2<u32>, range: vec2<f32>) {
    // any doubt means the last class, which is right for every tile
    var class_index = CLASSES - 1u;
    if range.x <= range.y {
        class_index = min(vrcs_class(range.x, range.y), CLASSES - 1u);
    }
    let place = atomicAdd(&counters[class_index], 1u);
    lists[HEADER + class_index * params.tiles.x * params.tiles.y + place] = tile.x | (tile.y << 16u);
}

@compute @workgroup_size(8, 8)
fn reduce_tiles(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
) {
    if index == 0u {
        atomicStore(&least, 0xffffffffu);
        atomicStore(&greatest, 0u);
        atomicStore(&is_doubtful, 0u);
    }
    workgroupBarrier();
    let origin = tile.xy * TILE;
    var lo = 0xffffffffu;
    var hi = 0u;
    var doubt = 0u;
    for (var y = local.y; y < TILE; y += 8u) {
        for (var x = local.x; x < TILE; x += 8u) {
            let at = origin + vec2<u32>(x, y);
            if all(at < params.extent) {
                let value = vrcs_measure(textureLoad(source, at, 0));
                let key = key_of(value);
                lo = min(lo, key);
                hi = max(hi, key);
                doubt |= select(0u, 1u, (bitcast<u32>(value) & 0x7fffffffu) > 0x7f800000u);
            }
        }
    }
    atomicMin(&least, lo);
    atomicMax(&greatest, hi);
    atomicOr(&is_doubtful, doubt);
    workgroupBarrier();
    if index != 0u {
        return;
    }
    var range = vec2<f32>(value_of(atomicLoad(&least)), value_of(atomicLoad(&greatest)));
    if atomicLoad(&is_doubtful) != 0u {
        range = vec2<f32>(1.0, -1.0);
    }
    if NEIGHBOURHOOD {
        bounds[tile.y * params.tiles.x + tile.x] = range;
    } else {
        put(tile.xy, range);
    }
}

// Classes from the range of the 3×3 tiles around.
@compute @workgroup_size(8, 8)
fn sort_tiles(@builtin(global_invocation_id) id: vec3<u32>) {
    let tile = id.xy;
    if any(tile >= params.tiles) {
        return;
    }
    let first = max(tile, vec2<u32>(1u)) - 1u;
    let last = min(tile + 1u, params.tiles - 1u);
    var range = bounds[tile.y * params.tiles.x + tile.x];
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let other = bounds[y * params.tiles.x + x];
            if other.x <= other.y && range.x <= range.y {
                range = vec2<f32>(min(range.x, other.x), max(range.y, other.y));
            } else {
                range = vec2<f32>(1.0, -1.0);
            }
        }
    }
    put(tile, range);
}

// Wicked's "kick jobs": arguments in two dimensions, since no dimension may be above 65,535; and counters back to 0 for the next
// frame.
@compute @workgroup_size(8)
fn kick(@builtin(local_invocation_index) class_index: u32) {
    if class_index == 0u {
        lists[0] = params.extent.x;
        lists[1] = params.extent.y;
        lists[2] = params.tiles.x * params.tiles.y;
        lists[3] = CLASSES;
    }
    if class_index >= CLASSES {
        return;
    }
    let count = atomicExchange(&counters[class_index], 0u);
    lists[4u + class_index] = count;
    let groups = count * REPLICATE;
    let x = min(groups, MOST_GROUPS);
    arguments[class_index * 3u] = x;
    arguments[class_index * 3u + 1u] = (groups + max(x, 1u) - 1u) / max(x, 1u);
    arguments[class_index * 3u + 2u] = 1u;
}
