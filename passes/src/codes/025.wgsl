// options: {"max_storage_buffers": 2}
@group(0) @binding(0) var<storage> a: array<f32>; // here
@group(0) @binding(1) var<storage, read_write> sum: array<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.y * 64u + id.x;
    sum[i] = a[i] * 2.0;
}
