// A product of matrices by tiles: the textbook's.
struct Sizes { m: u32, n: u32, k: u32, pad: u32, }
@group(0) @binding(0) var<uniform> sizes: Sizes;
@group(0) @binding(1) var<storage, read> a: array<f32>;
@group(0) @binding(2) var<storage, read> b: array<f32>;
@group(0) @binding(3) var<storage, read_write> c: array<f32>;
var<workgroup> tile_a: array<array<f32, 16>, 16>;
var<workgroup> tile_b: array<array<f32, 16>, 16>;

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) gid: vec3<u32>, @builtin(local_invocation_id) lid: vec3<u32>) {
    var acc = 0.0;
    let tiles = (min(sizes.k, 40u) + 15u) / 16u;
    for (var t = 0u; t < tiles; t++) {
        let ka = t * 16u + lid.x;
        let kb = t * 16u + lid.y;
        tile_a[lid.y][lid.x] = select(0.0, a[gid.y * sizes.k + ka], gid.y < sizes.m && ka < sizes.k);
        tile_b[lid.y][lid.x] = select(0.0, b[kb * sizes.n + gid.x], kb < sizes.k && gid.x < sizes.n);
        workgroupBarrier();
        for (var i = 0u; i < 16u; i++) {
            acc += tile_a[lid.y][i] * tile_b[i][lid.x];
        }
        workgroupBarrier();
    }
    if gid.x < sizes.n && gid.y < sizes.m {
        c[gid.y * sizes.n + gid.x] = acc;
    }
}
