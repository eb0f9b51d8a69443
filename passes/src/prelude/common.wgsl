// What the modes share: the parameters, the pixel at hand, its duplicates, and how both are confined.
//
// A primary's duplicates lie in its own aligned 4x4 block. `vrcs_copies` holds one bit for each, relative to the primary:
// bit k stands for the pixel at the primary's position XOR (k & 3, k >> 2), so that bit 1 is the horizontal neighbour
// in the quad, bit 4 the vertical one and bit 5 the diagonal one, wherever in its quad the primary lies.

struct VrcsParams {
    // The logical extent, in invocations: nothing outside it is shaded or written.
    extent: vec3<u32>,
    // Bit 0: variable-rate shading is on.
    flags: u32,
    // What `num_workgroups` would be in the original dispatch.
    groups: vec3<u32>,
    // Tiles in a row of the picture; quads in a row of the graded buffer.
    tiles_per_row: u32,
    // Where in the buffer the entries start, in words.
    entries: u32,
    // Room for entries in each tile; for tiles in each class. In graded mode the tile's width, and its height from bit 16 on.
    entries_per_tile: u32,
    // Room for entries in a list; words of the graded buffer's quads.
    capacity: u32,
    // Words of an entry of a list: 1 or 2.
    stride: u32,
}

@group(0) @binding(0) var<uniform> vrcs_params: VrcsParams;
@group(0) @binding(1) var<storage, read> vrcs_coords: array<u32>;

// The pixel at hand: what the shader takes for its global invocation id.
var<private> vrcs_pixel: vec3<u32>;
// Its duplicates.
var<private> vrcs_copies: u32;

const VRCS_ENABLED: u32 = 1u;

fn vrcs_is_inside(pixel: vec3<u32>) -> bool {
    return all(pixel < vrcs_params.extent);
}

// Takes over a pixel that is alone in its group.
fn vrcs_take_alone(pixel: vec3<u32>) -> bool {
    vrcs_pixel = pixel;
    vrcs_copies = 0u;
    return vrcs_is_shaded(pixel);
}

// Whether a pixel that is alone in its group is shaded: of the domain, the shader's own guard asks. Replaced by the next function where
// that guard is gone.
fn vrcs_is_shaded(pixel: vec3<u32>) -> bool {
    return vrcs_is_inside(pixel);
}

// Both are asked at once: with a branch between them an H200 takes 0.5 % longer, even where nobody comes here.
fn vrcs_is_inside_and_in_domain(pixel: vec3<u32>) -> bool {
    return vrcs_is_inside(pixel) & vrcs_in_domain(pixel);
}

// Stands for the shader's own domain; replaced where the shader has guards on its ids.
fn vrcs_in_domain(pixel: vec3<u32>) -> bool {
    return true;
}

// The pixel of duplicate k.
fn vrcs_duplicate(k: u32) -> vec3<u32> {
    return vec3<u32>(vrcs_pixel.xy ^ vec2<u32>(k & 3u, k >> 2u), vrcs_pixel.z);
}

// How far duplicate k lies from its primary.
fn vrcs_delta(k: u32) -> vec2<i32> {
    return vec2<i32>(vrcs_duplicate(k).xy) - vec2<i32>(vrcs_pixel.xy);
}

// The members of a group that lie inside the extent. `mask` is over the aligned 4x4 block, bit (y & 3) * 4 + (x & 3).
fn vrcs_members_in_extent(block: vec2<u32>, mask: u32) -> u32 {
    let room = min(vrcs_params.extent.xy - min(block, vrcs_params.extent.xy), vec2<u32>(4u));
    let columns = ((1u << room.x) - 1u) * 0x1111u;
    let rows = (1u << (room.y * 4u)) - 1u;
    return mask & columns & rows;
}

// Stands for the members of a group that lie in the shader's domain; replaced by one of the next functions where the shader has
// guards on its ids.
fn vrcs_members(block: vec2<u32>, z: u32, mask: u32) -> u32 {
    return mask;
}

// Asks the domain for each member.
fn vrcs_each_in_domain(block: vec2<u32>, z: u32, mask: u32) -> u32 {
    var members = mask;
    for (var left = mask; left != 0u; left &= left - 1u) {
        let bit = firstTrailingBit(left);
        if !vrcs_in_domain(vec3<u32>(block + vec2<u32>(bit & 3u, bit >> 2u), z)) {
            members &= ~(1u << bit);
        }
    }
    return members;
}

// The same, but for a lone member, of which the shader's own guard asks.
fn vrcs_members_in_domain(block: vec2<u32>, z: u32, mask: u32) -> u32 {
    if countOneBits(mask) > 1u {
        return vrcs_each_in_domain(block, z, mask);
    }
    return mask;
}

// Stands for whether a block whose least and greatest ids these are lies in the shader's domain as a whole: false says nothing.
// Replaced where the shader has guards on its ids.
fn vrcs_holds_throughout(near: vec3<u32>, far: vec3<u32>) -> bool {
    return true;
}

// Whether all of a block is to be shaded, so that no member of a group in it need be asked.
fn vrcs_is_whole(near: vec3<u32>, far: vec3<u32>) -> bool {
    return all(far < vrcs_params.extent) && vrcs_holds_throughout(near, far);
}

// Takes a group over: `pixel` is its nominal primary, `mask` its members. A group whose primary lies outside the extent or
// the domain is re-homed to its first member inside. False if no member is left.
fn vrcs_take(pixel: vec3<u32>, mask: u32) -> bool {
    let home = (pixel.x & 3u) | ((pixel.y & 3u) << 2u);
    let near = vec3<u32>(pixel.xy & vec2<u32>(~3u), pixel.z);
    if ((mask >> home) & 1u) != 0u && vrcs_is_whole(near, vec3<u32>(pixel.xy | vec2<u32>(3u), pixel.z)) {
        vrcs_pixel = pixel;
        vrcs_copies = vrcs_relative(mask, home) & ~1u;
        return true;
    }
    return vrcs_take_inside(pixel, home, mask);
}

// The same for a group that lies in a quad: `duplicates` has a bit for the horizontal neighbour, the vertical and the diagonal one.
fn vrcs_take_quad(pixel: vec3<u32>, duplicates: u32) -> bool {
    let near = vec3<u32>(pixel.xy & vec2<u32>(~1u), pixel.z);
    let copies = ((duplicates & 1u) << 1u) | ((duplicates & 6u) << 3u);
    if vrcs_is_whole(near, vec3<u32>(pixel.xy | vec2<u32>(1u), pixel.z)) {
        vrcs_pixel = pixel;
        vrcs_copies = copies;
        return true;
    }
    let home = (pixel.x & 3u) | ((pixel.y & 3u) << 2u);
    return vrcs_take_inside(pixel, home, vrcs_relative(copies | 1u, home));
}

// The members that are inside of a group that may not be so as a whole; `nominal` is the bit of its nominal primary.
fn vrcs_take_inside(pixel: vec3<u32>, nominal: u32, mask: u32) -> bool {
    let block = pixel.xy & vec2<u32>(~3u);
    let members = vrcs_members(block, pixel.z, vrcs_members_in_extent(block, mask));
    if members == 0u || pixel.z >= vrcs_params.extent.z {
        return false;
    }
    var home = nominal;
    if ((members >> home) & 1u) == 0u {
        home = firstTrailingBit(members);
    }
    vrcs_pixel = vec3<u32>(block + vec2<u32>(home & 3u, home >> 2u), pixel.z);
    vrcs_copies = vrcs_relative(members, home) & ~1u;
    return true;
}

// A mask over the block as one relative to bit `home`; and one that is relative as one over the block.
fn vrcs_relative(mask: u32, home: u32) -> u32 {
    var relative = mask;
    if (home & 1u) != 0u {
        relative = ((relative & 0x5555u) << 1u) | ((relative >> 1u) & 0x5555u);
    }
    if (home & 2u) != 0u {
        relative = ((relative & 0x3333u) << 2u) | ((relative >> 2u) & 0x3333u);
    }
    if (home & 4u) != 0u {
        relative = ((relative & 0x0f0fu) << 4u) | ((relative >> 4u) & 0x0f0fu);
    }
    if (home & 8u) != 0u {
        relative = ((relative & 0x00ffu) << 8u) | ((relative >> 8u) & 0x00ffu);
    }
    return relative;
}

// The width and height of the smallest aligned block that holds the group of the pixel at hand.
fn vrcs_group_rate() -> vec2<u32> {
    let across = select(select(1u, 2u, (vrcs_copies & 0x2222u) != 0u), 4u, (vrcs_copies & 0xccccu) != 0u);
    let down = select(select(1u, 2u, (vrcs_copies & 0x00f0u) != 0u), 4u, (vrcs_copies & 0xff00u) != 0u);
    return vec2<u32>(across, down);
}
