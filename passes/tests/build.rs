//! The build-script API: what it writes, what it tells Cargo, how it fails.

use std::{fs, path::Path, process::Command};

use vrcs_passes::build::Rewriter;

const LIGHT: &str = "#import lib::value
struct Frame { size: vec2<u32>, time: f32 }
@group(0) @binding(0) var mainPicture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(2) var<uniform> frame: Frame;
@compute @workgroup_size(8, 8)
fn shadeAll(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) { return; }
    textureStore(mainPicture, id.xy, vec4(value(id.x)));
}
";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let shaders = folder.path().join("shaders/deep");
    fs::create_dir_all(&shaders).expect("a folder");
    fs::write(shaders.join("light.wgsl"), LIGHT).expect("a file");
    fs::write(
        folder.path().join("shaders/lib.wgsl"),
        "#define_import_path lib\nfn value(x: u32) -> f32 { return f32(x); }\n",
    )
    .expect("a file");
    fs::write(
        folder.path().join("shaders/vertex.wgsl"),
        "@vertex fn v() -> @builtin(position) vec4<f32> { return vec4(1.0); }",
    )
    .expect("a file");
    folder
}

fn rewriter(folder: &Path) -> Rewriter {
    Rewriter::new().folder(folder.join("shaders"))
}

#[test]
fn nothing_to_rewrite_is_an_empty_module() {
    let folder = tempfile::tempdir().expect("a folder");
    let built = Rewriter::new()
        .write_to(folder.path())
        .expect("it is written");
    assert!(built.shaders.is_empty());
    let text = fs::read_to_string(built.module).expect("a module");
    assert!(text.contains("pub struct Binding") && !text.contains("pub mod "));
}

#[test]
fn a_folder_becomes_shaders_and_a_module_that_compiles() {
    let folder = folder();
    let out = folder.path().join("out");
    let built = rewriter(folder.path())
        .write_to(&out)
        .expect("it is written");
    assert_eq!(built.shaders, [out.join("vrcs/deep/light.wgsl")]);
    assert!(out.join("vrcs/deep/light.json").is_file());
    // the folder itself is an input: a new file has to be seen
    for input in ["shaders", "shaders/lib.wgsl", "shaders/deep/light.wgsl"] {
        assert!(built.inputs.contains(&folder.path().join(input)), "{input}");
    }
    let text = fs::read_to_string(&built.module).expect("a module");
    for expected in [
        "pub mod deep_light {",
        "pub mod shade_all {",
        "pub const MAIN_PICTURE: Binding = Binding { group: 0, binding: 0 };",
        "pub const FRAME_SIZE: u32 = 16;",
        "pub const PARAMS: Binding = Binding { group: 1, binding: 0 };",
    ] {
        assert!(text.contains(expected), "no `{expected}` in\n{text}");
    }
    // a program can use it
    let main = folder.path().join("main.rs");
    fs::write(
        &main,
        "#![deny(missing_docs, warnings)]\n//! It.\n/// It.\npub mod shaders { include!(concat!(env!(\"OUT_DIR\"), \"/vrcs.rs\")); }\n\
         use shaders::deep_light::{self, bindings, shade_all};\n\
         const GROUPS: [u32; 3] = shade_all::ENTRY.groups([61, 47, 1]);\n\
         fn main() {\n    assert_eq!(GROUPS, [4, 3, 1]);\n    assert_eq!(bindings::FRAME.binding, 2);\n\
         assert!(deep_light::TEXT.contains(shade_all::ENTRY.name));\n}\n",
    )
    .expect("a file");
    let program = folder.path().join("main");
    let rustc = Command::new(option_env!("RUSTC").unwrap_or("rustc"))
        .args(["--edition", "2024", "-o"])
        .args([&program, &main])
        .env("OUT_DIR", &out)
        .output()
        .expect("rustc runs");
    assert!(
        rustc.status.success(),
        "{}\n{text}",
        String::from_utf8_lossy(&rustc.stderr)
    );
    assert!(Command::new(&program).status().expect("it runs").success());
}

#[test]
fn what_stays_the_same_is_not_written_again() {
    let folder = folder();
    let out = folder.path().join("out");
    let built = rewriter(folder.path())
        .write_to(&out)
        .expect("it is written");
    let time = |path: &Path| {
        fs::metadata(path)
            .and_then(|m| m.modified())
            .expect("a time")
    };
    let files = [built.module.clone(), built.shaders[0].clone()];
    let before: Vec<_> = files.iter().map(|path| time(path)).collect();
    std::thread::sleep(std::time::Duration::from_millis(20));
    rewriter(folder.path())
        .write_to(&out)
        .expect("it is written");
    let after: Vec<_> = files.iter().map(|path| time(path)).collect();
    assert_eq!(before, after);
}

#[test]
fn every_shader_at_fault_is_told_and_nothing_is_written() {
    let folder = folder();
    let shaders = folder.path().join("shaders");
    fs::write(shaders.join("wrong.wgsl"), "fn f(\n").expect("a file");
    fs::write(
        shaders.join("refused.wgsl"),
        LIGHT.replace("value(id.x)", "subgroupAdd(value(id.x))"),
    )
    .expect("a file");
    let out = folder.path().join("out");
    let failed = rewriter(folder.path())
        .write_to(&out)
        .expect_err("two are at fault");
    let text = failed.to_string();
    assert_eq!(failed.messages.len(), 2, "{text}");
    assert!(
        text.contains("refused.wgsl:8:") && text.contains("VRCS016"),
        "{text}"
    );
    assert!(text.contains("wrong.wgsl:"), "{text}");
    assert!(failed.inputs.contains(&shaders.join("wrong.wgsl")));
    assert!(!out.exists());
    // a file that was named has to be a shader that can be rewritten
    let named = |name: &str| Rewriter::new().file(shaders.join(name)).write_to(&out);
    assert!(named("vertex.wgsl").is_err());
    assert!(named("missing.wgsl").is_err());
    assert!(named("notes.txt").is_err());
}

#[test]
fn two_shaders_of_one_name_are_told() {
    let folder = folder();
    let shaders = folder.path().join("shaders");
    fs::write(shaders.join("deep_light.wgsl"), LIGHT).expect("a file");
    let failed = rewriter(folder.path())
        .write_to(&folder.path().join("out"))
        .expect_err("they share a name");
    assert!(failed.to_string().contains("`deep_light`"), "{failed}");
}

#[test]
#[cfg(feature = "spirv")]
fn other_languages_can_be_written() {
    let folder = folder();
    let out = folder.path().join("out");
    let built = rewriter(folder.path())
        .target(vrcs_passes::emit::Language::SpirV)
        .write_to(&out)
        .expect("it is written");
    assert_eq!(built.shaders, [out.join("vrcs/deep/light.spv")]);
    let text = fs::read_to_string(built.module).expect("a module");
    assert!(
        text.contains("pub const BYTES: &[u8] = include_bytes!"),
        "{text}"
    );
}
