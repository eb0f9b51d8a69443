//! Shaders whose arithmetic is easily changed: the rewriter must not touch it.

use vrcs::check::{Job, Law};
use vrcs_passes::Source;

use crate::{
    case::{Case, Family},
    common, compiled, pair,
};

pub const FAMILY: Family = Family {
    name: "shaders",
    about: "The rewriter changes no arithmetic: at all rates 1×1 the rewritten shader gives the original's bits, on the same driver, \
            and at coarse rates its primaries' bits. A NaN matches only a NaN at the same place.",
    cases: &[
        Case {
            id: "division",
            name: "dividing by zero, and 0 ÷ 0",
            hazard: "a rewritten expression rounds or folds another way",
            bound: "bit for bit",
            guard: BROKEN,
            run: || {
                identical(
                    "let a = x / y; let b = (x - x) / (y - y); return vec4(a, b, 1.0 / (x * 0.0), -x / y);",
                )
            },
        },
        Case {
            id: "nan",
            name: "NaN made in many ways, and carried on",
            hazard: "NaN becomes a number, or a number NaN",
            bound: "bit for bit, NaN where NaN was",
            guard: BROKEN,
            run: || {
                identical(
                    "let n = sqrt(-1.0 - x); let m = log(-1.0 - y); return vec4(n, max(n, x), n + m, select(x, y, n == n));",
                )
            },
        },
        Case {
            id: "infinity",
            name: "overflow to infinity, ∞ − ∞, ∞ · 0",
            hazard: "an optimiser that assumes finite numbers",
            bound: "bit for bit",
            guard: BROKEN,
            run: || {
                identical(
                    "let big = exp2(56.0 + x); let i = big * big; return vec4(i, i - i, i * (x - x), 1.0 / i);",
                )
            },
        },
        Case {
            id: "denormal",
            name: "numbers near the smallest",
            hazard: "flushing differs between the two programs",
            bound: "bit for bit",
            guard: BROKEN,
            run: || {
                identical(
                    "let tiny = exp2(-140.0 + x * 0.5); return vec4(tiny, tiny * 3.0, tiny - tiny * 0.5, tiny * exp2(30.0));",
                )
            },
        },
        Case {
            id: "sums",
            name: "sums that fused multiply-add would round another way",
            hazard: "a × b + c contracted in one program and not in the other",
            bound: "bit for bit",
            guard: BROKEN,
            run: || {
                identical(
                    "var s = 0.0; for (var i = 1; i < 40; i++) { let f = f32(i); s = s + (x + f) * (y - f) - f * f * 0.1; } let p = x * y; return vec4(s, p - x * y, fma(x, y, -p), s * s - s);",
                )
            },
        },
        Case {
            id: "powers",
            name: "pow, log and sqrt of negatives and of zero",
            hazard: "a polyfill that one program gets and the other does not",
            bound: "bit for bit",
            guard: BROKEN,
            run: || {
                identical("return vec4(pow(-x, y), pow(0.0, x), pow(x, -0.5), exp(log(y - 20.0)));")
            },
        },
        Case {
            id: "integers",
            name: "wrapping, shifting and dividing integers at their limits",
            hazard: "the guard against division by zero is lost or doubled",
            bound: "bit for bit",
            guard: BROKEN,
            run: || {
                identical(
                    "let i = bitcast<i32>(0x80000000u) + i32(x); let u = u32(y) * 0xdeadbeefu; let d = i / (i32(x) - 7); let m = u % (u32(y) & 3u); return bitcast<vec4<f32>>(vec4(u32(i) >> (u & 31u), u, u32(d), m) & vec4(0x7f7fffffu));",
                )
            },
        },
        Case {
            id: "conversions",
            name: "floats out of range, NaN among them, to integers",
            hazard: "a conversion that saturates in one program and wraps in the other",
            bound: "bit for bit",
            guard: BROKEN,
            run: || {
                identical(
                    "let big = exp2(x + 20.0); return vec4(f32(i32(big * 1e3)), f32(u32(-big)), f32(u32(x) * 3u), f32(i32(y * -1e7)));",
                )
            },
        },
        Case {
            id: "packing",
            name: "packed and unpacked halves, norms and bytes",
            hazard: "rounding of a polyfill",
            bound: "bit for bit",
            guard: BROKEN,
            run: || {
                identical(
                    "let p = pack2x16float(vec2(x * 1e3, y * 1e-6)); let q = pack4x8unorm(vec4(x, y, -x, 0.5) / 50.0); return vec4(unpack2x16float(p), unpack4x8unorm(q).xy);",
                )
            },
        },
        Case {
            id: "levels",
            name: "textures sampled by explicit level and gradient, and loaded",
            hazard: "gradients of a remapped invocation are rounded or scaled on the way",
            bound: "bit for bit",
            guard: BROKEN,
            run: || {
                identical(
                    "let at = vec2(x, y) / 40.0; let a = textureLoad(image, vec2<i32>(i32(x) & 7, i32(y) & 7), 0); let b = textureSampleGrad(image, sampling, at, vec2(x * 0.01, 0.0), vec2(0.0, y * 0.02)); return a + vec4(at, -at) * a.wzyx + b * textureSampleLevel(image, sampling, at, y * 0.1);",
                )
            },
        },
        Case {
            id: "halves",
            name: "arithmetic in f16, where the driver has it: overflow, denormals, sums that lose bits",
            hazard: "an f16 expression is widened in one program and not in the other",
            bound: "bit for bit, or the driver has no f16, which is said in the log",
            guard: "as the others; `enable f16` is kept by emit. What differs is told in bits, beside what the separately rounded and the fused arithmetic would give",
            run: halves,
        },
        Case {
            id: "quotients",
            name: "divisions: as wgpu compiles both programs, nothing decorated",
            hazard: "a compiler contracts, reorders or approximates otherwise in the rewritten program",
            bound: "in each component the ULPs that Vulkan's precision leaves to two programs, as the source derives them",
            guard: UNDECORATED,
            run: || compiled::hold(&compiled::QUOTIENTS),
        },
        Case {
            id: "fused",
            name: "sums that fused multiply-add rounds another way, and products less themselves: as wgpu compiles both programs, nothing decorated",
            hazard: "a compiler contracts, reorders or approximates otherwise in the rewritten program",
            bound: "in each component the ULPs that Vulkan's precision leaves to two programs, as the source derives them",
            guard: UNDECORATED,
            run: || compiled::hold(&compiled::SUMS),
        },
        Case {
            id: "transcendentals",
            name: "pow, exp, log and sqrt: as wgpu compiles both programs, nothing decorated",
            hazard: "a compiler contracts, reorders or approximates otherwise in the rewritten program",
            bound: "in each component the ULPs that Vulkan's precision leaves to two programs, as the source derives them",
            guard: UNDECORATED,
            run: || compiled::hold(&compiled::POWERS),
        },
        Case {
            id: "vectors",
            name: "dot, length, normalize and mix: as wgpu compiles both programs, nothing decorated",
            hazard: "a compiler contracts, reorders or approximates otherwise in the rewritten program",
            bound: "in each component the ULPs that Vulkan's precision leaves to two programs, as the source derives them",
            guard: UNDECORATED,
            run: || compiled::hold(&compiled::VECTORS),
        },
        Case {
            id: "saturation",
            name: "conversions, shifts and packing: as wgpu compiles both programs, nothing decorated",
            hazard: "a compiler contracts, reorders or approximates otherwise in the rewritten program",
            bound: "in each component the ULPs that Vulkan's precision leaves to two programs, as the source derives them",
            guard: UNDECORATED,
            run: || compiled::hold(&compiled::CONVERSIONS),
        },
        Case {
            id: "undecorated-halves",
            name: "arithmetic in f16, where the driver has it: as wgpu compiles both programs, nothing decorated",
            hazard: "a compiler contracts, reorders or approximates otherwise in the rewritten program",
            bound: "in each component the ULPs that Vulkan's precision leaves to two programs, as the source derives them",
            guard: UNDECORATED,
            run: || compiled::hold(&compiled::HALVES),
        },
    ],
};

/// How these tests can fail is part of each of them.
const BROKEN: &str = "the outlined function is the author's own arena, untouched: transform/specialise.rs clones it whole. Each case also runs a \
     rewritten module in which that is not so, the operands of subtractions and divisions in the other order and literals 1 % larger, and fails \
     unless its bits differ";

/// How the tests of undecorated programs can fail is part of each of them.
const UNDECORATED: &str = "the bounds of compiled, derived from each expression; each case also runs a rewritten module whose literals are 1 % \
     larger, and fails unless that lies beyond them";

const SIZE: [u32; 2] = [37, 29];

/// Whether two values have the same bits; a NaN, whatever its own, is like any other.
fn is_same(a: [f32; 4], b: [f32; 4]) -> bool {
    let mut both = a.iter().zip(&b);
    both.all(|(a, b)| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan())
}

/// Whether the driver has f16 must not change the table, which is the same for all.
fn halves() -> Result<String, String> {
    if !common::gpu()
        .device
        .features()
        .contains(wgpu::Features::SHADER_F16)
    {
        println!("skipped: halves: this driver has no f16");
        return Ok("equal".to_owned());
    }
    compiled::halves_decorated()?;
    let value = "let h = f16(x * 3000.0); let k = f16(y) * 0.001h; let s = h + h * k - k; return vec4(f32(h), f32(k * 0.0001h), f32(s), f32(h / (k - k)));";
    identical_with("enable f16;\n", value)
}

/// Checks a shader that stores an expression of `x` and `y`, the pixel's column and row as floats.
fn identical(body: &str) -> Result<String, String> {
    let head = match body.contains("image") {
        true => {
            "@group(0) @binding(1) var image: texture_2d<f32>;\n@group(0) @binding(2) var sampling: sampler;\n"
        }
        false => "",
    };
    identical_with(head, body)
}

fn identical_with(head: &str, body: &str) -> Result<String, String> {
    let text = pair::text(head, body);
    let broken = pair::run(&common::gpu(), text.clone(), SIZE, pair::BROKEN)?;
    if broken.pixels().all(|(_, a, b)| is_same(a, b)) {
        return Err("a rewriter that changes arithmetic was not noticed".to_owned());
    }
    let source = Source::new("hard.wgsl", text);
    let mut job = Job::new("main");
    job.size = SIZE;
    job.cases = 16;
    let report = common::run(&source, &job);
    match (&report.failure, report.verdict) {
        (None, vrcs::check::Verdict::Passed) => {
            let times = report.held.get(&Law::Identity).copied().unwrap_or_default();
            match times {
                0 => Err("identity was never held".to_owned()),
                _ => Ok("equal".to_owned()),
            }
        }
        (Some(failure), _) => Err(format!(
            "{}, case {} ({}): {} of pixel {:?}, shaded at {:?}: {}, not {}",
            failure.law,
            failure.case,
            failure.pattern,
            failure.place,
            failure.pixel,
            failure.primary,
            failure.got,
            failure.expected
        )),
        (None, verdict) => Err(format!("{verdict:?}: {:?}", report.why)),
    }
}
