// A generator of noise whose state is a private variable, drawn from in every region by either part.
struct In { @builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_id) lid: vec3<u32>, @builtin(local_invocation_index) i: u32 }
var<private> seed: u32;
var<private> hit: vec3<f32>;
@group(0) @binding(0) var color: texture_2d<f32>;
@group(0) @binding(1) var shaded: texture_storage_2d<rgba16float, write>;
@group(0) @binding(2) var<uniform> frame: vec4<u32>;
var<workgroup> lights: array<vec4<f32>, 64>;
fn next() -> f32 { seed = seed * 747796405u + 2891336453u; return f32(seed >> 9u) / 8388608.0; }
fn hash(p: vec2<u32>) { seed = p.x * 1973u + p.y * 9277u + frame.x; }
@compute @workgroup_size(8, 8)
fn main(in: In) {
    hash(in.id.xy);
    lights[in.i] = textureLoad(color, vec2<u32>(in.i, 0u), 0) * next();
    hit = vec3<f32>(next());
    workgroupBarrier();
    var sum = vec3<f32>(0.0);
    for (var k = 0; k < 4; k++) {
        sum += lights[u32(next() * 63.0)].xyz * hit;
    }
    workgroupBarrier();
    lights[in.i] = vec4<f32>(sum, next());
    workgroupBarrier();
    textureStore(shaded, in.id.xy, vec4<f32>(sum + lights[63u - in.i].xyz, next()));
}
