//! Shaders whose arithmetic is easily changed: the rewriter must not touch it.

use vrcs::check::{Job, Law};
use vrcs_passes::Source;

use crate::{
    case::{Case, Family},
    common,
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
            guard: "the outlined function is the author's own arena, untouched (transform/specialise.rs clones it whole); with the operands of its subtractions and divisions swapped in the rewritten module it differs (tried), as the next six do",
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
            guard: "as above; check::nan canonicalises only the payload",
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
            guard: "as above",
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
            guard: "as above",
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
            guard: "as above; no expression of the author's is emitted a second time with its operands in another order",
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
            guard: "as above",
            run: || {
                identical("return vec4(pow(-x, y), pow(0.0, x), pow(x, -0.5), exp(log(y - 20.0)));")
            },
        },
        Case {
            id: "integers",
            name: "wrapping, shifting and dividing integers at their limits",
            hazard: "the guard against division by zero is lost or doubled",
            bound: "bit for bit",
            guard: "as above",
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
            guard: "as above; with each literal times 1.01 it differs (tried), as the next three do",
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
            guard: "as above",
            run: || {
                identical(
                    "let p = pack2x16float(vec2(x * 1e3, y * 1e-6)); let q = pack4x8unorm(vec4(x, y, -x, 0.5) / 50.0); return vec4(unpack2x16float(p), unpack4x8unorm(q).xy);",
                )
            },
        },
        Case {
            id: "levels",
            name: "textures read by explicit level and gradient",
            hazard: "gradients of a remapped invocation are rounded or scaled on the way",
            bound: "bit for bit",
            guard: "as above; the author's gradients are values like any other",
            run: || {
                identical(
                    "let at = vec2(x, y) / 40.0; let a = textureLoad(image, vec2<i32>(i32(x) & 7, i32(y) & 7), 0); return a + vec4(at, -at) * a.wzyx;",
                )
            },
        },
        Case {
            id: "halves",
            name: "arithmetic in f16, where the driver has it: overflow, denormals, sums that lose bits",
            hazard: "an f16 expression is widened in one program and not in the other",
            bound: "bit for bit, or the driver has no f16, which is said in the log",
            guard: "as above; `enable f16` is kept by emit",
            run: halves,
        },
    ],
};

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
    let value = "let h = f16(x * 3000.0); let k = f16(y) * 0.001h; let s = h + h * k - k; return vec4(f32(h), f32(k * 0.0001h), f32(s), f32(h / (k - k)));";
    identical_with("enable f16;\n", value)
}

/// Checks a shader that stores an expression of `x` and `y`, the pixel's column and row as floats.
fn identical(body: &str) -> Result<String, String> {
    let head = match body.contains("image") {
        true => "@group(0) @binding(1) var image: texture_2d<f32>;\n",
        false => "",
    };
    identical_with(head, body)
}

fn identical_with(head: &str, body: &str) -> Result<String, String> {
    let text = format!(
        "{head}@group(0) @binding(0) var out: texture_storage_2d<rgba32float, write>;
fn value(x: f32, y: f32) -> vec4<f32> {{ {body} }}
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
    textureStore(out, id.xy, value(f32(id.x), f32(id.y)));
}}
"
    );
    let source = Source::new("hard.wgsl", text);
    let mut job = Job::new("main");
    job.size = [37, 29];
    job.cases = 32;
    let report = common::run(&source, &job);
    match (&report.failure, report.verdict) {
        (None, vrcs::check::Verdict::Passed) => {
            let times = report.held.get(&Law::Identity).copied().unwrap_or_default();
            match times {
                0 => Err("identity was never held".to_owned()),
                _ => Ok("equal".to_owned()),
            }
        }
        (failure, verdict) => Err(format!("{verdict:?}: {:?} {failure:?}", report.why)),
    }
}
