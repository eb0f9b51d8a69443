// Three planes of one buffer, each as large as the picture: all are summed up, and all are faded in place.
struct Frame { width: u32, height: u32, keep: f32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> planes: array<f32>;
@group(0) @binding(3) var output: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let own = id.y * frame.width + id.x;
    let plane = frame.width * frame.height;
    let sum = vec3(planes[own], planes[own + plane], planes[own + 2u * plane]);
    textureStore(output, id.xy, vec4(sum, 1.0) + textureLoad(input, id.xy, 0));
    for (var k = 0u; k < 3u; k++) {
        planes[own + k * plane] = planes[own + k * plane] * frame.keep + f32(id.x + 2u * id.y);
    }
}
