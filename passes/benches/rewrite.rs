//! What a rewrite costs beside what naga does with the same shader: parse, validate, rewrite, audit and write.
//!
//! `cargo bench -p vrcs-passes`.

use std::{hint::black_box, path::Path};

use criterion::{Criterion, criterion_group, criterion_main};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use vrcs_passes::{Entries, Options, emit, rewrite};

/// A small shader and one of 300 lines, as text.
fn shaders() -> [(&'static str, String); 2] {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a shader");
    [
        ("small", read("tests/shaders/plain.wgsl")),
        ("300 lines", three_hundred_lines()),
    ]
}

/// Helpers that call each other, a loop over lights, four targets and a guard: what a lighting pass looks like.
fn three_hundred_lines() -> String {
    let mut text = String::from(
        "struct Frame { size: vec2<u32>, lights: u32, time: f32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var albedo: texture_2d<f32>;
@group(0) @binding(2) var normals: texture_2d<f32>;
@group(0) @binding(3) var<storage, read> lights: array<vec4<f32>>;
@group(1) @binding(0) var diffuse: texture_storage_2d<rgba16float, write>;
@group(1) @binding(1) var specular: texture_storage_2d<rgba16float, write>;
@group(1) @binding(2) var<storage, read_write> variance: array<f32>;
",
    );
    for layer in 0..16 {
        let inner = match layer {
            0 => "p.x * 0.5 + p.y".to_owned(),
            _ => format!("noise{}(p.yzx * 1.7, k)", layer - 1),
        };
        text.push_str(&format!(
            "
fn noise{layer}(p: vec3<f32>, k: f32) -> f32 {{
    let cell = floor(p);
    let inside = fract(p);
    let smoothed = inside * inside * (3.0 - 2.0 * inside);
    var sum = 0.0;
    for (var corner = 0u; corner < 4u; corner++) {{
        let offset = vec3<f32>(f32(corner & 1u), f32(corner >> 1u), 0.0);
        let hashed = fract(sin(dot(cell + offset, vec3<f32>(127.1, 311.7, 74.7))) * 43758.5);
        if hashed < k {{
            sum += hashed * smoothed.x;
        }}
    }}
    return sum + {inner};
}}
"
        ));
    }
    text.push_str(
        "
fn put(at: vec2<u32>, color: vec3<f32>, shine: vec3<f32>) {
    textureStore(diffuse, at, vec4<f32>(color, 1.0));
    textureStore(specular, at, vec4<f32>(shine, 1.0));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let base = textureLoad(albedo, id.xy, 0);
    if base.w < 0.01 {
        put(id.xy, vec3<f32>(0.0), vec3<f32>(0.0));
        return;
    }
    let normal = normalize(textureLoad(normals, id.xy, 0).xyz * 2.0 - 1.0);
    var color = vec3<f32>(0.0);
    var shine = vec3<f32>(0.0);
    for (var light = 0u; light < frame.lights; light++) {
        let source = lights[light];
        let toward = source.xyz - vec3<f32>(vec2<f32>(id.xy), 0.0);
        let distance = length(toward);
        if distance > source.w {
            continue;
        }
        let lit = max(dot(normal, toward / distance), 0.0);
        color += base.xyz * lit;
        shine += vec3<f32>(pow(lit, 32.0));
    }
    let grain = noise15(vec3<f32>(vec2<f32>(id.xy), frame.time), 0.5);
    put(id.xy, color * grain, shine);
    variance[id.y * frame.size.x + id.x] = grain;
}
",
    );
    text
}

fn bench(criterion: &mut Criterion) {
    for (name, text) in shaders() {
        let mut group = criterion.benchmark_group(name);
        let parse = || naga::front::wgsl::parse_str(&text).expect("WGSL");
        let validate = |module: &naga::Module| {
            Validator::new(ValidationFlags::all(), Capabilities::all())
                .validate(module)
                .expect("valid")
        };
        let module = parse();
        let info = validate(&module);
        let options = Options::default();
        let rewritten = rewrite(&module, &info, Entries::PerPixel, &options).expect("a rewrite");
        group.bench_function("naga's parse", |b| b.iter(|| black_box(parse())));
        group.bench_function("naga's validate", |b| {
            b.iter(|| black_box(validate(&module)))
        });
        group.bench_function("rewrite", |b| {
            b.iter(|| black_box(rewrite(&module, &info, Entries::PerPixel, &options)))
        });
        group.bench_function("write and audit", |b| {
            b.iter(|| black_box(emit::wgsl(&rewritten.module, &rewritten.info)))
        });
        group.finish();
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
