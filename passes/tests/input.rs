//! What comes in: files joined and imported, directives, other languages; and messages that point into the right file.

use vrcs_passes::{
    Entries, Options, emit,
    input::{Directives, Invalid, Language, Reader, Shader},
    rewrite,
};

const STORE: &str = "
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4(value(id.x)));
}
";

fn read(files: &[(&str, &str)], modules: &[(&str, &str)]) -> Result<Shader, Invalid> {
    let mut reader = Reader::new();
    for &(name, text) in modules {
        reader = reader.module(name, text);
    }
    reader.wgsl(files.iter().copied())
}

/// The message's first line and place.
fn told(outcome: Result<Shader, Invalid>) -> String {
    let invalid = outcome.expect_err("it is not valid");
    let place = invalid.place.map(|place| place.to_string());
    format!("{} | {}", place.unwrap_or_default(), invalid.message)
}

fn help(text: &str) -> String {
    let invalid = read(&[("a.wgsl", text)], &[]).expect_err("it is not valid");
    assert!(
        invalid.help.is_none() || invalid.rendered.contains("= help: "),
        "{}",
        invalid.rendered
    );
    invalid.help.unwrap_or_default().into()
}

#[test]
fn a_single_file_stays_as_it_is() {
    let text = format!("fn value(x: u32) -> f32 {{ return f32(x); }}{STORE}");
    let shader = read(&[("main.wgsl", &text)], &[]).expect("a shader");
    assert_eq!(shader.source.text(), text);
    assert!(shader.directives.is_empty());
}

#[test]
fn several_files_are_one_shader_and_messages_point_into_the_right_one() {
    let common = "fn value(x: u32) -> f32 { return f32(x); }";
    assert!(read(&[("common.wgsl", common), ("main.wgsl", STORE)], &[]).is_ok());
    // a file that is missing, an error in each file, an error of the validator's
    let alone = told(read(&[("main.wgsl", STORE)], &[]));
    assert!(alone.starts_with("main.wgsl:5:39 |"), "{alone}");
    let first = told(read(
        &[
            ("common.wgsl", "\n fn value(x: u33) {}"),
            ("main.wgsl", STORE),
        ],
        &[],
    ));
    assert!(first.starts_with("common.wgsl:2:14 |"), "{first}");
    let second = told(read(
        &[("common.wgsl", common), ("main.wgsl", "\n\n  fn 1")],
        &[],
    ));
    assert!(second.starts_with("main.wgsl:3:6 |"), "{second}");
    let validator = told(read(
        &[
            ("common.wgsl", common),
            ("main.wgsl", "\nfn f() -> f32 { return 1u; }"),
        ],
        &[],
    ));
    assert!(validator.starts_with("main.wgsl:2"), "{validator}");
}

#[test]
fn imports_are_composed_and_messages_point_into_modules() {
    let module = "#define_import_path lib::value\n#ifdef HALF\nconst K = 0.5;\n#else\nconst K = 1.0;\n#endif\n\
                  fn value(x: u32) -> f32 {\n    return f32(x) * K;\n}\n";
    let main = format!("#import lib::value::value\n{STORE}");
    let reader = Reader::new().module("lib.wgsl", module);
    let whole = reader
        .wgsl([("main.wgsl", main.as_str())])
        .expect("a shader");
    assert!(whole.source.text().contains("const K = 1.0;"));
    let half = reader
        .define("HALF", "true")
        .wgsl([("main.wgsl", main.as_str())])
        .expect("a shader");
    assert!(half.source.text().contains("const K = 0.5;"));

    let broken = module.replace("f32(x) * K", "f32(x) * k");
    let said = told(read(&[("main.wgsl", &main)], &[("lib.wgsl", &broken)]));
    assert!(said.starts_with("lib.wgsl:8:21 |"), "{said}");
    let said = told(read(&[("main.wgsl", &main)], &[]));
    assert!(
        said.starts_with("main.wgsl:6:39 | there is no module `lib::value`"),
        "{said}"
    );
}

#[test]
fn what_a_module_has_and_nobody_uses_is_left_out() {
    let module = "#define_import_path lib\n@group(0) @binding(0) var other: texture_2d<f32>;\n\
                  fn value(x: u32) -> f32 { return f32(x); }\nfn unused() { _ = textureDimensions(other); }";
    let main = format!("#import lib::value\n{STORE}");
    let shader = read(&[("main.wgsl", &main)], &[("lib.wgsl", module)]).expect("a shader");
    assert_eq!(shader.module.global_variables.len(), 1);
    rewrite(
        &shader.module,
        &shader.info,
        Entries::PerPixel,
        &Options::default(),
    )
    .unwrap_or_else(|refusal| panic!("{refusal}"));
}

#[test]
fn a_refusal_points_into_the_right_file() {
    let common = "@group(0) @binding(1) var<storage, read_write> state: array<f32>;\n\
                  fn value(x: u32) -> f32 { return state[x + 1u]; }\n\
                  fn put(x: u32) { state[x] = 1.0; }";
    let main = STORE.replace(
        "    textureStore",
        "    put(id.x + id.y * 64u);\n    textureStore",
    );
    let shader = read(&[("common.wgsl", common), ("main.wgsl", &main)], &[]).expect("a shader");
    let refusal = rewrite(
        &shader.module,
        &shader.info,
        Entries::PerPixel,
        &Options::default(),
    )
    .expect_err("it reads what others write");
    let rendered = refusal.render(&shader.source, vrcs_passes::Color::Never);
    assert!(rendered.contains("common.wgsl:2:"), "{rendered}");
}

#[test]
fn directives_that_naga_rejects_are_no_error_and_come_back() {
    let text = format!(
        "enable subgroups;\nrequires subgroup_id;\ndiagnostic(off, subgroup_uniformity);\n\
         fn value(x: u32) -> f32 {{ return f32(x); }}{STORE}"
    );
    let shader = read(&[("main.wgsl", &text)], &[]).expect("a shader");
    let written = emit::wgsl_with(&shader.module, &shader.info, &shader.directives).expect("text");
    assert_eq!(Directives::of(&written), shader.directives, "{written}");
    assert_eq!(shader.directives.requires, ["subgroup_id"]);
    // the second file's directives go before the first file's declarations
    let first = "fn value(x: u32) -> f32 { return f32(x); }";
    let second = format!("enable f16;\nconst H = 1h;\n{STORE}");
    let shader = read(&[("a.wgsl", first), ("b.wgsl", &second)], &[]).expect("a shader");
    assert_eq!(shader.directives.enables, ["f16"]);
    let said = told(read(
        &[("a.wgsl", first), ("b.wgsl", "enable f61;\nconst A = 1;")],
        &[],
    ));
    assert!(said.starts_with("b.wgsl:1:"), "{said}");
}

#[test]
fn what_an_author_can_do_is_told() {
    for (text, expected) in [
        ("var<push_constant> a: u32;", "`var<immediate>`"),
        (
            "@group(0) @binding(0) var a: binding_array<texture_2d<f32>, 4>;",
            "enable wgpu_binding_array;",
        ),
        ("[[group(0), binding(0)]] var a: f32;", "before 2022"),
        ("fn f() -> f32 { return light(); }", "give that file first"),
        ("const N = {{N}};", "template"),
    ] {
        let said = help(text);
        assert!(said.contains(expected), "`{text}`: {said}");
    }
    let source = vrcs_passes::Source::new("a.wgsl", "#import a::b\nfn f() { b::c(); }");
    let invalid = vrcs_passes::input::wgsl(&source).expect_err("not composed");
    assert!(
        invalid.rendered.contains("input::Reader"),
        "{}",
        invalid.rendered
    );
}

#[test]
fn languages_are_told_by_extension() {
    assert_eq!(Language::from_extension("WGSL"), Some(Language::Wgsl));
    assert_eq!(Language::from_extension("spv"), Some(Language::SpirV));
    assert_eq!(Language::from_extension("comp"), Some(Language::Glsl));
    assert_eq!(Language::from_extension("hlsl"), None);
    assert_eq!("spirv".parse(), Ok(Language::SpirV));
    assert!("metal".parse::<Language>().is_err());
}

#[test]
#[cfg(feature = "spirv")]
fn spirv_comes_in() {
    let text = format!("fn value(x: u32) -> f32 {{ return f32(x); }}{STORE}");
    let shader = read(&[("main.wgsl", &text)], &[]).expect("a shader");
    let options = naga::back::spv::Options::default();
    let words =
        naga::back::spv::write_vec(&shader.module, &shader.info, &options, None).expect("SPIR-V");
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let reader = Reader::new();
    let again = reader
        .read(Language::SpirV, [("main.spv", bytes.clone())])
        .expect("a shader");
    assert_eq!(again.module.entry_points[0].name, "main");
    // what is cut, changed or no SPIR-V at all is an error
    for bytes in [
        Vec::new(),
        b"no SPIR-V".to_vec(),
        bytes[..bytes.len() / 2].to_vec(),
    ] {
        let invalid = reader
            .read(Language::SpirV, [("x.spv", bytes)])
            .expect_err("it is no SPIR-V");
        assert!(invalid.rendered.contains("x.spv"), "{}", invalid.rendered);
    }
    let mut changed = 0;
    for at in (20..bytes.len()).step_by(7) {
        let mut bytes = bytes.clone();
        bytes[at] ^= 0x55;
        changed += usize::from(reader.read(Language::SpirV, [("x.spv", bytes)]).is_err());
    }
    assert!(changed > 0);
}

#[test]
#[cfg(feature = "glsl")]
fn glsl_comes_in() {
    let text = "#version 450
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba8) uniform writeonly image2D picture;
void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    imageStore(picture, at, vec4(vec2(at) / float(SIZE), 0.0, 1.0));
}
";
    let reader = Reader::new().define("SIZE", "64");
    let shader = reader
        .read(Language::Glsl, [("a.comp", text.as_bytes().to_vec())])
        .expect("a shader");
    assert_eq!(shader.module.entry_points[0].workgroup_size, [8, 8, 1]);
    let said = told(Reader::new().read(Language::Glsl, [("a.comp", text.as_bytes().to_vec())]));
    assert!(said.starts_with("a.comp:6:"), "{said}");
}

/// Reads, rewrites and writes; nothing may panic or overflow, on a thread as small as Rust's are.
fn survives(language: Language, text: String) -> Result<(), String> {
    std::thread::Builder::new()
        .stack_size(1 << 20)
        .spawn(move || {
            let shader = Reader::new()
                .read(language, [("deep", text.into_bytes())])
                .map_err(|invalid| invalid.message)?;
            let rewritten = rewrite(
                &shader.module,
                &shader.info,
                Entries::PerPixel,
                &Options::default(),
            )
            .map_err(|refusal| refusal.to_string())?;
            emit::wgsl(&rewritten.module, &rewritten.info).map_err(|error| error.to_string())?;
            Ok(())
        })
        .expect("a thread")
        .join()
        .expect("no panic")
}

fn with_value(expression: &str) -> String {
    format!("fn value(x: u32) -> f32 {{ return {expression}; }}{STORE}")
}

#[test]
fn deep_input_is_read_or_refused() {
    let sum = |n: usize| with_value(&format!("f32(x{})", " + 1u".repeat(n)));
    assert_eq!(survives(Language::Wgsl, sum(10)), Ok(()));
    assert_eq!(survives(Language::Wgsl, sum(1_000)), Ok(()));
    let nested = |n: usize| with_value(&format!("f32({}x{})", "(".repeat(n), ")".repeat(n)));
    assert_eq!(survives(Language::Wgsl, nested(50)), Ok(()));
    let chain = |n: usize| {
        let branches: String = (0..n)
            .map(|i| format!("if x == {i}u {{ y = {i}.0; }} else "))
            .collect();
        format!(
            "fn value(x: u32) -> f32 {{ var y = 0.0; {branches} {{ y = 1.0; }} return y; }}{STORE}"
        )
    };
    assert_eq!(survives(Language::Wgsl, chain(100)), Ok(()));
    for text in [
        sum(100_000),
        nested(100_000),
        chain(30_000),
        "(".repeat(1_000_000),
        "{".repeat(1_000_000),
        format!("const A = {}1;", "-".repeat(100_000)),
        format!("alias A = {}f32;", "array<".repeat(100_000)),
        format!("const A = a{};", "[0]".repeat(100_000)),
        "fn f() { loop ".to_owned() + &"{ loop ".repeat(50_000),
    ] {
        let start = text[..text.len().min(60)].to_owned();
        assert!(survives(Language::Wgsl, text).is_err(), "{start}");
    }
}

#[test]
#[cfg(feature = "glsl")]
fn deep_glsl_is_read_or_refused() {
    for (open, close) in [("(", ")"), ("-", ""), ("{", "}"), ("if (true) ", "")] {
        let text = format!(
            "#version 450\nlayout(local_size_x = 8) in;\nvoid main() {{ float a = {}1.0{}; }}",
            open.repeat(100_000),
            close.repeat(100_000)
        );
        assert!(survives(Language::Glsl, text).is_err(), "{open}");
    }
}

/// Changed at random, the files of a composed shader are read or refused; nothing panics.
#[test]
fn mutilated_files_are_read_or_refused() {
    let files = [
        format!("enable f16;\n#define N 3\n#import lib::value::{{value, K as k}}\n{STORE}#if N > 2\n// ü\n#endif\n"),
        "#define_import_path lib::value\n#ifdef HALF\nconst K = 0.5;\n#else\nconst K = 1.0; /* ü */\n#endif\n\
         fn value(x: u32) -> f32 {\n    return f32(x) * K * #{N}.0;\n}\n"
            .to_owned(),
    ];
    let pieces = [
        "#", "::", "{", "}", "\n", "\"", "/*", "*/", "ü", "import", "#else", "#endif", ";",
        "enable ", "as ", "(", ",",
    ];
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below.max(1) as u64) as usize
    };
    let (mut read, mut refused) = (0, 0);
    for _ in 0..1500 {
        let mut changed = files.clone();
        for _ in 0..=random(3) {
            let text = &mut changed[random(2)];
            let mut at = random(text.len());
            while !text.is_char_boundary(at) {
                at -= 1;
            }
            match random(3) {
                0 => text.insert_str(at, pieces[random(pieces.len())]),
                1 => text.truncate(at),
                _ if at < text.len() => drop(text.remove(at)),
                _ => {}
            }
        }
        let [main, module] = &changed;
        let outcome = Reader::new()
            .define("HALF", "true")
            .module("lib.wgsl", module.as_str())
            .wgsl([("main.wgsl", main.as_str())]);
        match outcome {
            Ok(_) => read += 1,
            Err(invalid) => {
                refused += 1;
                assert!(invalid.rendered.contains("error"), "{}", invalid.rendered);
            }
        }
    }
    assert!(read > 50 && refused > 50, "{read} read, {refused} refused");
}

#[test]
fn deep_imports_are_refused() {
    for text in [
        format!("#import {}b", "a::{".repeat(100_000)),
        format!("#import {}", "a ".repeat(100_000)),
        "#import ".to_owned() + &"a::".repeat(100_000),
    ] {
        let _ = read(&[("a.wgsl", &text)], &[]);
    }
}

#[test]
fn a_value_that_nobody_defined_is_named() {
    let told = help("fn value(x: u32) -> f32 { return f32(x) * #{DEPTH}; }");
    assert_eq!(
        told,
        "`DEPTH` is not defined: `--define DEPTH=VALUE` does so"
    );
}

#[cfg(feature = "glsl")]
#[test]
fn a_glsl_block_without_an_instance_is_called_by_its_own_name() {
    let text = "#version 450
        layout(local_size_x = 8, local_size_y = 8) in;
        layout(std430, set = 0, binding = 0) buffer Sums { float sums[]; };
        void main() { sums[gl_GlobalInvocationID.y * 64u + gl_GlobalInvocationID.x] = 1.0; }";
    let shader = Reader::new()
        .read(Language::Glsl, [("a.comp", text.as_bytes().to_vec())])
        .unwrap_or_else(|invalid| panic!("{}", invalid.rendered));
    let rewritten = rewrite(
        &shader.module,
        &shader.info,
        Entries::PerPixel,
        &Options::default(),
    )
    .expect("a rewrite");
    assert_eq!(rewritten.manifest.entries[0].targets[0].name, "Sums");
}
