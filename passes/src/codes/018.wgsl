@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;

fn path_a(at: vec2<u32>, value: u32) { textureStore(picture, at, vec4(value)); }
fn path_b(at: vec2<u32>, value: u32) { path_a(at, value); path_a(at, value + 1u); }
fn path_c(at: vec2<u32>, value: u32) { path_b(at, value); path_b(at, value + 1u); }
fn path_d(at: vec2<u32>, value: u32) { path_c(at, value); path_c(at, value + 1u); }
fn path_e(at: vec2<u32>, value: u32) { path_d(at, value); path_d(at, value + 1u); }
fn path_f(at: vec2<u32>, value: u32) { path_e(at, value); path_e(at, value + 1u); }
fn path_g(at: vec2<u32>, value: u32) { path_f(at, value); path_f(at, value + 1u); }
fn path_h(at: vec2<u32>, value: u32) { path_g(at, value); path_g(at, value + 1u); }
fn path_i(at: vec2<u32>, value: u32) { path_h(at, value); path_h(at, value + 1u); }
fn path_j(at: vec2<u32>, value: u32) { path_i(at, value); path_i(at, value + 1u); }
fn path_k(at: vec2<u32>, value: u32) { path_j(at, value); path_j(at, value + 1u); }
fn path_l(at: vec2<u32>, value: u32) { path_k(at, value); path_k(at, value + 1u); }
fn path_m(at: vec2<u32>, value: u32) { path_l(at, value); path_l(at, value + 1u); }
fn path_n(at: vec2<u32>, value: u32) { path_m(at, value); path_m(at, value + 1u); }

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    path_n(id.xy, 0u);
}
