//! Rewritten shaders in HLSL, MSL and GLSL: written, mapped, and held against what reads them on this machine.
//!
//! GLSL goes to `glslangValidator` where it is installed, and back through naga's front end everywhere; `tests/run.sh` installs it
//! and sets `VRCS_REQUIRE_TOOLS`.

#![cfg(all(feature = "spirv", feature = "hlsl", feature = "msl", feature = "glsl"))]

use std::{
    collections::BTreeMap,
    path::Path,
    process::{Command, Stdio},
};

use vrcs_passes::{
    Entries, Options, Rewritten, Source,
    emit::{self, EmitError, Form, Language, Target},
    input::{self, Directives, Reader},
    rewrite,
};

fn rewritten(name: &str, text: &str) -> Rewritten {
    let source = Source::new(name, text);
    let (module, info) =
        input::wgsl(&source).unwrap_or_else(|invalid| panic!("{}", invalid.rendered));
    rewrite(&module, &info, Entries::PerPixel, &Options::default())
        .unwrap_or_else(|refusal| panic!("{name}: {refusal}"))
}

/// Every golden shader, rewritten, and values for its overrides.
fn shaders() -> Vec<(String, Rewritten, BTreeMap<String, f64>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths: Vec<_> = [root.join("tests/rewritten"), root.join("../tests/shaders")]
        .iter()
        .flat_map(|folder| std::fs::read_dir(folder).expect("shaders"))
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "wgsl")
        })
        .collect();
    paths.sort();
    paths
        .iter()
        .map(|path| {
            let text = std::fs::read_to_string(path).expect("a shader");
            let before = text.split("// ---- becomes ----").next().unwrap_or(&text);
            let name = path.display().to_string();
            let rewritten = rewritten(&name, before);
            let constants = rewritten.module.overrides.iter();
            let constants = constants
                .filter(|(_, item)| item.init.is_none())
                .filter_map(|(_, item)| Some((item.name.clone()?, 8.0)))
                .collect();
            (name, rewritten, constants)
        })
        .collect()
}

/// Whether a tool is there. Where it is required it has to be.
fn is_there(tool: &str) -> bool {
    let is_there = Command::new(tool).arg("--version").output().is_ok();
    let required = std::env::var("VRCS_REQUIRE_TOOLS").is_ok_and(|list| list.contains(tool));
    assert!(is_there || !required, "{tool} is not installed");
    is_there
}

fn glslang(text: &str, name: &str) {
    let file = std::env::temp_dir().join(format!("vrcs-{}.comp", std::process::id()));
    std::fs::write(&file, text).expect("a file");
    let output = Command::new("glslangValidator")
        .args(["-G", "-S", "comp", "-o"])
        .args([&file.with_extension("spv"), &file])
        .stdin(Stdio::null())
        .output()
        .expect("glslangValidator runs");
    for file in [file.with_extension("spv"), file] {
        let _ = std::fs::remove_file(file);
    }
    assert!(
        output.status.success(),
        "{name}: {}\n{text}",
        String::from_utf8_lossy(&output.stdout)
    );
}

#[test]
fn every_rewritten_shader_is_written_in_every_language() {
    let has_glslang = is_there("glslangValidator");
    for (name, rewritten, constants) in shaders() {
        for entry in &rewritten.manifest.entries {
            let form = Form {
                entry: Some(entry.name.clone()),
                constants: constants.clone(),
                ..Form::default()
            };
            for &(language, ..) in Language::ALL {
                let written = emit::write(
                    &rewritten.module,
                    &rewritten.info,
                    language.into(),
                    &form,
                    &Directives::default(),
                )
                .unwrap_or_else(|error| panic!("{name}, {language}: {error}"));
                assert!(!written.bytes.is_empty());
                if language == Language::Wgsl {
                    continue;
                }
                let [only] = written.output.entries.as_slice() else {
                    panic!("{name}, {language}: not one entry point");
                };
                // the added bindings are in the map
                for added in &entry.bindings {
                    assert!(
                        only.bindings.iter().any(|binding| {
                            (binding.group, binding.binding)
                                == (Some(added.group), Some(added.binding))
                        }),
                        "{name}, {language}: no {}",
                        added.name
                    );
                }
                // no two bindings share a place
                let mut places: Vec<_> = only
                    .bindings
                    .iter()
                    .map(|binding| (&binding.register, binding.space, binding.index))
                    .collect();
                places.sort();
                let count = places.len();
                places.dedup();
                assert_eq!(
                    places.len(),
                    count,
                    "{name}, {language}: {:?}",
                    only.bindings
                );
                if language == Language::Glsl && has_glslang {
                    let text = String::from_utf8(written.bytes).expect("text");
                    glslang(&text, &name);
                }
            }
        }
    }
}

const SAMPLED: &str = "
struct Camera { size: vec2<u32> }
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(1) var albedo: texture_2d<f32>;
@group(0) @binding(2) var smooth_sampler: sampler;
@group(1) @binding(0) var<uniform> camera: Camera;
@group(1) @binding(3) var<storage> lights: array<vec4<f32>>;
@compute @workgroup_size(8, 8)
fn shade(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size) { return; }
    var sum = textureSampleLevel(albedo, smooth_sampler, vec2<f32>(id.xy) / vec2<f32>(camera.size), 0.0);
    for (var i = 0u; i < arrayLength(&lights); i++) { sum += lights[i]; }
    textureStore(picture, id.xy, sum);
}";

/// `name register index space` of every binding.
fn map(language: Language) -> (String, Vec<String>, BTreeMap<String, String>) {
    let rewritten = rewritten("sampled.wgsl", SAMPLED);
    let written = emit::write(
        &rewritten.module,
        &rewritten.info,
        language.into(),
        &Form::default(),
        &Directives::default(),
    )
    .unwrap_or_else(|error| panic!("{error}"));
    let entry = &written.output.entries[0];
    let bindings = entry
        .bindings
        .iter()
        .map(|b| match b.space {
            Some(space) => format!("{} {}{} space{space}", b.name, b.register, b.index),
            None => format!("{} {} {}", b.name, b.register, b.index),
        })
        .collect();
    let text = String::from_utf8_lossy(&written.bytes).into_owned();
    (text, bindings, entry.extra.clone())
}

#[test]
fn hlsl_registers_are_those_of_the_map() {
    let (text, bindings, extra) = map(Language::Hlsl);
    assert_eq!(
        bindings,
        [
            "picture u0 space0",
            "albedo t1 space0",
            "smooth_sampler sampler-index0 space0",
            "camera b0 space1",
            "lights t3 space1",
            "vrcs_params b0 space2",
            "vrcs_coords t1 space2",
        ]
    );
    for expected in [
        "register(u0)",
        "register(t1)",
        "register(b0, space1)",
        "register(t3, space1)",
        "register(t1, space2)",
    ] {
        assert!(text.contains(expected), "no {expected} in\n{text}");
    }
    assert_eq!(extra["nagaGroup0SamplerIndexArray"], "t0, space254");
    assert!(
        text.contains("nagaGroup0SamplerIndexArray : register(t0, space254)"),
        "{text}"
    );
}

#[test]
fn msl_slots_are_those_of_the_map() {
    let (text, bindings, extra) = map(Language::Msl);
    assert_eq!(
        bindings,
        [
            "picture texture 0",
            "albedo texture 1",
            "smooth_sampler sampler 0",
            "camera buffer 0",
            "lights buffer 1",
            "vrcs_params buffer 2",
            "vrcs_coords buffer 3",
        ]
    );
    for expected in [
        "picture [[texture(0)]]",
        "albedo [[texture(1)]]",
        "[[sampler(0)]]",
        "lights [[buffer(1)]]",
        "vrcs_coords [[buffer(3)]]",
        "_buffer_sizes [[buffer(4)]]",
    ] {
        assert!(text.contains(expected), "no {expected} in\n{text}");
    }
    assert_eq!(extra["_mslBufferSizes"], "buffer 4");
}

#[test]
fn glsl_bindings_are_those_of_the_map() {
    let (text, bindings, extra) = map(Language::Glsl);
    assert_eq!(
        bindings,
        [
            "picture image 0",
            "albedo texture 0",
            "camera uniform 0",
            "lights buffer 0",
            "vrcs_params uniform 1",
            "vrcs_coords buffer 1",
        ]
    );
    assert_eq!(extra["albedo"], "sampled with smooth_sampler");
    assert!(text.contains("binding = 1) readonly buffer"), "{text}");
}

#[test]
fn what_glsl_cannot_hold_is_told() {
    let text = "
        @group(0) @binding(0) var a: texture_storage_2d<rgba8unorm, write>;
        @compute @workgroup_size(8, 8) fn one(@builtin(global_invocation_id) id: vec3<u32>) { textureStore(a, id.xy, vec4(1.0)); }
        @compute @workgroup_size(8, 8) fn two(@builtin(global_invocation_id) id: vec3<u32>) { textureStore(a, id.xy, vec4(0.5)); }
    ";
    let rewritten = rewritten("two.wgsl", text);
    let error = emit::glsl(&rewritten.module, &rewritten.info, &Form::default()).expect_err("two");
    assert_eq!(
        error,
        EmitError::OneEntry(vec!["one".to_owned(), "two".to_owned()])
    );
    let form = |name: &str| Form {
        entry: Some(name.to_owned()),
        ..Form::default()
    };
    assert!(emit::glsl(&rewritten.module, &rewritten.info, &form("two")).is_ok());
    let error = emit::glsl(&rewritten.module, &rewritten.info, &form("three")).expect_err("none");
    assert_eq!(error, EmitError::NoEntry("three".to_owned()));
}

#[test]
fn overrides_need_values_where_a_language_has_none() {
    let text = "
        override WIDTH: u32;
        @group(0) @binding(0) var a: texture_storage_2d<rgba8unorm, write>;
        @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            if id.x < WIDTH { textureStore(a, id.xy, vec4(1.0)); }
        }
    ";
    let rewritten = rewritten("override.wgsl", text);
    let with = |constants: &[(&str, f64)]| {
        let constants = constants.iter().map(|&(n, v)| (n.to_owned(), v)).collect();
        let form = Form {
            constants,
            ..Form::default()
        };
        emit::spirv(&rewritten.module, &rewritten.info, &form)
    };
    assert!(with(&[("WIDTH", 64.0)]).is_ok());
    for (constants, what) in [
        (&[][..], "WIDTH"),
        (&[("HEIGHT", 1.0), ("WIDTH", 1.0)], "HEIGHT"),
    ] {
        let error = with(constants).expect_err("an error");
        assert!(
            matches!(error, EmitError::Constants(_)) && error.to_string().contains(what),
            "{error}"
        );
    }
}

/// A ray query: HLSL, MSL and SPIR-V have it, WGSL and GLSL text do not.
#[test]
fn what_a_back_end_cannot_write_is_one_error_and_no_panic() {
    let text = "
        enable wgpu_ray_query;
        @group(0) @binding(0) var scene: acceleration_structure;
        @group(0) @binding(1) var<storage, read_write> out: array<f32>;
        @compute @workgroup_size(1) fn main() {
            var query: ray_query;
            rayQueryInitialize(&query, scene, RayDesc(0u, 0xffu, 0.1, 9.0, vec3(0.0), vec3(0.0, 0.0, 1.0)));
            rayQueryProceed(&query);
            out[0] = rayQueryGetCommittedIntersection(&query).t;
        }
    ";
    let shader = Reader::new().wgsl([("rays.wgsl", text)]).expect("a shader");
    let write = |target: &str| {
        let target: Target = target.parse().expect("a target");
        emit::write(
            &shader.module,
            &shader.info,
            target,
            &Form::default(),
            &shader.directives,
        )
    };
    assert!(write("spirv-1.4").is_ok());
    for target in ["wgsl", "glsl"] {
        let error = write(target).expect_err(target);
        assert!(!error.to_string().is_empty());
    }
}

#[test]
fn targets_have_names() {
    assert_eq!(
        "hlsl-6.2"
            .parse::<Target>()
            .map(|t| t.to_string())
            .as_deref(),
        Ok("hlsl-6.2")
    );
    assert_eq!(
        "glsl".parse::<Target>().map(|t| t.to_string()).as_deref(),
        Ok("glsl-450")
    );
    assert_eq!(
        "spv".parse::<Target>().map(|t| t.language()),
        Ok(Language::SpirV)
    );
    let error = "hlslx".parse::<Target>().expect_err("none");
    assert!(error.contains("did you mean `hlsl`?"), "{error}");
    let error = "msl-9.9".parse::<Target>().expect_err("none");
    assert!(error.contains("2.4"), "{error}");
    assert_eq!(Language::from_extension("metal"), Some(Language::Msl));
    assert_eq!(Language::from_extension("txt"), None);
}
