// Jacobi iterations of a line of pixels in two workgroup arrays that change places.
struct Solve { steps: u32, stiffness: f32, }
@group(0) @binding(0) var<uniform> solve: Solve;
@group(0) @binding(1) var<storage, read> start: array<f32>;
@group(0) @binding(2) var<storage, read_write> relaxed: array<f32>;
@group(0) @binding(3) var<uniform> width: vec4<u32>;
var<workgroup> ping: array<f32, 34>;
var<workgroup> pong: array<f32, 34>;

@compute @workgroup_size(32)
fn main(@builtin(global_invocation_id) gid: vec3<u32>, @builtin(local_invocation_id) lid: vec3<u32>) {
    let at = gid.y * width.x + gid.x;
    let inside = gid.x < width.x;
    let right_side = start[at];
    ping[lid.x + 1u] = select(0.0, right_side, inside);
    if lid.x == 0u {
        ping[0] = 0.0;
        ping[33] = 0.0;
        pong[0] = 0.0;
        pong[33] = 0.0;
    }
    workgroupBarrier();
    for (var i = 0u; i < min(solve.steps, 7u); i++) {
        let k = lid.x + 1u;
        if (i & 1u) == 0u {
            pong[k] = (right_side + solve.stiffness * (ping[k - 1u] + ping[k + 1u])) * 0.25;
        } else {
            ping[k] = (right_side + solve.stiffness * (pong[k - 1u] + pong[k + 1u])) * 0.25;
        }
        workgroupBarrier();
    }
    if !inside { return; }
    relaxed[at] = select(ping[lid.x + 1u], pong[lid.x + 1u], (min(solve.steps, 7u) & 1u) == 1u);
}
