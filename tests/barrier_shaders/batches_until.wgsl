// A loop over batches that ends when the whole group is told so; what is summed up is a struct that a helper adds to.

struct Light {
    place: vec3<f32>,
    reach: f32,
    color: vec3<f32>,
    kind: u32,
}

struct Sum {
    diffuse: vec3<f32>,
    specular: vec3<f32>,
    count: u32,
}

struct Frame {
    size: vec2<u32>,
    lights: u32,
    cutoff: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> lights: array<Light>;
@group(0) @binding(2) var normals: texture_2d<f32>;
@group(0) @binding(3) var lit: texture_storage_2d<rgba32float, write>;
@group(0) @binding(4) var counts: texture_storage_2d<r32uint, write>;

var<workgroup> batch: array<Light, 32>;
var<workgroup> done: u32;

fn fill(number: u32, lane: u32) {
    if lane < 32u {
        let at = number * 32u + lane;
        if at < arrayLength(&lights) {
            batch[lane] = lights[at];
        } else {
            batch[lane] = Light();
        }
    }
    if lane == 0u {
        done = select(0u, 1u, number * 32u >= min(frame.lights, 130u));
    }
}

fn add(sum: ptr<function, Sum>, light: Light, normal: vec3<f32>, place: vec2<f32>) {
    let way = vec3<f32>(place, 0.5) - light.place;
    if dot(way, way) > frame.cutoff * frame.cutoff + 1.0 {
        return;
    }
    (*sum).diffuse += light.color * max(dot(normal, -way), 0.0);
    (*sum).specular += light.color * light.reach;
    (*sum).count += 1u;
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let is_inside = id.x < frame.size.x && id.y < frame.size.y;
    var sum: Sum;
    let normal = textureLoad(normals, id.xy, 0).xyz;
    var number = 0u;
    loop {
        fill(number, lane);
        if workgroupUniformLoad(&done) != 0u {
            break;
        }
        if is_inside {
            for (var i = 0u; i < min(frame.lights, 32u); i++) {
                add(&sum, batch[i], normal, vec2<f32>(id.xy) / 32.0);
            }
        }
        workgroupBarrier();
        number++;
    }
    if is_inside {
        textureStore(lit, id.xy, vec4<f32>(sum.diffuse + sum.specular, 1.0));
        textureStore(counts, id.xy, vec4<u32>(sum.count));
    }
}
