@group(0) @binding(0) var<storage> a: array<f32>;
@group(0) @binding(1) var<storage> b: array<f32>;
@group(0) @binding(2) var<storage> c: array<f32>;
@group(0) @binding(3) var<storage> d: array<f32>;
@group(0) @binding(4) var<storage> e: array<f32>;
@group(0) @binding(5) var<storage> f: array<f32>;
@group(0) @binding(6) var<storage> g: array<f32>;
@group(0) @binding(7) var<storage> h: array<f32>;
@group(0) @binding(8) var<storage, read_write> sum: array<f32>; // here

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.y * 64u + id.x;
    sum[i] = a[i] + b[i] + c[i] + d[i] + e[i] + f[i] + g[i] + h[i];
}
