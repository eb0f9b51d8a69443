//! What a shader has besides pixels and targets, and how it is to be rewritten: overrides and immediates, intrinsics, atomics by
//! weight, policies, modes; and other entry points in its module.

use vrcs_passes::{
    Code, Options,
    options::{Atomics, Mode, Policy},
};

use super::{
    grammar::{Expect, Generator},
    ids::EntryHead,
    targets::Target,
    values::{Scope, Ty},
};

/// Declares overrides, immediates and intrinsics; whether the shader asks what its pixel shares.
pub fn inputs(g: &mut Generator, scope: &mut Scope) -> bool {
    if g.one_in(6) {
        g.globals.push("override SCALE: f32 = 1.5;".to_owned());
        g.globals
            .push("override TWICE: u32 = u32(SCALE) * 2u;".to_owned());
        g.shape("override values");
        scope.anywhere.extend([("SCALE", Ty::F), ("TWICE", Ty::U)]);
    }
    if g.one_in(8) {
        g.globals
            .push("struct Push {\n    shift: u32,\n    bias: f32,\n}".to_owned());
        g.globals.push("var<immediate> push: Push;".to_owned());
        g.shape("immediates");
        scope
            .anywhere
            .extend([("push.bias", Ty::F), ("push.shift", Ty::U)]);
    }
    let asks = g.one_in(20);
    if asks {
        g.globals.extend([
            "fn vrcs_copies() -> u32 {\n    return 0u;\n}".to_owned(),
            "fn vrcs_rate() -> vec2<u32> {\n    return vec2<u32>(1u);\n}".to_owned(),
        ]);
        scope.anywhere.extend([
            ("(1.0 + f32(vrcs_copies()))", Ty::F),
            ("f32(vrcs_rate().x)", Ty::F),
            ("(8u / (1u + vrcs_copies()))", Ty::U),
            ("vrcs_rate().y", Ty::U),
        ]);
    }
    asks
}

/// Chooses mode, policies and atomics; the last are written at the place at hand.
pub fn choose(
    g: &mut Generator,
    scope: &Scope,
    entry: &EntryHead,
    targets: &[Target],
) -> (Expect, Options) {
    let mut options = Options {
        linear: entry.linear.clone(),
        ..Options::default()
    };
    if entry.is_cooperative {
        return (Expect::Rewritten, options);
    }
    if g.says("vrcs_") {
        g.shape("intrinsics");
        if g.one_in(2) && options.linear.is_none() {
            g.shape("graded");
            options.mode = Mode::Graded;
            return (Expect::Rewritten, options);
        }
    }
    options.mode = match g.below(10) {
        0 => Mode::List,
        1 => Mode::Classified,
        2 => Mode::Auto,
        _ => Mode::Tiled,
    };
    g.shape(match options.mode {
        Mode::List => "mode list",
        Mode::Classified => "mode classified",
        Mode::Auto => "mode auto",
        _ => "mode tiled",
    });
    if g.one_in(8) {
        g.shape("atomics by weight");
        options.atomics = Atomics::Weight;
        atomics(g, scope);
    }
    (policies(g, targets, &mut options), options)
}

/// Gives targets policies other than to be copied.
fn policies(g: &mut Generator, targets: &[Target], options: &mut Options) -> Expect {
    let mut expect = Expect::Rewritten;
    // where every target is full, there is nothing to rewrite
    for target in targets.iter().skip(1) {
        let policy = match g.below(12) {
            0 => Policy::Leader,
            1 if options.mode == Mode::Tiled => Policy::Full,
            _ => continue,
        };
        g.shape(match policy {
            Policy::Full => "policy full",
            _ => "policy leader",
        });
        if policy == Policy::Full {
            expect = Expect::Either(Code::NotSeparable);
        }
        options.targets.insert(target.name.clone(), policy);
    }
    expect
}

/// Writes an atomic whose result nobody uses.
fn atomics(g: &mut Generator, scope: &Scope) {
    let (of, ty) = g.pick(&[("u32", Ty::U), ("i32", Ty::I)]);
    let name = g.name("bins");
    let by_pixel = g.one_in(3);
    let count = if by_pixel { 96 * 96 } else { 16 };
    g.resource(&format!(
        "var<storage, read_write> {name}: array<atomic<{of}>, {count}>;"
    ));
    let condition = scope.value(Ty::B, 2, g);
    let is_conditional = g.one_in(2);
    if is_conditional {
        g.open(format!("if {condition}"));
    }
    let function = g.pick(&[
        "atomicAdd",
        "atomicAdd",
        "atomicSub",
        "atomicMax",
        "atomicMin",
        "atomicOr",
        "atomicAnd",
    ]);
    let value = scope.value(ty, 2, g);
    let at = match by_pixel {
        true => "pixel.y * 96u + pixel.x".to_owned(),
        // (what a loop has changed is refused as a place)
        false => g
            .pick(&[
                "u32(texel.x * 16.0) & 15u",
                "(pixel.x + pixel.y) & 15u",
                "(pixel.x * pixel.y) & 15u",
                "(u32(texel.y * 7.0) ^ pixel.x) & 15u",
                "pack4x8unorm(texel) & 15u",
                "frame.offset & 15u",
            ])
            .to_owned(),
    };
    g.line(format!("{function}(&{name}[{at}], {value});"));
    if is_conditional {
        g.close();
    }
}

/// Writes entry points that are left alone: one for fragments, and one that calls the same helpers.
pub fn other_entries(g: &mut Generator) {
    if !g.one_in(5) {
        return;
    }
    g.shape("other entry points");
    g.line("");
    g.line("@fragment");
    g.open("fn paint(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32>");
    g.line("return frame.tint * at.x;");
    g.close();
    g.line("");
    g.line("@compute @workgroup_size(64)");
    g.open("fn other()");
    for call in std::mem::take(&mut g.others) {
        g.line(call);
    }
    g.close();
}
