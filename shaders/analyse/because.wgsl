// Why a quad has its rate: the numbers of src/analyse/reasons.rs.
#define_import_path vrcs::analyse::because

const CONTENT: u32 = 1u;
const NO_HISTORY: u32 = 2u;
const INVALID: u32 = 3u;
const OFF_SCREEN: u32 = 4u;
const DISOCCLUDED: u32 = 5u;
const MATERIAL: u32 = 6u;
const MASK: u32 = 7u;
const HALF_RATE: u32 = 8u;
const NEIGHBOUR: u32 = 9u;
const MOTION: u32 = 10u;
const OWN: u32 = 11u;
const NO_MOTION: u32 = 12u;

// By the doubts of analyse/source.wgsl, four bits each: none of them, which is no luma; no motion; off the screen; hidden.
const OF_DOUBT: u32 = 0x54c3u;

// The reason for a doubt.
fn of_doubt(doubt: u32) -> u32 {
    return (OF_DOUBT >> ((doubt & 3u) * 4u)) & 15u;
}
