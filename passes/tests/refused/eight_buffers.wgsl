@group(0) @binding(0) var<storage> a: array<f32>;
@group(0) @binding(1) var<storage> b: array<f32>;
@group(0) @binding(2) var<storage> c: array<f32>;
@group(0) @binding(3) var<storage> d: array<f32>;
@group(0) @binding(4) var<storage> e: array<f32>;
@group(0) @binding(5) var<storage> f: array<f32>;
@group(0) @binding(6) var<storage> g: array<f32>;
@group(0) @binding(7) var<storage, read_write> sum: array<f32>;
@group(0) @binding(8) var<storage> unused: array<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.y * 64u + id.x;
    sum[i] = a[i] + b[i] + c[i] + d[i] + e[i] + f[i] + g[i];
}

// ---- is refused ----

error[VRCS025]: `main` uses 8 storage buffers; with the coordinate buffer that makes 9, and the device is taken to have 8 a stage
  ┌─ eight_buffers.wgsl:1:23
  │
1 │ @group(0) @binding(0) var<storage> a: array<f32>;
  │                       ^^^^^^^^^^^^^^^^^^^^^^^^^^^ storage buffer 1
2 │ @group(0) @binding(1) var<storage> b: array<f32>;
  │                       --------------------------- storage buffer 2
3 │ @group(0) @binding(2) var<storage> c: array<f32>;
  │                       --------------------------- storage buffer 3
4 │ @group(0) @binding(3) var<storage> d: array<f32>;
  │                       --------------------------- storage buffer 4
5 │ @group(0) @binding(4) var<storage> e: array<f32>;
  │                       --------------------------- storage buffer 5
6 │ @group(0) @binding(5) var<storage> f: array<f32>;
  │                       --------------------------- storage buffer 6
7 │ @group(0) @binding(6) var<storage> g: array<f32>;
  │                       --------------------------- storage buffer 7
8 │ @group(0) @binding(7) var<storage, read_write> sum: array<f32>;
  │                       ----------------------------------------- storage buffer 8
  │
  = help: if the device has more (`max_storage_buffers_per_shader_stage`), say so with `--max-storage-buffers 9`; else put two of them into one, or make one that is only read and small a uniform
