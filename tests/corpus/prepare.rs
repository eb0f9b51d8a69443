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
