// The algebra of shading rates for kernels; its twin is src/rate. Codes are (log2 W << 2) | log2 H.
#define_import_path vrcs::rate

const R1X1: u32 = 0u;
const R1X2: u32 = 1u;
const R2X1: u32 = 4u;
const R2X2: u32 = 5u;
const R2X4: u32 = 6u;
const R4X2: u32 = 9u;
const R4X4: u32 = 10u;

// Combiners.
const PASSTHROUGH: u32 = 0u;
const OVERRIDE: u32 = 1u;
const MIN: u32 = 2u;
const MAX: u32 = 3u;
const SUM: u32 = 4u;
const LOOSE_SUM: u32 = 5u;

// The bits of the seven codes.
const CODES: u32 = 0x673u;

// A code; full rate if the number is none.
fn or_full(code: u32) -> u32 {
    let is_code = code <= R4X4 && ((CODES >> (code & 31u)) & 1u) != 0u;
    return select(R1X1, code, is_code);
}

// The two axes of a code, as log2.
fn axes(code: u32) -> vec2<u32> {
    return vec2<u32>(code >> 2u, code & 3u);
}

// The code for two axes that were decided one by one, as log2. What is no rate becomes the coarsest rate that is coarser
// on neither axis: 4x1 becomes 2x1, 1x4 becomes 1x2, 8 falls to 4.
fn resolve(log2: vec2<u32>) -> u32 {
    let most = min(log2, vec2<u32>(2u));
    let fits = min(most, most.yx + 1u);
    return (fits.x << 2u) | fits.y;
}

// On each axis the finer of two codes.
fn meet(a: u32, b: u32) -> u32 {
    return min(a & 12u, b & 12u) | min(a & 3u, b & 3u);
}

// On each axis the coarser of two codes.
fn join(a: u32, b: u32) -> u32 {
    return max(a & 12u, b & 12u) | max(a & 3u, b & 3u);
}

// Whether a code is at least as fine as another, on both axes.
fn is_within(a: u32, b: u32) -> bool {
    return meet(a, b) == a;
}

// Two codes by a combiner, on a device whose largest rate is 2x2 or 4x4.
fn combine(combiner: u32, first: u32, second: u32, largest: u32) -> u32 {
    let a = meet(first, largest);
    let b = meet(second, largest);
    switch combiner {
        case OVERRIDE: {
            return b;
        }
        case MIN: {
            return meet(a, b);
        }
        case MAX: {
            return join(a, b);
        }
        case SUM: {
            return meet(resolve(axes(a) + axes(b)), largest);
        }
        case LOOSE_SUM: {
            // sizes are 1, 2 and 4: their sum, rounded down to a power of two, is their product except for 1 and 1
            let logs = axes(a) + axes(b);
            return meet(resolve(max(logs, vec2<u32>(1u))), largest);
        }
        default: {
            return a;
        }
    }
}
