//! `vrcs explain` and `vrcs codes`.

use crate::{folder, json, status, stderr, stdout, vrcs};

#[test]
fn explain_tells_what_is_stored_where_and_why() {
    let folder = folder();
    std::fs::write(
        folder.path().join("three.wgsl"),
        "struct View { size: vec2<u32>, stride: u32 }
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(2) var<storage, read_write> depth: array<f32>;
@compute @workgroup_size(8, 8)
fn shade(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size) { return; }
    textureStore(picture, id.xy, vec4(1.0));
    depth[id.y * view.stride + id.x] = f32(id.x);
}
@compute @workgroup_size(8, 8)
fn shuffle(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy ^ vec2(1u), vec4(0.5));
}
@compute @workgroup_size(8, 8)
fn drag(@builtin(global_invocation_id) id: vec3<u32>) {
    depth[id.y * view.stride + id.x] = depth[id.y * view.stride + id.x + 1u];
}
@compute @workgroup_size(64)
fn count(@builtin(global_invocation_id) id: vec3<u32>) {
    depth[id.x] = depth[id.x + 1u];
}
",
    )
    .expect("a file");
    let output = vrcs(&["explain", "three.wgsl"], folder.path());
    let text = stdout(&output);
    for expected in [
        "three.wgsl: shade: rewritten",
        "remapped   global_invocation_id",
        "domain     not (id.x >= view.size.x)",
        "store      `picture` at three.wgsl:8:",
        "offset: d(address)/dx = (1, 0), d(address)/dy = (0, 1)",
        "offset: d(address)/dx = 1, d(address)/dy = view.stride",
        "three.wgsl: shuffle: rewritten",
        "recomputed: the address does not move evenly; `(1u ^ global_invocation_id.x), ",
        "three.wgsl: drag: REFUSED",
        // no pixels: it stays as it is, and is no reason to refuse the file's others
        "three.wgsl: count: left as it is",
    ] {
        assert!(
            text.contains(expected),
            "no `{expected}` in\n{text}{}",
            stderr(&output)
        );
    }
    assert_eq!(status(&output), 1, "one is refused");
    let output = vrcs(
        &["explain", "three.wgsl", "--json", "--entry", "shade"],
        folder.path(),
    );
    assert_eq!(status(&output), 0);
    let report = json(&output);
    assert_eq!(report[0]["entries"][0]["verdict"], "rewritten");
    assert_eq!(report[0]["entries"][0]["stores"][1]["place"]["line"], 9);
    let output = vrcs(&["explain", "three.wgsl", "--entry", "shad"], folder.path());
    assert_eq!(status(&output), 1);
    assert!(
        stderr(&output).contains("did you mean `shade`?"),
        "{}",
        stderr(&output)
    );
    let output = vrcs(&["explain", "bad.wgsl"], folder.path());
    assert_eq!(status(&output), 1);
    assert!(stderr(&output).contains("bad.wgsl:1:1"));
}

/// What every pixel stores for itself is a store, too, and atomics that are weighed are told as such.
#[test]
fn explain_tells_of_full_targets_and_atomics() {
    let folder = folder();
    let shader = "
        @group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;
        @group(0) @binding(1) var normals: texture_storage_2d<r32uint, write>;
        @group(0) @binding(2) var<storage, read_write> count: atomic<u32>;
        @compute @workgroup_size(8, 8)
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            textureStore(normals, id.xy, vec4(id.x));
            textureStore(picture, id.xy, vec4(id.y));
            atomicAdd(&count, 1u);
        }";
    std::fs::write(folder.path().join("three.wgsl"), shader).expect("writable");
    let output = vrcs(
        &[
            "explain",
            "three.wgsl",
            "--json",
            "--target",
            "normals=full",
            "--atomics",
            "weight",
        ],
        folder.path(),
    );
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let told = json(&output);
    let stores = told[0]["entries"][0]["stores"]
        .as_array()
        .cloned()
        .unwrap_or_default();
    let how = |target: &str| {
        let of = stores.iter().filter(|store| store["target"] == target);
        of.map(|store| store["how"].to_string()).collect::<Vec<_>>()
    };
    assert_eq!(how("picture"), ["\"offset\""], "{told}");
    assert_eq!(how("normals"), ["\"full\""], "{told}");
    assert_eq!(how("count"), ["\"weighed\""], "{told}");
}

#[test]
fn codes_are_explained() {
    let folder = folder();
    let output = vrcs(&["explain", "VRCS013"], folder.path());
    assert_eq!(status(&output), 0);
    assert!(
        stdout(&output).contains("reads what other invocations"),
        "{}",
        stdout(&output)
    );
    // with an example, and what its author is told
    let said = stdout(&output);
    assert!(said.contains("textureLoad(heights"), "{said}");
    assert!(said.contains("VRCS013.wgsl:5:"), "{said}");
    assert!(said.contains("help:"), "{said}");
    let output = vrcs(&["codes"], folder.path());
    assert_eq!(status(&output), 0);
    assert!(stdout(&output).lines().count() >= vrcs_passes::Code::ALL.len());
    let output = vrcs(&["codes", "--json"], folder.path());
    assert_eq!(
        json(&output).as_array().map(Vec::len),
        Some(vrcs_passes::Code::ALL.len())
    );
    assert_eq!(status(&vrcs(&["explain", "VRCS777"], folder.path())), 2);
}
