// What a tile of 16x16 pixels of the previous picture looks like (GDC 2019, pass 1): the mean of its quads' windows. A workgroup makes a
// tile, an invocation a quad. Its CPU twin is src/analyse/tiles.rs.

#import vrcs::analyse::params::params
#import vrcs::analyse::fixed::BAD
#import vrcs::analyse::pictures

// For each tile: errors across and down, the sum of lumas, and whether a pixel has none.
@group(0) @binding(19) var<storage, read_write> tile_data: array<vec4<u32>>;

var<workgroup> sums: array<atomic<u32>, 4>;

fn joined(sum: u32, a: u32, b: u32) -> u32 {
    let d = max(a, b) - min(a, b);
#ifdef NORM_LINF
    return max(sum, d);
#else
#ifdef MEAN
    return sum + d;
#else
    return sum + d * d;
#endif
#endif
}

@compute @workgroup_size(8, 8)
fn tile_data_of(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
) {
#ifdef CODES
    pictures::share_codes(index, 64u);
#endif
    if index < 4u {
        atomicStore(&sums[index], 0u);
    }
    workgroupBarrier();
    let quads = (params.previous + 1u) / 2u;
    let room = min(quads - tile.xy * 8u, vec2<u32>(8u));
    let count = room.x * room.y;
    if all(local.xy < room) {
        let corner = vec2<i32>((tile.xy * 8u + local.xy) * 2u) - 1;
        let last = vec2<i32>(params.previous) - 1;
        var lumas: array<u32, 16>;
        var is_lost = 0u;
        var light = 0u;
        for (var i = 0u; i < 16u; i++) {
            let p = clamp(corner + vec2<i32>(vec2<u32>(i & 3u, i >> 2u)), vec2<i32>(0), last);
            let value = pictures::before_at(vec2<u32>(p)).w;
            is_lost |= select(0u, 1u, value == BAD);
            lumas[i] = value & 0x7fffu;
            light += lumas[i];
        }
        var errors = vec2<u32>(0u);
        for (var i = 0u; i < 12u; i++) {
            // pairs across start in the columns 0 to 2, pairs down in the rows 0 to 2
            let at = i / 3u * 4u + i % 3u;
            errors.x = joined(errors.x, lumas[at], lumas[at + 1u]);
            errors.y = joined(errors.y, lumas[i], lumas[i + 4u]);
        }
#ifdef NORM_LINF
        atomicMax(&sums[0], errors.x);
        atomicMax(&sums[1], errors.y);
#else
        // each rounds up, and so does their mean
        atomicAdd(&sums[0], (errors.x + count - 1u) / count);
        atomicAdd(&sums[1], (errors.y + count - 1u) / count);
#endif
        atomicAdd(&sums[2], light / count);
        atomicOr(&sums[3], is_lost);
    }
    workgroupBarrier();
    if index == 0u {
        let across = (params.previous.x + 15u) / 16u;
        tile_data[tile.y * across + tile.x] =
            vec4<u32>(atomicLoad(&sums[0]), atomicLoad(&sums[1]), atomicLoad(&sums[2]), atomicLoad(&sums[3]));
    }
}
