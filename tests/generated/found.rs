//! What long runs have found, shrunk: each was a defect of the rewriter or of the check, and is held from then on.

use vrcs_passes::{
    Code, Options,
    options::{Atomics, Linear, Mode, Policy},
};

use super::{
    grammar::{Expect, Shader},
    judge::{Outcome, judge, rewritten},
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
    holds_with(text, Options::default(), size, number);
}

fn holds_with(text: &str, options: Options, size: [u32; 2], number: u64) {
    let shader = Shader {
        text: format!("{FRAME}{text}"),
        expect: Expect::Rewritten,
        options,
        size,
        shapes: Vec::new(),
        warnings: Vec::new(),
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

/// Number 7000053. Every second pixel has nothing but an atomic, which no data of the check reaches: the check took these pixels
/// to lie outside of the domain.
#[test]
fn a_pixel_that_is_never_seen_to_store_may_be_in_the_domain() {
    let text = "
@group(0) @binding(2) var<storage, read_write> values: array<f32>;
@group(0) @binding(3) var<storage, read_write> bins: array<atomic<i32>, 16>;

@compute @workgroup_size(5, 7)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel < vec2<u32>(2u)) || any(pixel + 2u >= frame.size) {
        return;
    }
    let texel = textureLoad(input, pixel, 0);
    if ((pixel.x + pixel.y) & 1u) == 0u {
        values[pixel.y * frame.size.x + pixel.x] = f32(pixel.y);
    }
    if texel.w > 1000.0 {
        atomicMax(&bins[pixel.x & 15u], i32(pixel.y));
    }
}
";
    let options = Options {
        atomics: Atomics::Weight,
        ..Options::default()
    };
    holds_with(text, options, [32, 18], 7_000_053);
}

/// Numbers 2006006081 and 2007006038, and a dozen like them. Where an atomic goes is a function of the ids that lies in no pattern,
/// or looks as if data had a part in it and has none: the check knew neither the places of pixels that it had not seen there, nor
/// that a place which data chooses is the primary's.
#[test]
fn atomics_go_to_places_that_are_shared() {
    let text = "
@group(0) @binding(3) var<storage, read_write> bins: array<atomic<i32>, 16>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= frame.size) {
        return;
    }
    let texel = textureLoad(input, pixel, 0);
    let nothing = u32(fract(f32(pixel.y)));
    if CONDITION {
        FUNCTION(&bins[PLACE & 15u], i32(texel.z * 9.0) - 4);
    }
}
";
    let weight = || Options {
        atomics: Atomics::Weight,
        ..Options::default()
    };
    let places = [
        "(pixel.y * pixel.x)",
        "(pixel.y - (u32(texel.y * 7.0) & nothing))",
    ];
    for place in places {
        for (condition, function) in [
            ("texel.y < 0.2", "atomicAdd"),
            ("true", "atomicSub"),
            ("texel.y < 0.2", "atomicMin"),
        ] {
            let text = text
                .replace("CONDITION", condition)
                .replace("FUNCTION", function)
                .replace("PLACE", place);
            holds_with(&text, weight(), [19, 13], 2_006_006_081);
        }
    }
}

/// Number 2005006017. A target that is stored for every pixel is told that its pixel shares nothing: the check had it told what the
/// rest of the shader is.
#[test]
fn what_runs_for_every_pixel_shares_nothing() {
    let text = "
@group(0) @binding(2) var coarse: texture_storage_2d<rgba32sint, write>;
@group(0) @binding(3) var fine: texture_storage_2d<rgba32sint, write>;

fn vrcs_rate() -> vec2<u32> {
    return vec2<u32>(1u);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let value = vec4<i32>(vec4<u32>(id.xy, vrcs_rate()));
    textureStore(fine, id.xy, value);
    textureStore(coarse, id.xy, value);
}
";
    let mut options = Options::default();
    options.targets.insert("fine".to_owned(), Policy::Full);
    holds_with(text, options, [29, 23], 2_005_006_017);
}

/// Numbers 2011006098 and 2003006100. Graded mode asks for what a pixel shares by the ids of the dispatch, and took the number of a
/// pixel for its column: such a dispatch is refused.
#[test]
fn graded_mode_takes_no_dispatch_of_one_dimension() {
    let text = "
@group(0) @binding(2) var picture: texture_storage_2d<rgba16float, write>;

fn vrcs_copies() -> u32 {
    return 0u;
}

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = vec2<u32>(id.x % frame.width, id.x / frame.width);
    textureStore(picture, pixel, vec4<f32>(f32(vrcs_copies())));
}
";
    let options = Options {
        mode: Mode::Graded,
        linear: Some(Linear::Pixels(26)),
        ..Options::default()
    };
    let shader = Shader {
        text: format!("{FRAME}{text}"),
        expect: Expect::Refused(Code::UnfitOption),
        options: options.clone(),
        size: [26, 20],
        shapes: Vec::new(),
        warnings: Vec::new(),
    };
    let refused = rewritten(&shader, &options);
    assert!(
        matches!(refused, Ok(Err(Code::UnfitOption))),
        "{:?}",
        refused.err()
    );
}

/// Number 6007018178. With a number no larger than 2²⁴ the condition holds in column 0 and nowhere else, so the check took the other
/// columns for outside the domain; with a number far below, a place added to it is lost, and any pixel stores.
#[test]
fn a_condition_that_data_make_one_of_the_ids() {
    let text = "
@group(0) @binding(2) var<storage, read_write> values: array<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= frame.size) {
        return;
    }
    let texel = textureLoad(input, pixel, 0);
    if !(texel.x < f32(pixel.x) + texel.x) {
        values[pixel.y * frame.width + pixel.x] = texel.y;
    }
}
";
    holds(text, [31, 23], 6_007_018_178);
}
