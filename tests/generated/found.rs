//! What long runs have found, shrunk: each was a defect of the rewriter or of the check, and is held from then on.

use super::{
    grammar::{Expect, Shader},
    judge::{Outcome, judge},
};

const FRAME: &str = "
struct Frame {
    size: vec2<u32>,
    width: u32,
    height: u32,
    tint: vec4<f32>,
}
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
";

/// Checks a text as the shader of a number would be: its options and shading rates come from the number.
fn holds(text: &str, size: [u32; 2], number: u64) {
    let shader = Shader {
        text: format!("{FRAME}{text}"),
        expect: Expect::Rewritten,
        options: vrcs_passes::Options::default(),
        size,
        shapes: Vec::new(),
    };
    let outcome = judge(&super::common::gpu(), &shader, number);
    let held = matches!(outcome, Outcome::Held | Outcome::HeldWhereSeen(_));
    assert!(held, "{outcome:?}");
}

/// Number 324697080088403. Only the first rows of the picture lie in the texture, and whether a pixel stores depends on data:
/// the check took the place of a pixel that it had never seen to store for unknown, though its row told it, and held the
/// value of a primary that stores outside of the texture for impossible.
#[test]
fn few_rows_of_a_line_are_seen_to_be_stored() {
    let text = "
@group(0) @binding(3) var picture: texture_storage_1d<r32sint, read_write>;

@compute @workgroup_size(4, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= frame.size) {
        return;
    }
    let texel = textureLoad(input, pixel, 0);
    let at = pixel.y * (frame.width * STRIDE) + pixel.x;
    if texel.w > 0.8 {
        textureStore(picture, at, textureLoad(picture, at) + i32(texel.w * 9.0));
    }
}
";
    for stride in ["2u", "40u"] {
        for number in 324_697_080_088_403..324_697_080_088_406 {
            holds(&text.replace("STRIDE", stride), [30, 28], number);
        }
    }
}

/// Number 324697080088362. Two stores go to one place, and only the second has a bounds check: whether a pixel beyond the picture
/// gets a copy of the second is the rewriter's choice, and the check insisted on it.
#[test]
fn one_of_two_stores_to_a_place_has_a_bounds_check() {
    let first = "    values[pixel.y * (frame.width + 32u) + pixel.x].z = texel.w;\n";
    let second = "    put(pixel, dot(frame.tint, texel));\n";
    let text = "
@group(0) @binding(4) var<storage, read_write> values: array<vec4<f32>, 3840>;

fn put(pixel: vec2<u32>, value: f32) {
    if all(pixel < frame.size) {
        values[pixel.y * (frame.width + 32u) + pixel.x].z = value;
    }
}

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    let texel = textureLoad(input, pixel, 0);
STORES}
";
    for stores in [format!("{first}{second}"), format!("{second}{first}")] {
        for number in 324_697_080_088_362..324_697_080_088_365 {
            holds(&text.replace("STORES", &stores), [32, 13], number);
        }
    }
}
