//! Reads of memory that the shader writes: which can meet what another invocation stores, and which cannot.

use vrcs_passes::{Code, Options, Source, input, rewrite};

#[derive(Debug, PartialEq)]
enum Answer {
    /// Nobody stores there.
    Never,
    /// At most the invocation itself stores there.
    Own,
    /// Another invocation may.
    Refused,
}

use Answer::{Never, Own, Refused};

/// A shader of targets that are read and written, and its body.
fn shader(body: &str) -> String {
    format!(
        "struct Cell {{ head: u32, items: array<u32, 8> }}
        struct Params {{ size: vec2<u32>, count: u32, base: u32 }}
        @group(0) @binding(0) var<uniform> params: Params;
        @group(0) @binding(1) var<storage, read_write> cells: array<u32>;
        @group(0) @binding(2) var<storage, read_write> lists: array<Cell>;
        @group(0) @binding(3) var image: texture_storage_2d<r32uint, read_write>;
        @group(0) @binding(4) var layers: texture_storage_2d_array<r32uint, read_write>;
        @group(0) @binding(5) var<storage> data: array<u32>;
        @compute @workgroup_size(8, 8)
        fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>,
                @builtin(workgroup_id) group: vec3<u32>) {{
            let x = id.x; let y = id.y; let w = params.size.x; let h = params.size.y;
            let i = y * w + x;
            {body}
        }}"
    )
}

/// What is said of a read, and of nothing else.
fn answer(body: &str) -> Answer {
    let (module, info) = input::wgsl(&Source::new("apart.wgsl", shader(body))).expect(body);
    match rewrite(&module, &info, "main", &Options::default()) {
        Ok(rewritten) => {
            let mut said = rewritten.warnings.iter().map(|(_, finding)| finding.code);
            match said.any(|code| code == Code::SharedState) {
                true => Own,
                false => Never,
            }
        }
        Err(refusal) => {
            for finding in &refusal.findings {
                assert_eq!(
                    finding.code,
                    Code::ReadsOthersOutput,
                    "{body}: {}",
                    finding.message
                );
            }
            Refused
        }
    }
}

/// The bounds that a shader of pictures asks for.
const BOUNDS: &str = "if x >= w || y >= h { return; }";

fn check(cases: &[(Answer, &str)]) {
    for (expected, body) in cases {
        let body = body.replace("BOUNDS", BOUNDS);
        assert_eq!(answer(&body), *expected, "{body}");
    }
}

#[test]
fn a_step_that_tells_invocations_apart() {
    check(&[
        (
            Never,
            "lists[i].items[3] = lists[i].items[2] + lists[i].head;",
        ),
        (
            Own,
            "for (var k = 1u; k < 8u; k++) { lists[i].items[k] = lists[i].items[k - 1u]; }",
        ),
        (
            Own,
            "lists[i].items[data[i] & 7u] = lists[i].items[data[i] >> 29u];",
        ),
        (
            Own,
            "let all = lists[i]; lists[i].items[x & 7u] = all.head;",
        ),
        // the members of a neighbour
        (Refused, "lists[i].items[3] = lists[i + 1u].items[3];"),
        (Never, "lists[i].items[3] = lists[i + 1u].head;"),
        (
            Refused,
            "lists[x].items[y & 7u] = lists[x].items[(y + 1u) & 7u];",
        ),
    ]);
}

#[test]
fn strides() {
    check(&[
        (Own, "cells[i * 4u + 3u] = cells[i * 4u + 3u] + 1u;"),
        (
            Never,
            "cells[i * 4u + 3u] = cells[i * 4u] + cells[i * 4u + 2u];",
        ),
        (
            Own,
            "for (var k = 0u; k < 4u; k++) { cells[i * 4u + k] = cells[i * 4u + 3u - k]; }",
        ),
        (
            Own,
            "cells[(i << 2u) + (data[i] & 3u)] = cells[(i << 2u) + (data[i] >> 1u) % 4u];",
        ),
        (
            Never,
            "for (var k = 0u; k < 3u; k++) { cells[i * 4u + 3u] = cells[i * 4u + k]; }",
        ),
        (
            Never,
            "cells[2u * (y * w + x) + params.base] = cells[2u * x + 1u + y * w * 2u + params.base];",
        ),
        (
            Own,
            "for (var k = 3u; k > 0u; k--) { cells[i * 4u + k] = cells[i * 4u + k - 1u]; }",
        ),
        (
            Refused,
            "for (var k = 4u; k > 0u; k--) { cells[i * 4u + k - 1u] = cells[i * 4u + k]; }",
        ),
        // the next pixel's first
        (Refused, "cells[i * 4u] = cells[i * 4u + 4u];"),
        (
            Refused,
            "for (var k = 0u; k < 5u; k++) { cells[i * 4u] = cells[i * 4u + k]; }",
        ),
        (Refused, "cells[i * 4u] = cells[i * 4u + (data[i] & 7u)];"),
        (Refused, "cells[i * 4u] = cells[i * 4u + params.base];"),
        // by a uniform
        (
            Own,
            "for (var k = 0u; k < params.count; k++) { cells[i * params.count] = cells[i * params.count + k]; }",
        ),
        (
            Refused,
            "for (var k = 0u; k <= params.count; k++) { cells[i * params.count] = cells[i * params.count + k]; }",
        ),
        (
            Refused,
            "for (var k = 0u; k < params.base; k++) { cells[i * params.count] = cells[i * params.count + k]; }",
        ),
    ]);
}

#[test]
fn planes() {
    check(&[
        (
            Own,
            "BOUNDS for (var k = 0u; k < 3u; k++) { let j = i + k * (w * h); cells[j] = cells[j] / 2u + cells[i]; }",
        ),
        (
            Own,
            "BOUNDS cells[i] = cells[i + w * h] + cells[(2u * h + y) * w + x];",
        ),
        (
            Own,
            "BOUNDS cells[i + data[i] * h * w] = cells[i + params.count * w * h];",
        ),
        (Own, "BOUNDS cells[i * 2u] = cells[2u * (i + w * h)];"),
        (Own, "BOUNDS cells[x * h + y] = cells[x * h + y + h * w];"),
        (
            Own,
            "if x > w - 1u || y + 0u > h - 1u { return; } cells[i] = cells[i + w * h];",
        ),
        (
            Own,
            "BOUNDS let j = (group.y * 8u + local.y) * w + group.x * 8u + local.x; cells[j] = cells[j + w * h];",
        ),
        // nothing keeps the pixel inside the picture
        (Refused, "cells[i] = cells[i + w * h];"),
        (
            Refused,
            "if x >= w { return; } cells[i] = cells[i + w * h];",
        ),
        (
            Refused,
            "if x > w || y >= h { return; } cells[i] = cells[i + w * h];",
        ),
        (
            Refused,
            "if x >= h || y >= w { return; } cells[i] = cells[i + w * h];",
        ),
        // a row, or a pixel, on
        (Refused, "BOUNDS cells[i] = cells[i + w];"),
        (Refused, "BOUNDS cells[i] = cells[i + w * h + 1u];"),
        (Refused, "BOUNDS cells[i * 2u] = cells[2u * i + w * h];"),
        (Refused, "BOUNDS cells[i] = cells[i + h * h];"),
        (Refused, "BOUNDS cells[i] = cells[i + (w + 1u) * h];"),
    ]);
}

#[test]
fn ranges() {
    check(&[
        (Never, "cells[16u + i] = cells[0] + cells[data[0] & 15u];"),
        (Never, "cells[16u + i] = cells[min(data[i], 15u)];"),
        (
            Never,
            "for (var k = 0u; k < 16u; k++) { cells[16u + i] = cells[k]; }",
        ),
        (Refused, "cells[16u + i] = cells[16];"),
        (Refused, "cells[16u + i] = cells[data[0] & 31u];"),
        (Refused, "cells[16u + i] = cells[data[0]];"),
        (Refused, "cells[i] = cells[0];"),
        // what wraps may come to anything
        (Refused, "cells[16u + i + data[i]] = cells[0];"),
        (
            Refused,
            "for (var k = 0u; k <= 16u; k++) { cells[16u + i] = cells[k]; }",
        ),
    ]);
}

#[test]
fn layers() {
    check(&[
        (
            Never,
            "textureStore(layers, id.xy, 1, textureLoad(layers, id.xy, 0));",
        ),
        (
            Own,
            "textureStore(layers, id.xy, params.base, textureLoad(layers, id.xy, params.count));",
        ),
        (
            Never,
            "textureStore(layers, id.xy, 1, textureLoad(layers, id.xy + 1u, 0));",
        ),
        (
            Refused,
            "textureStore(layers, id.xy, 1, textureLoad(layers, id.xy + 1u, 1));",
        ),
        // each layer of the dispatch stores its own, and reads another's
        (
            Refused,
            "textureStore(layers, id.xy, id.z, textureLoad(layers, id.xy, id.z + 1u));",
        ),
        (
            Own,
            "textureStore(layers, id.xy, id.z, textureLoad(layers, id.xy, id.z));",
        ),
    ]);
}

#[test]
fn classes_of_pixels() {
    const CROSS: &str = "let steps = array(vec2(-1, 0), vec2(1, 0), vec2(0, -1), vec2(0, 1));
        var sum = 0u;
        for (var k = 0; k < 4; k++) { sum += textureLoad(image, vec2<i32>(id.xy) + steps[k]).x; }
        textureStore(image, id.xy, vec4(sum));";
    const SQUARE: &str = "var sum = 0u;
        for (var dy = -1; dy <= 1; dy++) { for (var dx = -1; dx <= 1; dx++) {
            sum += textureLoad(image, vec2(i32(x) + dx, i32(y) + dy)).x;
        } }
        textureStore(image, id.xy, vec4(sum));";
    let cases = [
        (Never, "if (x + y) % 2u != 1u { return; }", CROSS),
        (Never, "if ((i32(x) + i32(y)) & 1) == 0 { return; }", CROSS),
        (
            Never,
            "if (x & 1u) == 0u || (y & 1u) == 0u { return; }",
            CROSS,
        ),
        (
            Own,
            "if (x & 1u) == 0u || (y & 1u) == 0u { return; }",
            SQUARE,
        ),
        (Own, "if x % 3u != 1u || y % 2u != 0u { return; }", SQUARE),
        // corners of one colour
        (Refused, "if (x + y) % 2u != 1u { return; }", SQUARE),
        // every other row has neighbours in its row
        (Refused, "if y % 2u != 0u { return; }", CROSS),
        (Refused, "if (x + y) % 3u == 0u { return; }", CROSS),
        (Refused, "", CROSS),
        // a rest may be negative
        (Refused, "if (i32(x) - i32(y)) % 2 != 1 { return; }", CROSS),
        // another store leaves the class
        (
            Refused,
            "if x == 7u { textureStore(image, id.xy, vec4(1u)); } if (x + y) % 2u != 1u { return; }",
            CROSS,
        ),
    ];
    for (expected, domain, body) in cases {
        assert_eq!(
            answer(&format!("{domain} {body}")),
            expected,
            "{domain} {body}"
        );
    }
}

#[test]
fn an_atomic_at_a_place_that_others_share_is_no_own_place() {
    let text = "@group(0) @binding(0) var<storage, read_write> cells: array<atomic<u32>>;
        @group(0) @binding(1) var image: texture_storage_2d<r32uint, write>;
        @compute @workgroup_size(8, 8)
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            let i = id.y * 64u + id.x;
            atomicAdd(&cells[i * 2u], 1u);
            textureStore(image, id.xy, vec4(atomicLoad(&cells[i * 2u + PLACE])));
        }";
    for (place, is_refused) in [("0u", true), ("1u", false), ("2u", true)] {
        let source = Source::new("atomic.wgsl", text.replace("PLACE", place));
        let (module, info) = input::wgsl(&source).expect("a shader");
        let options = Options {
            atomics: vrcs_passes::options::Atomics::Weight,
            ..Options::default()
        };
        let rewritten = rewrite(&module, &info, "main", &options);
        assert_eq!(rewritten.is_err(), is_refused, "{place}");
    }
}

#[test]
fn the_authors_word_is_taken_unless_two_pixels_show_that_it_is_false() {
    // pictures of a fixed size one behind the other, of which no bound tells
    let planes = "cells[65536u + i] = cells[i] + cells[data[i] % 65536u];";
    let (code, message) = told(planes, &[]).expect_err("no word is given");
    assert_eq!(code, Code::ReadsOthersOutput);
    assert!(message.contains("`--apart cells`"), "{message}");
    let preconditions = told(planes, &["cells"]).expect("the word is given");
    let word =
        "`cells` is never read where another pixel stores, whatever its data, by the author's word";
    assert!(
        preconditions.iter().any(|said| said == word),
        "{preconditions:?}"
    );

    for body in [
        "cells[i] = cells[i + 1u];",
        "cells[y * 64u + x] = cells[y * 64u + (x ^ 1u)];",
        "let left = textureLoad(image, vec2<i32>(id.xy) - vec2(1, 0)); textureStore(image, id.xy, left);",
    ] {
        let name = if body.contains("image") {
            "image"
        } else {
            "cells"
        };
        let (_, message) = told(body, &[]).expect_err(body);
        assert!(!message.contains("--apart"), "{message}");
        let (code, message) = told(body, &[name]).expect_err(body);
        assert_eq!(code, Code::ReadsOthersOutput, "{body}");
        assert!(message.contains("against the word"), "{message}");
    }
    let (code, message) = told(planes, &["data"]).expect_err("nobody writes `data`");
    assert_eq!(code, Code::UnfitOption);
    assert!(message.contains("`data` cannot be written"), "{message}");
    let (code, message) = told(planes, &["cell"]).expect_err("there is no `cell`");
    assert_eq!(code, Code::UnfitOption);
    assert!(message.contains("did you mean `cells`?"), "{message}");
}

/// What a rewrite takes for granted, or the first finding and its help, where the author gives a word for some targets.
fn told(body: &str, apart: &[&str]) -> Result<Vec<String>, (Code, String)> {
    let (module, info) = input::wgsl(&Source::new("apart.wgsl", shader(body))).expect(body);
    let options = Options {
        apart: apart.iter().map(|&name| name.to_owned()).collect(),
        ..Options::default()
    };
    match rewrite(&module, &info, "main", &options) {
        Ok(rewritten) => Ok(rewritten.manifest.preconditions),
        Err(refusal) => {
            let finding = &refusal.findings[0];
            let help = finding.help.as_deref().unwrap_or_default();
            Err((finding.code, format!("{}: {help}", finding.message)))
        }
    }
}
