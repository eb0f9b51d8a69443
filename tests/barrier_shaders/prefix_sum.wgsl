// A prefix sum over the tile, with pointers handed to helpers, and stores in two regions.

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var early: texture_storage_2d<r32uint, write>;
@group(0) @binding(2) var result: texture_storage_2d<r32uint, write>;

var<workgroup> sums: array<u32, 64>;

fn add(place: ptr<function, u32>, more: u32) {
    *place += more;
}

fn noise(p: vec2<u32>) -> u32 {
    var h = p.x * 374761393u + p.y * 668265263u;
    h = (h ^ (h >> 13u)) * 1274126177u;
    return h ^ (h >> 16u);
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let own = u32(textureLoad(image, gid.xy, 0).x * 100.0) + (noise(gid.xy) & 7u);
    var total = own;
    sums[lane] = own;
    workgroupBarrier();
    textureStore(early, gid.xy, vec4<u32>(sums[63u - lane] + own, 0u, 0u, 0u));
    for (var step = 1u; step < 64u; step <<= 1u) {
        var more = 0u;
        if lane >= step {
            more = sums[lane - step];
        }
        workgroupBarrier();
        add(&total, more);
        sums[lane] = total;
        workgroupBarrier();
    }
    var mine = 0u;
    add(&mine, sums[lane]);
    textureStore(result, gid.xy, vec4<u32>(mine - own, 0u, 0u, 0u));
}
