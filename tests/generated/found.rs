//! What long runs have found, shrunk: each was a defect of the rewriter or of the check, and is held from then on.

use super::{
    grammar::{Expect, Shader},
    judge::{Outcome, judge},
};

/// Checks a text as the shader of a number would be: its options and shading rates come from the number.
fn holds(text: &str, size: [u32; 2], number: u64) {
    let shader = Shader {
        text: text.to_owned(),
        expect: Expect::Rewritten,
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
struct Frame {
    size: vec2<u32>,
    width: u32,
}
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
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
