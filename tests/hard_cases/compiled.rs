//! What is left of bit identity where a compiler may contract and reorder: both programs as wgpu compiles them for users, nothing
//! decorated, held against one another in units in the last place.
//!
//! Vulkan says how exact an operation is ("Precision and Operation of SPIR-V Instructions"), and lets a compiler fuse and reassociate what is not
//! `NoContraction`. So both programs lie near the exact value, each within a bound that follows from the expression alone, and within
//! twice that of one another. Where terms cancel, a distance in units of the result would have no bound: it is then told in units of the sum of
//! the terms' magnitudes.

use vrcs::check::gpu::Gpu;

use crate::{
    common,
    pair::{self, NUDGED, Pair, UNCHANGED, ulps},
};

/// How far the programs may be apart in one component.
pub struct Bound {
    /// In units in the last place.
    most: f64,
    /// Of at least this magnitude, by column and row.
    scale: fn(f64, f64) -> f64,
    /// Why.
    why: &'static str,
}

/// Of the result itself, however small.
const RESULT: fn(f64, f64) -> f64 = |_, _| 0.0;

const fn same(why: &'static str) -> Bound {
    Bound {
        most: 0.0,
        scale: RESULT,
        why,
    }
}

const fn within(most: f64, scale: fn(f64, f64) -> f64, why: &'static str) -> Bound {
    Bound { most, scale, why }
}

/// A shader with its bounds.
pub struct Shader {
    head: &'static str,
    body: &'static str,
    /// Binary digits of its floats.
    digits: i32,
    bounds: [Bound; 4],
}

const QUOTIENT: Bound = within(
    5.0,
    RESULT,
    "its operands are whole and exact; a division is exact to 2.5, in each program",
);

pub const QUOTIENTS: Shader = Shader {
    head: "",
    body: "return vec4(x / (y + 1.0), (x + 0.5) / (y - 40.5), 1.0 / (x * x + 1.0), (x - y) / (x + y + 1.0));",
    digits: 24,
    bounds: [QUOTIENT, QUOTIENT, QUOTIENT, QUOTIENT],
};

/// Of the loop in [`SUMS`]: the sum of its terms' magnitudes.
fn of_loop(x: f64, y: f64) -> f64 {
    (1..40)
        .map(f64::from)
        .map(|f| (x + f) * (y - f).abs() + f * f * 0.1)
        .sum()
}

pub const SUMS: Shader = Shader {
    head: "",
    body: "var s = 0.0; for (var i = 1; i < 40; i++) { let f = f32(i); s = s + (x + f) * (y - f) - f * f * 0.1; }
        let p = x * y;
        return vec4(s, p - x * y, fma(x, y, -p), (x * 0.3 + y * 0.7) * (x - y * 0.1) - x);",
    digits: 24,
    bounds: [
        within(
            2.0 * 39.0 * 4.0,
            of_loop,
            "4 inexact operations in each of 39 turns, whatever their order. Loose: an order that only fuses is off by a few",
        ),
        same("the product is whole and exact, fused or not"),
        same("as before"),
        within(
            2.0 * 7.0,
            |x, y| (x * 0.3 + y * 0.7) * (x + y * 0.1) + x,
            "7 operations, each exact to 1",
        ),
    ],
};

pub const POWERS: Shader = Shader {
    head: "",
    body: "return vec4(pow(x + 1.0, 0.45), exp(x * 0.1), log(y + 1.0), sqrt(x));",
    digits: 24,
    bounds: [
        within(
            40.0,
            RESULT,
            "exp2(0.45 log2): 3 of the logarithm's are 10 of the result's at most, and exp2 of 2.4 is exact to 8, in each program",
        ),
        within(
            30.0,
            RESULT,
            "exact to 3 + 2 · 3.6, and 4 from the rounding of its argument, in each program",
        ),
        within(
            8.0,
            |_, _| 1.0,
            "exact to 3, and to 2^-21 around 1, in each program",
        ),
        within(
            10.0,
            RESULT,
            "one over an inverse root: exact to 2 and 2.5, in each program",
        ),
    ],
};

pub const VECTORS: Shader = Shader {
    head: "",
    body: "let v = vec3(x, y, 1.0);
        return vec4(dot(v, vec3(0.3, 0.5, 0.7)), length(v), normalize(v).x, mix(x, y, 0.3));",
    digits: 24,
    bounds: [
        within(
            10.0,
            RESULT,
            "5 operations, each exact to 1; no term is negative",
        ),
        within(
            10.0,
            RESULT,
            "the sum of whole squares is exact; a root is exact to 5",
        ),
        within(
            15.0,
            RESULT,
            "a root, 5, and a division, 2.5, in each program",
        ),
        within(
            12.0,
            |x, y| x + y,
            "6 operations at most, by either formula of mix",
        ),
    ],
};

pub const CONVERSIONS: Shader = Shader {
    head: "",
    body: "let u = u32(y) * 0xdeadbeefu;
        return vec4(f32(i32(x * 1e8)), f32(u32(-x)) + f32(i32(y * -0.37)), f32(u >> (u32(x) & 31u)), unpack2x16float(pack2x16float(vec2(x * 1e3, y))).x);",
    digits: 24,
    bounds: [
        same("whole numbers, and conversions that saturate"),
        same("nothing to fuse before a conversion"),
        same("whole numbers"),
        same("a whole number to a half: nothing to fuse"),
    ],
};

pub const HALVES: Shader = Shader {
    head: "enable f16;\n",
    body: "let h = f16(x * 3000.0); let k = f16(y) * 0.001h;
        return vec4(f32(h), f32(k * 0.0001h), f32(h + h * k - k), f32(h / (k + 1.0h)));",
    digits: 11,
    bounds: [
        same("the product is whole and exact; nothing to fuse before a conversion"),
        within(
            1024.0,
            |_, _| 2f64.powi(-14),
            "a driver may flush what is below the smallest normal half, and may multiply the constants first. Loose: all of it lies below",
        ),
        within(
            2.0 * 4.0,
            |x, y| 3000.0 * x * (1.0 + y * 0.001) + y * 0.001,
            "4 operations, each exact to 1",
        ),
        within(
            2.0 * 4.5,
            RESULT,
            "a product and a sum, exact to 1 each, and a division to 2.5, in each program",
        ),
    ],
};

/// Runs a shader and its rewrite as wgpu compiles them, and holds them against their bounds. How far they were apart is the driver's affair,
/// and goes to the log: the table is the same on every driver.
pub fn hold(shader: &Shader) -> Result<String, String> {
    let gpu = Gpu::open_as_compiled(None).map_err(|error| error.to_string())?;
    let features = gpu.device.features();
    if shader.head.contains("f16") && !features.contains(wgpu::Features::SHADER_F16) {
        println!("skipped: {} has no f16", gpu.info.name);
        return Ok("within them, and beyond with literals 1 % larger".to_owned());
    }
    let run = |change| pair::run(&gpu, pair::text(shader.head, shader.body), [37, 29], change);
    let (pair, nudged) = (run(UNCHANGED)?, run(NUDGED)?);
    // the bounds are not so loose that they would take a rewriter for right that changes arithmetic
    if shader.beyond(&nudged).is_empty() {
        return Err("literals that are 1 % larger were not noticed".to_owned());
    }
    for (component, bound) in shader.bounds.iter().enumerate() {
        let (most, _) = furthest(&pair, component, bound, shader.digits);
        println!(
            "{}, undecorated, component {component}: {most:.2} of {} ULP",
            gpu.info.name, bound.most
        );
    }
    let beyond = shader.beyond(&pair);
    match beyond.is_empty() {
        true => Ok("within them, and beyond with literals 1 % larger".to_owned()),
        false => Err(beyond.join("; ")),
    }
}

impl Shader {
    /// What lies beyond its bound.
    fn beyond(&self, pair: &Pair) -> Vec<String> {
        let components = self.bounds.iter().enumerate();
        let beyond = components.filter_map(|(component, bound)| {
            let (most, place) = furthest(pair, component, bound, self.digits);
            let Bound {
                most: allowed, why, ..
            } = bound;
            (most > *allowed)
                .then(|| format!("component {component}: {most} of {allowed} ULP ({why}): {place}"))
        });
        beyond.collect()
    }
}

/// The largest distance in a component, and where it is, in bits.
fn furthest(pair: &Pair, component: usize, bound: &Bound, digits: i32) -> (f64, String) {
    let mut most = (0.0, String::new());
    for ([x, y], a, b) in pair.pixels() {
        let (a, b) = (a[component], b[component]);
        let scale = (bound.scale)(f64::from(x), f64::from(y));
        let apart = ulps(a, b, scale, digits);
        if apart > most.0 {
            let bits = |v: f32| format!("{v} ({:08x})", v.to_bits());
            let text = format!(
                "pixel ({x}, {y}): original {}, rewritten {}",
                bits(a),
                bits(b)
            );
            most = (apart, text);
        }
    }
    most
}

/// The same pair with every operation decorated, which leaves nothing to a compiler; in each pixel that differs, what the separately rounded
/// and the fused arithmetic of halves would have given.
pub fn halves_decorated() -> Result<(), String> {
    use half::f16;
    let gpu = common::gpu();
    let pair = pair::run(
        &gpu,
        pair::text(HALVES.head, HALVES.body),
        [37, 29],
        UNCHANGED,
    )?;
    // every product of two halves is exact in f64, and so is a sum of two that are this near: rounded once
    let round = |v: f64| f16::from_f64(v).to_f64();
    let mut lines = Vec::new();
    for ([x, y], a, b) in pair.pixels() {
        let h = round(f64::from(x) * 3000.0);
        let thousandth = f16::from_f32(0.001).to_f64();
        let k = round(f64::from(y) * thousandth);
        let apart = [
            h,
            round(k * f16::from_f32(0.0001).to_f64()),
            round(round(h + round(h * k)) - k),
            round(h / round(k + 1.0)),
        ];
        let fused = [apart[0], apart[1], round(round(h + h * k) - k), apart[3]];
        for i in 0..4 {
            if ulps(a[i], b[i], 0.0, 11) > 0.0 {
                let half = |v: f64| format!("{v} ({:04x})", f16::from_f64(v).to_bits());
                lines.push(format!(
                    "pixel ({x}, {y}), component {i}: original {} ({:08x}), rewritten {} ({:08x}); rounded apart {}, fused {}",
                    a[i], a[i].to_bits(), b[i], b[i].to_bits(), half(apart[i]), half(fused[i])
                ));
            }
        }
    }
    match lines.len() {
        0 => Ok(()),
        count => {
            lines.truncate(12);
            Err(format!(
                "{count} values differ on {}:\n  {}",
                gpu.info.name,
                lines.join("\n  ")
            ))
        }
    }
}
