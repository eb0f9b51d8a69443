//! Rewritten text is accepted by Tint wherever Tint accepts the author's text.

#[path = "common/browser.rs"]
mod browser;
mod common;

use std::{collections::BTreeMap, path::Path};

use vrcs_passes::{Entries, Options, emit, input::Reader, options::Barriers, rewrite};

/// All shaders of the tests that are rewritten.
fn shaders() -> BTreeMap<String, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut shaders = BTreeMap::new();
    for folder in [
        "tests/shaders",
        "tests/barrier_shaders",
        "passes/tests/rewritten",
    ] {
        for entry in std::fs::read_dir(root.join(folder)).expect("shaders") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                continue;
            }
            let text = std::fs::read_to_string(&path).expect("a shader");
            let before = text
                .split("// ---- becomes ----")
                .next()
                .unwrap_or_default()
                .to_owned();
            let name = path
                .strip_prefix(root)
                .expect("a shader of ours")
                .display()
                .to_string();
            shaders.insert(name, before);
        }
    }
    let plaza = std::fs::read_to_string(root.join("shaders/plaza.wgsl")).expect("a shader");
    shaders.insert("shaders/plaza.wgsl".to_owned(), plaza);
    for scene in vrcs::scenes::SceneName::ALL {
        shaders.insert(
            format!("the scene {scene}"),
            scene.source().text().to_owned(),
        );
    }
    shaders.insert("directives".to_owned(), DIRECTIVES.to_owned());
    shaders.insert("deep".to_owned(), deep());
    shaders
}

/// Directives have to come back, and in front.
const DIRECTIVES: &str = "
requires readonly_and_readwrite_storage_textures, pointer_composite_access;
diagnostic(off, derivative_uniformity);
diagnostic(warning, subgroup_uniformity);
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4(f32(id.x)));
}";

/// A sum that naga's writer would nest deeper than Tint reads.
fn deep() -> String {
    let terms: String = (0..600).map(|i| format!(" + f32(id.x * {i}u)")).collect();
    DIRECTIVES.replace("f32(id.x)", &format!("0.5{terms}"))
}

#[test]
fn tint_accepts_what_is_rewritten() {
    let mut texts = BTreeMap::new();
    for (name, before) in shaders() {
        let shader = Reader::new()
            .wgsl([(name.as_str(), before.as_str())])
            .expect("a valid shader");
        let (module, info) = (&shader.module, &shader.info);
        let rewritten = rewrite(module, info, Entries::PerPixel, &Options::default())
            .unwrap_or_else(|refusal| panic!("{name}: {refusal}"));
        let (module, info) = (&rewritten.module, &rewritten.info);
        let text = emit::wgsl_with(module, info, &shader.directives).expect("text");
        // work that is done together, masked: there a barrier stands before each look at who is a primary
        if name.contains("barrier_shaders") {
            let options = Options {
                barriers: Barriers::Mask,
                ..Options::default()
            };
            let (module, info) = (&shader.module, &shader.info);
            let masked = rewrite(module, info, Entries::PerPixel, &options)
                .unwrap_or_else(|refusal| panic!("{name}, masked: {refusal}"));
            let masked = emit::wgsl_with(&masked.module, &masked.info, &shader.directives);
            texts.insert(format!("{name}, masked after"), masked.expect("text"));
            texts.insert(format!("{name}, masked before"), before.clone());
        }
        texts.insert(format!("{name} before"), before);
        texts.insert(format!("{name} after"), text);
    }
    let Some(found) = browser::tint(&texts) else {
        return;
    };
    assert_eq!(found.len(), texts.len());
    let mut accepted = 0;
    for (name, messages) in &found {
        let Some(name) = name.strip_suffix(" before") else {
            continue;
        };
        let after = &found[&format!("{name} after")];
        if messages.is_empty() {
            assert!(
                after.is_empty(),
                "{name}: {after:?}\n{}",
                texts[&format!("{name} after")]
            );
            accepted += 1;
        } else {
            println!("Tint does not accept {name} as it was: {messages:?}");
        }
    }
    assert!(
        accepted > 70,
        "only {accepted} shaders were accepted before they were rewritten"
    );
}

#[test]
fn tint_is_asked_in_earnest() {
    let texts = BTreeMap::from([
        ("wrong".to_owned(), "fn f() { x }".to_owned()),
        ("right".to_owned(), "fn f() { }".to_owned()),
    ]);
    if let Some(found) = browser::tint(&texts) {
        assert!(!found["wrong"].is_empty());
        assert!(found["right"].is_empty());
    }
}
