//! The live page, in a headless Chromium: a third implementation, Tint over SwiftShader, holds the laws.

#[path = "common/browser.rs"]
mod browser;

use vrcs_passes::Source;

#[test]
fn the_page_holds_the_laws_in_a_browser() {
    let text = include_str!("../shaders/plaza.wgsl");
    let source = Source::new("plaza.wgsl", text);
    // no multiple of a tile, so that the last tiles are cut
    let page = vrcs::web::page(&source, "plaza", [200, 72]).expect("a page");
    let Some(found) = browser::run(&page, "") else {
        return;
    };
    assert!(found["broken"].is_null(), "{found}");
    assert_eq!(found["problems"], serde_json::json!([]), "{found}");
    let laws = found["laws"].as_array().expect("laws");
    assert_eq!(laws.len(), 5, "{found}");
    for law in laws {
        assert_eq!(law["wrong"], 0, "{law}");
    }
    let shaded = |index: usize| laws[index]["shaded"].as_f64().expect("a share");
    assert_eq!(shaded(0), 1.0);
    assert!((0.24..0.27).contains(&shaded(3)), "{found}");
    let colours = found["colours"].as_u64().expect("a number");
    assert!(colours > 1000, "the picture is too plain: {colours}");
}

#[test]
fn a_shader_that_is_refused_makes_no_page() {
    let source = Source::new(
        "shared.wgsl",
        "@group(0) @binding(1) var<storage, read_write> sums: array<u32>;
        @compute @workgroup_size(8, 8)
        fn shared_sum(@builtin(global_invocation_id) id: vec3<u32>) {
            sums[0] += id.x;
        }",
    );
    let error = vrcs::web::page(&source, "shared_sum", [64, 64]).expect_err("a refusal");
    assert!(error.to_string().contains("shared.wgsl:"), "{error}");
}
