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
    let page = with_keys(&page);
    let Some(found) = browser::run(&page, "") else {
        return;
    };
    assert!(found["broken"].is_null(), "{found}");
    assert_eq!(found["problems"], serde_json::json!([]), "{found}");
    let laws = found["laws"].as_array().expect("laws");
    assert_eq!(laws.len(), 6, "{found}");
    assert!(
        laws[5]["name"]
            .as_str()
            .is_some_and(|name| name.starts_with("partition")),
        "{found}"
    );
    assert_eq!(found["stores"], 200 * 72, "each pixel is stored to once");
    for law in laws {
        assert_eq!(law["wrong"], 0, "{law}");
    }
    let shaded = |index: usize| laws[index]["shaded"].as_f64().expect("a share");
    assert_eq!(shaded(0), 1.0);
    assert!((0.24..0.27).contains(&shaded(3)), "{found}");
    assert_eq!(found["order"], serde_json::json!(["picture", "laws"]));
    let keys = &found["keys"];
    assert_eq!(keys["start"], "50", "{keys}");
    assert_eq!(keys["right"], "51", "{keys}");
    assert_eq!(keys["page"], "41", "{keys}");
    assert_eq!(keys["end"], "100", "{keys}");
    assert_eq!(keys["beyond"], "100", "{keys}");
    assert_eq!(keys["home"], "0", "{keys}");
    let colours = found["colours"].as_u64().expect("a number");
    assert!(colours > 1000, "the picture is too plain: {colours}");
}

/// The page, with keys that move its divider before it answers.
fn with_keys(page: &str) -> String {
    let marker = "// where a test serves the page";
    assert!(page.contains(marker));
    let keys = "
        const figure = element('figure');
        const press = (key, shiftKey) => {
            figure.dispatchEvent(new KeyboardEvent('keydown', { key, shiftKey, bubbles: true, cancelable: true }));
            return figure.getAttribute('aria-valuenow');
        };
        outcome.keys = {
            start: figure.getAttribute('aria-valuenow'), right: press('ArrowRight'), page: press('ArrowLeft', true),
            end: press('End'), beyond: press('ArrowRight'), home: press('Home'),
        };
    ";
    page.replace(marker, &format!("{keys}\n{marker}"))
}

#[test]
fn a_browser_without_webgpu_is_told_what_to_do() {
    let source = Source::new("plaza.wgsl", include_str!("../shaders/plaza.wgsl"));
    let page = vrcs::web::page(&source, "plaza", [64, 32]).expect("a page");
    let without = [
        "--disable-blink-features=WebGPU",
        "--disable-features=WebGPU",
    ];
    let Some(found) = browser::run_with(&without, &page, "") else {
        return;
    };
    let why = found["broken"].as_str().expect("a reason");
    assert!(why.contains("WebGPU"), "{found}");
    let steps = found["steps"].as_array().expect("steps");
    assert!(
        steps
            .iter()
            .any(|step| step.as_str().is_some_and(|step| step.contains("Chrome"))),
        "{found}"
    );
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
