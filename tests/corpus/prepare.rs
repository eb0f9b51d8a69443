//! What the crates' own builds and renderers do to the text of a shader before a compiler sees it.
//!
//! Each function takes the crate's folder, the file's path and its text.

use std::path::Path;

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// bevy's mip chains are compiled once for each format.
pub fn texture_format(_: &Path, _: &Path, text: &str) -> String {
    text.replace("##TEXTURE_FORMAT##", "rgba16float")
}

/// vello puts the files that `#import name` names in its place, each once, with nothing defined.
pub fn vello(root: &Path, _: &Path, text: &str) -> String {
    with_named(text, &root.join("shader/shared"))
}

fn with_named(text: &str, shared: &Path) -> String {
    let mut whole = String::new();
    // whether each condition that is open holds
    let mut open: Vec<bool> = Vec::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["#ifdef", ..] => open.push(false),
            ["#ifndef", ..] => open.push(true),
            ["#else", ..] => {
                if let Some(holds) = open.last_mut() {
                    *holds = !*holds;
                }
            }
            ["#endif", ..] => {
                open.pop();
            }
            _ if open.contains(&false) => {}
            ["#import", name] => {
                let text = read(&shared.join(format!("{name}.wgsl")));
                whole.push_str(&with_named(&text, shared));
            }
            _ => {
                whole.push_str(line);
                whole.push('\n');
            }
        }
    }
    whole
}

/// blade includes files by `#include`, declares the constants of the Rust types that `#use` names, and gives each resource the next
/// number.
pub fn blade(_: &Path, path: &Path, text: &str) -> String {
    let folder = path.parent().expect("a folder");
    let mut whole = String::new();
    include(text, folder, &mut whole);
    let mut numbered = String::new();
    let mut binding = 0;
    for line in whole.lines() {
        let is_resource = line.starts_with("var ")
            || line.starts_with("var<uniform>")
            || line.starts_with("var<storage");
        if is_resource {
            numbered.push_str(&format!("@group(0) @binding({binding}) "));
            binding += 1;
        }
        numbered.push_str(line);
        numbered.push('\n');
    }
    // as naga 30 calls it
    numbered.replace("instance_custom_index", "instance_custom_data")
}

fn include(text: &str, folder: &Path, whole: &mut String) {
    for line in text.lines() {
        if let Some(name) = line.strip_prefix("#include") {
            let name = name.trim().trim_matches('"');
            include(&read(&folder.join(name)), folder, whole);
        } else if let Some(name) = line.strip_prefix("#use ") {
            let constants = BLADE
                .iter()
                .find(|(of, _)| *of == name.trim())
                .expect("a type of blade's");
            whole.push_str(constants.1);
        } else {
            whole.push_str(line);
        }
        whole.push('\n');
    }
}

/// The constants of blade's types, as its `src/render/mod.rs` has them.
const BLADE: [(&str, &str); 4] = [
    ("DEBUG_MODE", "const DEBUG_MODE: bool = false;"),
    (
        "DebugMode",
        "const DebugMode_Final = 0u; const DebugMode_Depth = 1u; const DebugMode_DiffuseAlbedoTexture = 2u;
        const DebugMode_DiffuseAlbedoFactor = 3u; const DebugMode_NormalTexture = 4u; const DebugMode_NormalScale = 5u;
        const DebugMode_GeometryNormal = 6u; const DebugMode_ShadingNormal = 7u; const DebugMode_Motion = 8u;
        const DebugMode_HitConsistency = 9u; const DebugMode_SampleReuse = 10u; const DebugMode_Variance = 15u;",
    ),
    (
        "DebugDrawFlags",
        "const DebugDrawFlags_SPACE = 1u; const DebugDrawFlags_GEOMETRY = 2u; const DebugDrawFlags_RESTIR = 4u;",
    ),
    (
        "DebugTextureFlags",
        "const DebugTextureFlags_ALBEDO = 1u; const DebugTextureFlags_NORMAL = 2u;",
    ),
];

/// kiss3d's modules import each other by name, and its build picks an intersector, here the one for devices without ray queries.
pub fn kiss3d(root: &Path, path: &Path, text: &str) -> String {
    let parts: &[&str] = match path.file_name().and_then(|name| name.to_str()) {
        Some("rt_kernel.wgsl") => &[
            "common.wgsl",
            "pbr_env.wgsl",
            "raytrace/rt_preamble.wgsl",
            "raytrace/rt_intersect_bvh.wgsl",
        ],
        Some("denoise.wgsl") => &["common.wgsl"],
        _ => &[],
    };
    let mut whole: String = parts
        .iter()
        .map(|part| read(&root.join("src/builtin").join(part)) + "\n")
        .collect();
    whole.push_str(text);
    let mut kept = String::new();
    let mut is_import = false;
    for line in whole.lines() {
        is_import |= line.starts_with("import ");
        if !is_import && !line.starts_with("@if(hardware)") {
            kept.push_str(line);
            kept.push('\n');
        }
        is_import &= !line.contains(';');
    }
    kept
}

/// filtrate puts a preamble in front of each filter, and numbers in the place of names.
pub fn filtrate(root: &Path, path: &Path, text: &str) -> String {
    const PREAMBLE: &str = "spatial_preamble.wgsl";
    let preamble = match path.ends_with(PREAMBLE) {
        true => String::new(),
        false => read(&root.join("src/shaders/shared").join(PREAMBLE)),
    };
    format!("{preamble}\n{text}")
        .replace("OUTPUT_STORAGE_FORMAT", "rgba16float")
        .replace("WORKGROUP_X", "16")
        .replace("WORKGROUP_Y", "16")
        .replace("PARAM_VEC4S", "16")
}

/// What naga 0.11 renamed outside of functions: `let` to `const`, `type` to `alias`.
fn renamed(text: &str) -> String {
    let mut whole = String::new();
    for line in text.lines() {
        let renamed = [("let ", "const "), ("type ", "alias ")]
            .iter()
            .find_map(|(old, new)| Some(format!("{new}{}", line.strip_prefix(old)?)));
        whole.push_str(renamed.as_deref().unwrap_or(line));
        whole.push('\n');
    }
    whole
}

/// bevy-hikari was written for the bevy that put the text of an imported module in the import's place, each once, and for an
/// old naga.
pub fn hikari(root: &Path, _: &Path, text: &str) -> String {
    let beside = |name: &str| root.with_file_name(name);
    let modules: Vec<(String, String)> = [
        root.join("src/shaders"),
        beside("bevy_pbr-0.9.1").join("src/render"),
        beside("bevy_core_pipeline-0.9.1").join("src/tonemapping"),
    ]
    .iter()
    .flat_map(|folder| std::fs::read_dir(folder).expect("a folder of shaders"))
    .map(|entry| entry.expect("an entry").path())
    .filter(|path| path.extension().is_some_and(|end| end == "wgsl"))
    .filter_map(|path| {
        let text = read(&path);
        let name = text.lines().next()?.strip_prefix("#define_import_path ")?;
        Some((name.trim().to_owned(), text.clone()))
    })
    .collect();
    let mut whole = String::new();
    let mut seen = Vec::new();
    with_modules(text, &modules, &mut seen, &mut whole);
    with_signed_sizes(&renamed(&whole))
}

/// The sizes of textures, all of them flat, were signed before naga 0.11.
fn with_signed_sizes(text: &str) -> String {
    const CALL: &str = "textureDimensions(";
    let mut whole = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(CALL) {
        let end = at + rest[at..].find(')').expect("the end of a call") + 1;
        whole.push_str(&rest[..at]);
        whole.push_str(&format!("vec2<i32>({})", &rest[at..end]));
        rest = &rest[end..];
    }
    whole + rest
}

fn with_modules(
    text: &str,
    modules: &[(String, String)],
    seen: &mut Vec<String>,
    whole: &mut String,
) {
    for line in text.lines() {
        if line.starts_with("#define_import_path") {
            continue;
        }
        let Some(name) = line.strip_prefix("#import ") else {
            whole.push_str(line);
            whole.push('\n');
            continue;
        };
        let name = name.trim().to_owned();
        if !seen.contains(&name) {
            let module = modules.iter().find(|(of, _)| *of == name);
            seen.push(name);
            with_modules(&module.expect("a module").1, modules, seen, whole);
        }
    }
}

/// fidget puts its shaders together from parts, the opcodes of its bytecode before them.
pub fn fidget(root: &Path, path: &Path, text: &str) -> String {
    let folder = path.parent().expect("a folder");
    let name = path.file_name().and_then(|name| name.to_str());
    let is_effect = folder.ends_with("effects/shaders");
    let is_pixel = path.starts_with(root.join("src/pixel"));
    let distance = root.join("src/pixel/shaders/distance_pixel.wgsl");
    let (own, shared): (&[&str], &[&str]) = match name.expect("a name") {
        "color.wgsl" => (&[], &["tape_interpreter", "dummy_stack", "float_ops"]),
        "interval_root.wgsl" | "interval_tiles.wgsl" => (
            &["interval_input", "transform_input"],
            &["interval_ops", "tape_interpreter", "stack", "tape_simplify"],
        ),
        "voxel_tiles.wgsl" | "pixel_tiles.wgsl" => (
            &["transform_input"],
            &["float_ops", "tape_interpreter", "dummy_stack"],
        ),
        "normals.wgsl" => (
            &["transform_input"],
            &["grad_ops", "tape_interpreter", "dummy_stack"],
        ),
        _ => (&[], &[]),
    };
    let mut whole = String::new();
    for (number, operation) in FIDGET.split_whitespace().enumerate() {
        whole.push_str(&format!("const OP_{operation}: u32 = {number};\n"));
    }
    whole.push_str("const REG_COUNT: u32 = 32;\n");
    whole.push_str(text);
    if is_effect && name == Some("color.wgsl") {
        let input = folder.join("../../shaders/transform_input.wgsl");
        whole.push_str(&read(&input));
    }
    if is_pixel {
        whole.push_str(&read(&distance));
    }
    if !(is_pixel && is_effect) {
        whole.push_str(&read(&folder.join("common.wgsl")));
    }
    for part in own {
        whole.push_str(&read(&folder.join(format!("{part}.wgsl"))));
    }
    for part in ["common"].iter().chain(shared) {
        let part = root.join("src/shaders").join(format!("{part}.wgsl"));
        whole.push_str(&read(&part));
    }
    whole
}

/// The operations of fidget's bytecode, in order.
const FIDGET: &str = "OUTPUT INPUT COPY NEG ABS RECIP SQRT SQUARE FLOOR CEIL ROUND NOT RAND SIN COS TAN ASIN ACOS ATAN EXP LN ADD SUB MUL DIV
    ATAN2 COMPARE MIX MOD MIN MAX AND OR MEM";

/// roxlap puts helpers in front of its marchers; the shadows are those of devices with WebGPU's default limits.
pub fn roxlap(root: &Path, path: &Path, text: &str) -> String {
    match path.file_name().and_then(|name| name.to_str()) {
        Some("scene_dda.wgsl" | "sprite_model_dda.wgsl") => {
            format!("{}\n{text}", read(&root.join("shaders/common.wgsl")))
        }
        _ => text.to_owned(),
    }
}

/// flashraw puts one file in front of its kernels.
pub fn flashraw(root: &Path, path: &Path, text: &str) -> String {
    match path.ends_with("to_texture.wgsl") {
        true => text.to_owned(),
        false => format!("{}\n{text}", read(&root.join("shaders/common.wgsl"))),
    }
}

/// lambent's path tracer comes in three modes, here the middle one.
pub fn lambent(_: &Path, _: &Path, text: &str) -> String {
    text.replace("package::default_mode", "package::path_tracing::medium")
        // as naga 30 calls it
        .replace("var<push_constant>", "var<immediate>")
}

/// bevy_elements has two helpers twice in one file, of which WESL's linker takes one.
pub fn elements(_: &Path, path: &Path, text: &str) -> String {
    let mut whole = text.to_owned();
    if path.ends_with("src/noise.wesl") {
        for name in ["perlin3_periodic", "fbm3_periodic"] {
            let head = format!("\nfn {name}(");
            let first = whole.find(&head).expect("the first");
            if let Some(second) = whole[first + 1..].find(&head).map(|at| first + 1 + at) {
                let end = whole[second..].find("\n}\n").expect("its end");
                whole.replace_range(second..second + end + 2, "");
            }
        }
    }
    whole
}

/// bevy_compute_noise has a helper that nothing calls and that says not what it returns.
pub fn noise(_: &Path, _: &Path, text: &str) -> String {
    text.replace("d: f32) {", "d: f32) -> f32 {")
}
