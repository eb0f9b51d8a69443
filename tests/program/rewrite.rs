//! `vrcs rewrite`: one shader, from files or streams, into any language.

use crate::{
    assert_refused, folder, manifest, shaders, status, stderr, stdout, vrcs, vrcs_with_input,
};

#[test]
fn rewrite_writes_a_shader_and_its_manifest() {
    let folder = folder();
    let output = vrcs(
        &[
            "rewrite",
            "good.wgsl",
            "-o",
            "out.wgsl",
            "--manifest",
            "out.json",
            "--mode",
            "tiled",
        ],
        folder.path(),
    );
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert_eq!(stdout(&output), "");
    let text = std::fs::read_to_string(folder.path().join("out.wgsl")).expect("a shader");
    naga::front::wgsl::parse_str(&text).expect("WGSL");
    let json = std::fs::read_to_string(folder.path().join("out.json")).expect("a manifest");
    let manifest: vrcs_passes::manifest::Manifest =
        serde_json::from_str(&json).expect("a manifest");
    let entry = &manifest.entries[0];
    assert_eq!(entry.name, "main");
    assert_eq!(entry.workgroup_size, [16, 16, 1]);
    assert_eq!(entry.dispatch.groups([61, 47, 1]), [4, 3, 1]);
    assert_eq!((entry.bindings[0].group, entry.bindings[1].binding), (1, 1));
}

#[test]
fn rewrite_reads_and_writes_streams() {
    let folder = folder();
    let good = std::fs::read_to_string(folder.path().join("good.wgsl")).expect("a shader");
    let output = vrcs_with_input(&["rewrite", "-", "-o", "-"], folder.path(), &good);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    naga::front::wgsl::parse_str(&stdout(&output))
        .expect("WGSL, and nothing else, on standard output");
    let again = vrcs(&["rewrite", "good.wgsl"], folder.path());
    assert_eq!(stdout(&again), stdout(&output));
}

#[test]
fn outputs_that_make_no_sense_are_refused() {
    assert_refused(
        &["rewrite", "good.wgsl", "-o", "good.wgsl"],
        2,
        "is the shader itself",
    );
    assert_refused(
        &["rewrite", "good.wgsl", "-o", "./good.wgsl"],
        2,
        "is the shader itself",
    );
    assert_refused(
        &["rewrite", "good.wgsl", "-o", "x", "--manifest", "x"],
        2,
        "cannot go to the same place",
    );
    assert_refused(
        &["rewrite", "good.wgsl", "-o", "no/such/folder/x.wgsl"],
        3,
        "no/such/folder/x.wgsl",
    );
    assert_refused(
        &[
            "rewrite",
            "good.wgsl",
            "-o",
            "out.wgsl",
            "--manifest",
            "no/such/folder/x.json",
        ],
        3,
        "no/such/folder/x.json",
    );
}

#[test]
fn several_files_are_one_shader() {
    let folder = shaders();
    let files = ["good/common.wgsl", "good/main.wgsl"];
    let output = vrcs(
        &[
            "rewrite",
            files[0],
            files[1],
            "-o",
            "one.wgsl",
            "--manifest",
            "one.json",
        ],
        folder.path(),
    );
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let text = std::fs::read_to_string(folder.path().join("one.wgsl")).expect("a shader");
    assert!(text.contains("fn value(") && text.contains("fn vrcs_copy_picture"));
    assert_eq!(
        manifest(&folder.path().join("one.json")).entries[0].name,
        "shade"
    );
    // a message points into the file that it is about
    let output = vrcs(&["rewrite", "good/main.wgsl"], folder.path());
    assert_eq!(status(&output), 1);
    let said = stderr(&output);
    assert!(said.contains("good/main.wgsl:3:39"), "{said}");
    assert!(said.contains("give that file first"), "{said}");
}

#[test]
fn imports_and_definitions_are_understood() {
    let folder = shaders();
    let rewrite = |define: &[&str]| {
        let arguments = [&["rewrite", "in/deep/b.wgsl", "-I", "in/lib"], define].concat();
        vrcs(&arguments, folder.path())
    };
    let output = rewrite(&["-D", "SCALE=0.25"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("0.25"), "{}", stdout(&output));
    // a picture in the folder is nobody's module
    std::fs::write(folder.path().join("in/lib/noise.png"), [0x89, 0xff]).expect("writable");
    assert_eq!(status(&rewrite(&["-D", "SCALE=0.25"])), 0);
    // without the definition the module is at fault, in its own line
    let output = rewrite(&[]);
    assert_eq!(status(&output), 1);
    assert!(
        stderr(&output).contains("noise.wgsl:2:"),
        "{}",
        stderr(&output)
    );
    let output = vrcs(&["rewrite", "in/deep/b.wgsl"], folder.path());
    assert_eq!(status(&output), 1);
    assert!(
        stderr(&output).contains("there is no module `lib::noise`"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn the_output_language_is_told_by_extension_or_flag() {
    let folder = folder();
    let rewrite = |arguments: &[&str]| {
        vrcs(
            &[&["rewrite", "good.wgsl"], arguments].concat(),
            folder.path(),
        )
    };
    for (file, flag) in [
        ("a.spv", None),
        ("a.hlsl", None),
        ("a.metal", None),
        ("a.comp", None),
        ("b.wgsl", None),
        ("a.txt", Some("--to=glsl-460")),
    ] {
        let arguments: Vec<&str> = ["-o", file, "--manifest", "m.json"]
            .into_iter()
            .chain(flag)
            .collect();
        let output = rewrite(&arguments);
        assert_eq!(status(&output), 0, "{file}: {}", stderr(&output));
        assert!(folder.path().join(file).metadata().expect("a file").len() > 100);
        let manifest = manifest(&folder.path().join("m.json"));
        let written = manifest.output.expect("what was written");
        assert_eq!(written.entries.is_empty(), file == "b.wgsl", "{file}");
    }
    // SPIR-V comes in again, and is not rewritten twice
    let output = vrcs(&["rewrite", "a.spv", "-o", "c.spv"], folder.path());
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    assert!(stderr(&output).contains("VRCS"), "{}", stderr(&output));

    let output = rewrite(&["-o", "a.hsl"]);
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("did you mean `.hlsl`?"),
        "{}",
        stderr(&output)
    );
    assert!(stderr(&output).contains(".metal"), "{}", stderr(&output));
    let output = rewrite(&["--to", "mls"]);
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("did you mean `msl`?"),
        "{}",
        stderr(&output)
    );
    let output = vrcs(&["rewrite", "shader.wgls"], folder.path());
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("did you mean `.wgsl`?"),
        "{}",
        stderr(&output)
    );
    let output = rewrite(&["--override", "A=1"]);
    assert_eq!(status(&output), 2, "WGSL keeps its overrides");
}

#[test]
fn the_authors_word_stands_in_the_manifest() {
    let folder = folder();
    let shader = "
        @group(0) @binding(0) var<storage, read_write> a: array<u32>;
        @group(0) @binding(1) var<storage, read_write> b: array<u32>;
        @compute @workgroup_size(8, 8)
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            b[id.y * 64u + id.x] = a[id.x];
        }";
    std::fs::write(folder.path().join("two.wgsl"), shader).expect("writable");
    let rewrite = |pair: &str| {
        let arguments = [
            "rewrite",
            "two.wgsl",
            "-o",
            "o.wgsl",
            "--manifest",
            "m.json",
            "--distinct",
            pair,
        ];
        vrcs(&arguments, folder.path())
    };
    let output = rewrite("a,b");
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let manifest = std::fs::read_to_string(folder.path().join("m.json")).expect("a manifest");
    assert!(
        manifest.contains("`a` and `b` are never the same memory"),
        "{manifest}"
    );
    let output = rewrite("a,c");
    assert_eq!(status(&output), 1);
    assert!(
        stderr(&output).contains("no resource called `c`"),
        "{}",
        stderr(&output)
    );
    assert_eq!(status(&rewrite("a")), 2);
}
