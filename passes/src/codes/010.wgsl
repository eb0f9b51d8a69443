struct State { cursor: array<u32, 4096>, values: array<f32, 4096> }
@group(0) @binding(0) var<storage, read_write> state: State;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = id.y * 64u + id.x;
    let at = state.cursor[index];
    state.values[at + index] = 1.0; // here
    state.cursor[index] = at + 1u;
}
