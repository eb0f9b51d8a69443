@group(0) @binding(0) var<storage, read_write> sums: array<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.y * 64u + id.x;
    let before = sums[i]; // here
    sums[i] = before * 0.9 + 0.1;
}
