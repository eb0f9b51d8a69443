//! The fuzz targets on the stable toolchain, for a few seconds: random changes to the tests' shaders, and random text.
//! `VRCS_FUZZ_SECONDS` makes it longer; `tests/fuzz` is the crate for cargo-fuzz.

mod common;
#[path = "fuzz/targets.rs"]
#[allow(dead_code, reason = "each target is called by one test")]
mod targets;

use std::{
    panic::catch_unwind,
    time::{Duration, Instant},
};

use fastrand::Rng;

/// Calls a target with inputs from `make` until the time is up.
fn fuzz(target: fn(&[u8]), mut make: impl FnMut(&mut Rng) -> Vec<u8>) {
    let seconds = match std::env::var("VRCS_FUZZ_SECONDS") {
        Ok(seconds) => seconds.parse().expect("VRCS_FUZZ_SECONDS is a number"),
        Err(_) => 4,
    };
    let mut rng = Rng::with_seed(common::seed());
    let end = Instant::now() + Duration::from_secs(seconds);
    let mut tried = 0;
    while Instant::now() < end || tried == 0 {
        let data = make(&mut rng);
        tried += 1;
        if catch_unwind(|| target(&data)).is_err() {
            panic!("input number {tried} fails: {data:?}");
        }
    }
    println!("{tried} inputs");
}

#[test]
fn changed_shaders_neither_panic_nor_become_invalid() {
    fuzz(targets::mutated, |rng| {
        let changes = rng.usize(1..5);
        (0..1 + 4 * changes).map(|_| rng.u8(..)).collect()
    });
}

#[test]
fn any_text_is_read_or_refused() {
    let words = [
        "fn ",
        "main",
        "(",
        ")",
        "{",
        "}",
        "@compute ",
        "@workgroup_size(8, 8) ",
        "var",
        "<storage, read_write>",
        " a",
        ": ",
        "array<",
        "u32",
        ">",
        ";",
        "@group(0) @binding(0) ",
        "let ",
        " = ",
        "1u",
        "+",
        "if ",
        "loop ",
        "return",
        "vec2",
        ",",
        "textureStore",
        "@builtin(global_invocation_id) id: vec3<u32>",
        "id.xy",
        "struct ",
        "override ",
        "\u{1f600}",
        "/*",
        "//",
        "\n",
        "a[id.y * 64u + id.x]",
        "#import ",
        "#ifdef ",
        "enable ",
        "0x",
        "1e",
    ];
    fuzz(targets::text, |rng| {
        let length = rng.usize(0..120);
        let mut text = vec![rng.u8(..)];
        for _ in 0..length {
            match rng.u8(0..12) {
                0 => text.push(rng.u8(..)),
                _ => text.extend(words[rng.usize(..words.len())].bytes()),
            }
        }
        text
    });
}
