// Entries whose spare bits carry the linear depth of their primary, 0 at the near plane and 1 at the far one (slides: "utilise 21 spare
// bits for linearZ"). No group is larger than a quad, and no tile larger than 16x16.

// The depth of the pixel at hand; below 0 where its entry does not tell: none was loaded, or the group has found another home.
var<private> vrcs_depth_at: f32 = -1.0;

fn vrcs_linear_depth() -> f32 {
    return vrcs_depth_at;
}

fn vrcs_keep_depth(pixel: vec2<u32>, depth: f32) {
    vrcs_depth_at = select(-1.0, depth, all(vrcs_pixel.xy == pixel));
}

// Takes over an entry of a tile that starts at `origin`: x | y << 4 | members of the quad << 8 | depth << 12.
fn vrcs_take_tiled(origin: vec2<u32>, z: u32, entry: u32) -> bool {
    let pixel = origin + vec2<u32>(entry & 15u, (entry >> 4u) & 15u);
    let quad = ((entry >> 8u) & 3u) | (((entry >> 10u) & 3u) << 4u);
    let found = vrcs_take(vec3<u32>(pixel, z), quad << ((pixel.x & 2u) + (pixel.y & 2u) * 4u));
    vrcs_keep_depth(pixel, f32(entry >> 12u) / 1048575.0);
    return found;
}

// Takes over an entry of a list: x | y << 16, and members | depth << 16.
fn vrcs_take_listed(first: u32, second: u32, z: u32) -> bool {
    let pixel = vec2<u32>(first & 0xffffu, first >> 16u);
    let found = vrcs_take(vec3<u32>(pixel, z), second & 0xffffu);
    vrcs_keep_depth(pixel, f32(second >> 16u) / 65535.0);
    return found;
}
