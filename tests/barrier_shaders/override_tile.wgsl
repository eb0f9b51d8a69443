// A blur whose sides are overrides, as engines specialise them.
override TILE_X: u32 = 8u;
override TILE_Y: u32 = 4u;
override RADIUS: i32 = 2;
@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var blurred: texture_storage_2d<rgba8unorm, write>;
var<workgroup> tile: array<vec3<f32>, TILE_X * TILE_Y>;

@compute @workgroup_size(TILE_X, TILE_Y, 1)
fn main(@builtin(global_invocation_id) gid: vec3<u32>, @builtin(local_invocation_id) lid: vec3<u32>) {
    tile[lid.y * TILE_X + lid.x] = textureLoad(image, gid.xy, 0).rgb;
    workgroupBarrier();
    var sum = vec3<f32>(0.0);
    var n = 0.0;
    for (var y = -RADIUS; y <= RADIUS; y++) {
        for (var x = -RADIUS; x <= RADIUS; x++) {
            let p = vec2<i32>(lid.xy) + vec2<i32>(x, y);
            if all(p >= vec2<i32>(0)) && all(p < vec2<i32>(i32(TILE_X), i32(TILE_Y))) {
                sum += tile[u32(p.y) * TILE_X + u32(p.x)];
                n += 1.0;
            }
        }
    }
    textureStore(blurred, gid.xy, vec4<f32>(sum / n, 1.0));
}
