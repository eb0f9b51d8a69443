// A separable blur in one dispatch: rows into workgroup memory, a barrier, columns out of it.

struct Weights {
    center: f32,
    near: f32,
    far: f32,
}

@group(0) @binding(0) var<uniform> weights: Weights;
@group(0) @binding(1) var image: texture_2d<f32>;
@group(0) @binding(2) var blurred: texture_storage_2d<rgba16float, write>;

// 16 columns and 20 rows, blurred along x
var<workgroup> rows: array<vec4<f32>, 320>;

fn along_x(at: vec2<i32>) -> vec4<f32> {
    let last = vec2<i32>(textureDimensions(image)) - 1;
    var sum = vec4<f32>(0.0);
    for (var i = -2; i <= 2; i++) {
        var weight = weights.center;
        if abs(i) == 1 {
            weight = weights.near;
        } else if abs(i) == 2 {
            weight = weights.far;
        }
        sum += weight * textureLoad(image, clamp(at + vec2<i32>(i, 0), vec2<i32>(0), last), 0);
    }
    return sum;
}

@compute @workgroup_size(16, 16)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_id) lid: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    let top = i32(group.y) * 16 - 2;
    rows[lid.y * 16u + lid.x] = along_x(vec2<i32>(i32(gid.x), top + i32(lid.y)));
    if lid.y < 4u {
        rows[(lid.y + 16u) * 16u + lid.x] = along_x(vec2<i32>(i32(gid.x), top + 16 + i32(lid.y)));
    }
    workgroupBarrier();
    let at = lid.y * 16u + lid.x;
    let far = rows[at] + rows[at + 64u];
    let near = rows[at + 16u] + rows[at + 48u];
    textureStore(
        blurred,
        vec2<i32>(gid.xy),
        weights.far * far + weights.near * near + weights.center * rows[at + 32u],
    );
}
