// What a tile of 16x16 pixels of the previous picture tells (GDC 2019, pass 1): the error and luma of its own pixels, and the shiniest of
// its surfaces. A workgroup makes four tiles. Its CPU twin is src/analyse/tiles.rs.

#import vrcs::analyse::params::{params, before}
#import vrcs::analyse::fixed::{byte_of, BAD}
#import vrcs::analyse::pictures
#import vrcs::analyse::areas

#ifdef MATERIALS_BEFORE
@group(0) @binding(11) var materials: texture_2d<f32>;
#endif
// For each tile: errors across and down, sixteen times the mean luma; the most smoothness * Rf0, and in bit 31 whether any of it is unknown.
@group(0) @binding(19) var<storage, read_write> tile_data: array<vec4<u32>>;

// The last of a tile's words.
var<workgroup> lasts: array<atomic<u32>, areas::COUNT * 2u>;

@compute @workgroup_size(256)
fn tile_data_of(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let origin = group.xy * areas::REGION;
    let room = min(params.previous - origin, vec2<u32>(areas::REGION));
    let quad = vec2<u32>(index & 15u, index >> 4u);
    let tile = areas::tile_of(quad);
#ifdef CODES
    pictures::share_codes(index, areas::INVOCATIONS);
#endif
    areas::clear(index);
    if index < areas::COUNT * 2u {
        atomicStore(&lasts[index], 0u);
    }
    workgroupBarrier();
    for (var i = 0u; i < 4u; i++) {
        let p = quad * 2u + vec2<u32>(i & 1u, i >> 1u);
        if all(p < room) {
            let value = pictures::before_at(origin + p);
            areas::keep(p, value);
            if value.w == BAD {
                atomicOr(&lasts[tile * 2u], 0x80000000u);
            }
#ifdef MATERIALS_BEFORE
            let surface = textureLoad(materials, before(origin + p), 0).xy;
            atomicMax(&lasts[tile * 2u + 1u], byte_of(surface.x) * byte_of(surface.y));
#endif
        }
    }
    workgroupBarrier();
    areas::gather(quad, room, 0u);
    workgroupBarrier();
    let corner = vec2<u32>(index % areas::ACROSS, index / areas::ACROSS) * areas::SIDE;
    if index >= areas::COUNT || any(corner >= room) {
        return;
    }
    let area = areas::area_of(index, min(room - corner, vec2<u32>(areas::SIDE)), 0u);
    // an axis without a pair tells nothing, but of a picture that is one pixel wide
    let counted = atomicLoad(&areas::counts[index]);
    let is_unseen = any((vec2<u32>(counted & 0xffffu, counted >> 16u) == vec2<u32>(0u)) & (params.previous > vec2<u32>(1u)));
    let unknown = select(0u, 0x80000000u, is_unseen) | atomicLoad(&lasts[index * 2u]);
    let at = (origin + corner) / areas::SIDE;
    let across = (params.previous.x + areas::SIDE - 1u) / areas::SIDE;
    tile_data[at.y * across + at.x] =
        vec4<u32>(area.error, area.light, unknown | atomicLoad(&lasts[index * 2u + 1u]));
}
