// What a class's shader finds its pixel with (Wicked's "tileception"): put before the shader by `Classifier::wgsl`.
@group(VRCS_GROUP) @binding(0) var<storage, read> vrcs_tiles: array<u32>;

struct VrcsPixel {
    // The pixel.
    at: vec2<u32>,
    // Whether there is such a pixel. If not, the invocation has nothing to do.
    is_inside: bool,
    // The tile that it lies in.
    tile: vec2<u32>,
}

// The pixel of an invocation of a workgroup of VRCS_BLOCK × VRCS_BLOCK in one dimension: its `workgroup_id` and
// `local_invocation_index`.
fn vrcs_pixel(workgroup: vec3<u32>, index: u32) -> VrcsPixel {
    let count = vrcs_tiles[4u + VRCS_CLASS];
    let groups = count * VRCS_REPLICATE;
    let group = workgroup.y * min(groups, VRCS_MOST_GROUPS) + workgroup.x;
    if group >= groups {
        return VrcsPixel(vec2<u32>(0u), false, vec2<u32>(0u));
    }
    let word = vrcs_tiles[VRCS_HEADER + VRCS_CLASS * vrcs_tiles[2] + group / VRCS_REPLICATE];
    let tile = vec2<u32>(word & 0xffffu, word >> 16u);
    let sub = group % VRCS_REPLICATE;
    let side = VRCS_TILE / VRCS_BLOCK;
    let at = tile * VRCS_TILE + vec2<u32>(sub % side, sub / side) * VRCS_BLOCK
        + vec2<u32>(index % VRCS_BLOCK, index / VRCS_BLOCK);
    return VrcsPixel(at, all(at < vec2<u32>(vrcs_tiles[0], vrcs_tiles[1])), tile);
}
