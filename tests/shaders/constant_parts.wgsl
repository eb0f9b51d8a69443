// Helpers that are told by a constant which plane, and which component of an element, to store to: an index that is a number on each
// path of calls, and none in the text.
struct Frame { width: u32 }

const PARTS = array<u32, 2>(2u, 0u);

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var source: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> planes: array<array<f32, 4096>, 3>;
@group(0) @binding(3) var<storage, read_write> colors: array<vec4<f32>>;

fn put_plane(plane: u32, at: u32, value: f32) {
    planes[plane][at] = value;
}

fn put_part(part: u32, at: u32, value: f32) {
    var which = part;
    colors[at][which] = value;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width { return; }
    let color = textureLoad(source, id.xy, 0);
    let at = id.y * frame.width + id.x;
    put_plane(0u, at, color.x);
    put_plane(2u, at, color.y);
    put_part(1u, at, color.z);
    put_part(PARTS[0], at, color.w);
}
