//! The rewriter's own composition against naga_oil's: the same files come to the same module.

use std::collections::HashMap;

use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue,
};
use vrcs_passes::input::Reader;

/// What has to be the same: bindings, entry points, and the shape of every function.
fn shape(module: &naga::Module) -> Vec<String> {
    let mut shape = Vec::new();
    for (_, global) in module.global_variables.iter() {
        shape.push(format!("global {:?} {:?}", global.binding, global.space));
    }
    for entry in &module.entry_points {
        shape.push(format!(
            "entry {} {:?} {}",
            entry.name,
            entry.workgroup_size,
            entry.function.expressions.len()
        ));
    }
    for (_, function) in module.functions.iter() {
        shape.push(format!(
            "function {} {} {}",
            function.arguments.len(),
            function.expressions.len(),
            function.body.len()
        ));
    }
    shape.sort();
    shape
}

fn by_naga_oil(
    main: &str,
    modules: &[(&str, &str)],
    defines: &[(&str, ShaderDefValue)],
) -> naga::Module {
    let defines: HashMap<String, ShaderDefValue> = defines
        .iter()
        .map(|&(name, value)| (name.to_owned(), value))
        .collect();
    let mut composer = Composer::default().with_capabilities(naga::valid::Capabilities::all());
    for &(path, source) in modules {
        composer
            .add_composable_module(ComposableModuleDescriptor {
                source,
                file_path: path,
                ..ComposableModuleDescriptor::default()
            })
            .expect("a module");
    }
    let mut module = composer
        .make_naga_module(NagaModuleDescriptor {
            source: main,
            file_path: "main.wgsl",
            shader_defs: defines,
            ..NagaModuleDescriptor::default()
        })
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&composer)));
    naga::compact::compact(&mut module, naga::compact::KeepUnused::No);
    module
}

fn by_us(main: &str, modules: &[(&str, &str)], defines: &[(&str, ShaderDefValue)]) -> naga::Module {
    let mut reader = Reader::new();
    for &(path, text) in modules {
        reader = reader.module(path, text);
    }
    for &(name, value) in defines {
        let value = match value {
            ShaderDefValue::Bool(value) => value.to_string(),
            ShaderDefValue::Int(value) => value.to_string(),
            ShaderDefValue::UInt(value) => value.to_string(),
        };
        reader = reader.define(name, value);
    }
    let shader = reader
        .wgsl([("main.wgsl", main)])
        .unwrap_or_else(|invalid| panic!("{}", invalid.rendered));
    let mut module = shader.module;
    naga::compact::compact(&mut module, naga::compact::KeepUnused::No);
    module
}

const TYPES: &str = "#define_import_path app::types
struct View { size: vec2<u32>, exposure: f32 }
const PI: f32 = 3.14159;
";

const BINDINGS: &str = "#define_import_path app::view
#import app::types::View
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(9) var<uniform> other: View;
fn exposed(x: f32) -> f32 { return x * view.exposure; }
fn unused_here() -> f32 { return other.exposure; }
";

const NOISE: &str = "#define_import_path app::noise
#import app::types as kinds
#ifdef CHEAP
fn noise(x: f32) -> f32 { return fract(x); }
#else if OCTAVES > 2
fn noise(x: f32) -> f32 { return sin(x * kinds::PI) + cos(x * #{OCTAVES}.0); }
#else
fn noise(x: f32) -> f32 { return sin(x) * 2.0; }
#endif
";

const MAIN: &str = "#import app::{view, noise::noise, types::{PI as HALF_TURN}}
#import app::view::exposed

@group(1) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;

fn local(x: f32) -> f32 { return x + HALF_TURN; }

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view::view.size) { return; }
    let v = exposed(noise(local(f32(id.x))));
#ifdef TWICE
    textureStore(picture, id.xy, vec4(v + app::noise::noise(v)));
#else
    textureStore(picture, id.xy, vec4(v));
#endif
}
";

#[test]
fn composed_shaders_are_those_of_naga_oil() {
    let modules = [
        ("types.wgsl", TYPES),
        ("view.wgsl", BINDINGS),
        ("noise.wgsl", NOISE),
    ];
    let (yes, octaves) = (ShaderDefValue::Bool(true), ShaderDefValue::UInt);
    let mut seen = std::collections::BTreeSet::new();
    for defines in [
        &[("OCTAVES", octaves(4))][..],
        &[("OCTAVES", octaves(1))],
        &[("CHEAP", yes), ("OCTAVES", octaves(4))],
        &[("TWICE", yes), ("OCTAVES", octaves(3))],
    ] {
        let theirs = shape(&by_naga_oil(MAIN, &modules, defines));
        let ours = shape(&by_us(MAIN, &modules, defines));
        assert_eq!(ours, theirs, "{defines:?}");
        seen.insert(ours);
    }
    assert_eq!(seen.len(), 4, "the definitions make a difference");
}
