//! `vrcs check`: what it tells, and that it never passes what could not have failed.

use crate::{common, folder, shaders, status, stderr, stdout, vrcs};

#[test]
fn check_tells_what_held() {
    let folder = folder();
    let output = vrcs(
        &[
            "check",
            "good.wgsl",
            "--cases",
            "20",
            "--seed",
            "5",
            "--size",
            "40x30",
        ],
        folder.path(),
    );
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let text = stdout(&output);
    assert!(text.starts_with("main: passed"), "{text}");
    for law in [
        "identity",
        "off",
        "replication",
        "locality",
        "contract",
        "partition",
        "builder",
    ] {
        assert!(text.contains(law), "{text}");
    }
    assert!(text.contains("40x30, 20 cases, seed 5"), "{text}");
}

#[test]
fn check_never_passes_what_could_not_have_failed() {
    let folder = folder();
    std::fs::write(
        folder.path().join("constant.wgsl"),
        "@group(0) @binding(0) var a: texture_storage_2d<rgba8unorm, write>;
         @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
             textureStore(a, id.xy, vec4(1.0));
         }",
    )
    .expect("a file");
    let output = vrcs(&["check", "constant.wgsl", "--cases", "4"], folder.path());
    assert_eq!(status(&output), 1);
    assert!(
        stdout(&output).contains("main: inconclusive: `a` is the same everywhere"),
        "{}",
        stdout(&output)
    );
}

#[test]
fn check_ends_a_shader_that_does_not_end() {
    let folder = folder();
    std::fs::write(
        folder.path().join("endless.wgsl"),
        "@group(0) @binding(0) var a: texture_storage_2d<rgba8unorm, write>;
         @group(0) @binding(1) var<uniform> turns: u32;
         @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
             var sum = id.x;
             for (var i = 0u; i < 60000u; i++) { sum = sum * 747796405u + i + turns; }
             textureStore(a, id.xy, vec4(f32(sum & 255u)));
         }",
    )
    .expect("a file");
    let output = vrcs(
        &[
            "check",
            "endless.wgsl",
            "--cases",
            "4",
            "--time-limit",
            "1",
            "--size",
            "1024x1024",
        ],
        folder.path(),
    );
    assert_eq!(status(&output), 1);
    assert!(
        stdout(&output).contains("took longer than 1 s"),
        "{}",
        stdout(&output)
    );
}

#[test]
fn settings_lie_beside_the_shader() {
    let folder = folder();
    std::fs::copy(
        common::shader_path("guarded"),
        folder.path().join("guarded.wgsl"),
    )
    .expect("a copy");
    std::fs::write(
        folder.path().join("guarded.toml"),
        "size = [24, 20]\ncases = 18\n[set]\nborder = 3\n",
    )
    .expect("a file");
    let output = vrcs(&["check", "guarded.wgsl", "--seed", "1"], folder.path());
    assert_eq!(status(&output), 0, "{}{}", stdout(&output), stderr(&output));
    assert!(
        stdout(&output).contains("24x20, 18 cases"),
        "{}",
        stdout(&output)
    );
    std::fs::write(folder.path().join("guarded.toml"), "sizes = [24, 20]\n").expect("a file");
    let output = vrcs(&["check", "guarded.wgsl"], folder.path());
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("guarded.toml"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn check_takes_what_rewrite_takes() {
    let folder = shaders();
    let check = |files: &[&str]| {
        let common = ["--cases", "2", "--size", "16x16", "--seed", "3"];
        vrcs(&[&["check"], files, &common[..]].concat(), folder.path())
    };
    let output = check(&["good/common.wgsl", "good/main.wgsl"]);
    assert_eq!(status(&output), 0, "{}{}", stdout(&output), stderr(&output));
    let output = check(&["in/deep/b.wgsl", "-I", "in/lib", "-D", "SCALE=0.01"]);
    assert_eq!(status(&output), 0, "{}{}", stdout(&output), stderr(&output));
    assert_eq!(status(&check(&["in"])), 2);
}
