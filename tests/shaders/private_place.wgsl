// The pixel is kept in a private variable, and helpers read it from there.
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

var<private> place: vec2<u32>;
var<private> state: u32;

fn random() -> f32 {
    state = state * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return f32((word >> 22u) ^ word) / 4294967295.0;
}

fn put(color: vec4<f32>) {
    textureStore(picture, place, color);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    place = id.xy;
    state = id.x + id.y * 1973u;
    var sum = textureLoad(input, place, 0);
    for (var i = 0; i < 4; i++) {
        sum += vec4(random(), random(), random(), 0.0) * 0.1;
    }
    put(sum);
}
