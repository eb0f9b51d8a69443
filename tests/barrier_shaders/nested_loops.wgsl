// Two barriers in a loop within a loop, and accumulators of several kinds that live through both.

struct Frame { size: vec2<u32>, rows: u32, columns: u32 }
struct Sum { color: vec3<f32>, hits: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> cells: array<vec4<f32>>;
@group(0) @binding(2) var albedo: texture_2d<f32>;
@group(0) @binding(3) var result: texture_storage_2d<rgba32float, write>;

var<workgroup> page: array<vec4<f32>, 64>;

@compute @workgroup_size(16, 4)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let own = textureLoad(albedo, gid.xy, 0);
    let rows = 1u + frame.rows % 3u;
    let columns = 1u + frame.columns % 4u;
    let total = max(arrayLength(&cells), 1u);
    var sum: Sum;
    var parts = array<f32, 4>();
    for (var row = 0u; row < rows; row++) {
        var inRow = 0.0;
        for (var column = 0u; column < columns; column++) {
            page[lane] = cells[(row * columns + column + lane) % total];
            workgroupBarrier();
            for (var i = 0u; i < 8u; i++) {
                let cell = page[(lane + i * 7u) % 64u];
                sum.color += cell.rgb * own.rgb;
                inRow += cell.a;
                if cell.x > own.x { sum.hits += 1u; continue; }
                parts[i & 3u] += cell.y;
            }
            workgroupBarrier();
        }
        parts[row & 3u] += inRow;
    }
    if any(gid.xy >= frame.size) { return; }
    let all = parts[0] + parts[1] * 2.0 + parts[2] * 4.0 + parts[3] * 8.0;
    textureStore(result, gid.xy, vec4<f32>(sum.color + all, f32(sum.hits)));
}
