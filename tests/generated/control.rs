//! The bodies of shaders: guards, computations, and stores under every sort of control flow.

use super::{
    grammar::{Generator, Guard},
    targets::Target,
    values::{Scope, Ty},
};

/// Writes the guard; whether a block has to be closed after the body.
pub fn guard(g: &mut Generator) -> bool {
    if g.geometry.checkered {
        g.shape("one colour of a checkerboard");
        let condition = g.pick(&[
            "((pixel.x + pixel.y) & 1u) == 1u",
            "(pixel.x + pixel.y) % 2u != 0u",
            "(pixel.x + pixel.y + 1u) % 2u == 0u",
        ]);
        g.line(format!("if {condition} {{"));
        g.line("    return;");
        g.line("}");
    }
    match g.geometry.guard {
        Guard::None => false,
        Guard::OffByOne => {
            g.line("if pixel.x > frame.width || pixel.y > frame.height {");
            g.line("    return;");
            g.line("}");
            false
        }
        Guard::Border => {
            g.line("if any(pixel < vec2<u32>(2u)) || any(pixel + 2u >= frame.size) {");
            g.line("    return;");
            g.line("}");
            false
        }
        Guard::Right => {
            let condition = g.pick(&[
                "any(pixel >= frame.size)",
                "pixel.x >= frame.width || pixel.y >= frame.height",
                "any(pixel >= textureDimensions(input))",
            ]);
            if g.one_in(4) {
                g.shape("guard around the body");
                g.open("if all(pixel < frame.size)");
                return true;
            }
            g.line(format!("if {condition} {{"));
            g.line("    return;");
            g.line("}");
            false
        }
    }
}

/// Writes computations and stores.
pub fn body(g: &mut Generator, scope: &mut Scope, targets: &[Target]) {
    g.line("let texel = textureLoad(input, pixel, 0);");
    scope.has_texel = true;
    if g.globals.iter().any(|global| global.contains(" state:")) {
        g.line("state = pixel.x + pixel.y * 1973u + 7u;");
    }
    for _ in 0..g.below(4) {
        statement(g, scope);
    }
    // each target once or twice, in any order
    let mut units: Vec<usize> = (0..targets.len()).collect();
    for index in 0..targets.len() {
        if g.one_in(3) {
            units.push(index);
        }
    }
    g.rng.shuffle(&mut units);
    if g.one_in(5) {
        g.shape("early return with a store");
        let condition = scope.value(Ty::B, 2, g);
        g.open(format!("if {condition}"));
        let target = &targets[g.rng.usize(0..targets.len())];
        unit(g, &scope.inner(), target);
        g.line("return;");
        g.close();
    }
    for index in units {
        if g.one_in(3) {
            statement(g, scope);
        }
        unit(g, scope, &targets[index]);
    }
}

/// Writes a computation that adds a name to the scope, or changes a variable of its own.
fn statement(g: &mut Generator, scope: &mut Scope) {
    let ty = g.pick(&[Ty::F, Ty::F, Ty::V4, Ty::V4, Ty::U, Ty::I]);
    let name = g.name("v");
    match g.below(8) {
        0..=2 => {
            let value = scope.value(ty, 3, g);
            g.line(format!("let {name} = {value};"));
        }
        3 => {
            let value = scope.value(ty, 2, g);
            g.line(format!("var {name} = {value};"));
            let condition = scope.value(Ty::B, 2, g);
            let other = scope.value(ty, 2, g);
            g.open(format!("if {condition}"));
            g.line(format!("{name} = {other};"));
            g.close();
        }
        4 => {
            g.shape("loop with a break");
            let value = scope.value(ty, 1, g);
            g.line(format!("var {name} = {value};"));
            let bound = g.pick(&["3u", "frame.step_count"]);
            g.open(format!("for (var i = 0u; i < {bound}; i++)"));
            let mut inner = scope.inner();
            inner.add("i", Ty::U);
            inner.add(&name, ty);
            let condition = inner.value(Ty::B, 2, g);
            let next = inner.value(ty, 2, g);
            g.line(format!("{name} = {next};"));
            g.open(format!("if {condition}"));
            let way_out = g.pick(&["break;", "continue;"]);
            g.line(way_out);
            g.close();
            let last = inner.value(ty, 1, g);
            g.line(format!("{name} = {last};"));
            g.close();
        }
        5 => {
            g.shape("switch over values");
            g.line(format!("var {name}: {};", ty.name()));
            let selector = scope.value(Ty::U, 1, g);
            g.open(format!("switch ({selector} & 3u)"));
            let [a, b, c] = [0; 3].map(|_| scope.value(ty, 2, g));
            g.line(format!("case 0u: {{ {name} = {a}; }}"));
            g.line(format!("case 1u, 2u: {{ {name} = {b}; }}"));
            g.line(format!("default: {{ {name} = {c}; }}"));
            g.close();
        }
        6 => {
            g.shape("helper with a pointer");
            let helper = g.name("blend");
            let mut inner = scope.of_function(&[("k".to_owned(), Ty::F)]);
            inner.has_texel = false;
            g.function(
                &format!("fn {helper}(place: ptr<function, vec4<f32>>, k: f32)"),
                |g| {
                    let by = inner.value(Ty::V4, 1, g);
                    g.line(format!("*place = *place * k + {by};"));
                },
            );
            let value = scope.value(Ty::V4, 2, g);
            g.line(format!("var {name} = {value};"));
            let k = scope.value(Ty::F, 1, g);
            g.line(format!("{helper}(&{name}, {k});"));
            scope.add(&name, Ty::V4);
            return;
        }
        _ => {
            g.shape("helper with returns");
            let helper = g.name("shade");
            let inner = scope.of_function(&[("a".to_owned(), Ty::V4), ("k".to_owned(), Ty::F)]);
            let head = format!("fn {helper}(a: vec4<f32>, k: f32) -> {}", ty.name());
            g.function(&head, |g| {
                let (early, late) = (inner.value(ty, 2, g), inner.value(ty, 2, g));
                g.open("if k > a.x");
                g.line(format!("return {early};"));
                g.close();
                g.line(format!("return {late};"));
            });
            let (a, k) = (scope.value(Ty::V4, 1, g), scope.value(Ty::F, 1, g));
            g.line(format!("let {name} = {helper}({a}, {k});"));
        }
    }
    scope.add(&name, ty);
}

/// Writes stores to a target, under control flow.
fn unit(g: &mut Generator, scope: &Scope, target: &Target) {
    let mut target = target.clone();
    if !target.preparation.is_empty() {
        let at = g.name("at");
        for line in &target.preparation {
            g.line(line.replace("AT", &at));
        }
        target.address = target.address.replace("AT", &at);
        target.preparation.clear();
        target.has_local = true;
    } else if target.block.is_none() && g.one_in(3) {
        let at = g.name("at");
        let keyword = g.pick(&["let", "let", "var"]);
        g.line(format!("{keyword} {at} = {};", target.address));
        target.address = at;
        target.has_local = true;
    }
    // what is read besides is told by the entry point's own names
    if target.beside.is_none() && g.one_in(4) {
        return through_helper(g, scope, &target);
    }
    let target = &target;
    let may_ask_ids = target.one_to_one && g.geometry.affine;
    match g.below(12) {
        0 => {
            g.shape("store in both arms");
            let condition = scope.value(Ty::B, 2, g);
            g.open(format!("if {condition}"));
            stores(g, scope, target);
            g.close();
            g.open("else");
            stores(g, scope, target);
            g.close();
        }
        1 => {
            g.shape("store in one arm");
            let condition = scope.value(Ty::B, 2, g);
            g.open(format!("if {condition}"));
            stores(g, scope, target);
            g.close();
        }
        2 => {
            g.shape("store in a switch");
            let selector = scope.value(Ty::F, 1, g);
            g.open(format!("switch u32(saturate({selector} + texel.x) * 3.0)"));
            for case in ["case 0u:", "case 1u:", "default:"] {
                g.open(case);
                if case != "case 1u:" || g.one_in(2) {
                    stores(g, scope, target);
                }
                g.close();
            }
            g.close();
        }
        3 => {
            g.shape("store in a loop that is left");
            g.open("for (var round = 0u; round < 4u; round++)");
            let mut inner = scope.inner();
            inner.add("round", Ty::U);
            let condition = inner.value(Ty::B, 2, g);
            g.open(format!("if {condition} || round == 3u"));
            stores(g, &inner, target);
            g.line("break;");
            g.close();
            g.close();
        }
        4 => {
            g.shape("stored again and again");
            let again = g.name("again");
            g.line(format!("var {again} = 0u;"));
            g.open("loop");
            let mut inner = scope.inner();
            inner.add(&again, Ty::U);
            stores(g, &inner, target);
            g.open("continuing");
            g.line(format!("{again}++;"));
            let most = g.pick(&["2u", "frame.step_count"]);
            g.line(format!("break if {again} >= {most};"));
            g.close();
            g.close();
        }
        5 if may_ask_ids => {
            g.shape("split screen");
            g.open("if pixel.x < frame.middle * 4u");
            stores(g, scope, target);
            g.close();
            g.open("else");
            stores(g, scope, target);
            g.close();
        }
        6 if may_ask_ids => {
            g.shape("dither");
            g.open("if ((pixel.x + pixel.y) & 1u) == 0u");
            stores(g, scope, target);
            g.close();
        }
        7 => {
            g.shape("store under a uniform");
            g.open("if frame.flip > 2u");
            stores(g, scope, target);
            g.close();
        }
        _ => stores(g, scope, target),
    }
}

/// Writes the store of a target, or those of its block.
fn stores(g: &mut Generator, scope: &Scope, target: &Target) {
    let Some([width, height]) = target.block else {
        let value = target.value(scope, 2, g);
        let address = target.address.clone();
        return target.store(&address, &value, g);
    };
    if g.one_in(2) {
        g.shape("block in loops");
        g.open(format!(
            "for (var block_y = 0u; block_y < {height}u; block_y++)"
        ));
        g.open(format!(
            "for (var block_x = 0u; block_x < {width}u; block_x++)"
        ));
        let mut inner = scope.inner();
        inner.add("block_x", Ty::U);
        let value = target.value(&inner, 2, g);
        target.store(&target.address.clone(), &value, g);
        g.close();
        g.close();
        return;
    }
    g.shape("block without loops");
    for y in 0..height {
        for x in 0..width {
            let address = target
                .address
                .replace("block_x", &format!("{x}u"))
                .replace("block_y", &format!("{y}u"));
            let value = target.value(scope, 1, g);
            target.store(&address, &value, g);
        }
    }
}

/// Writes helpers that store, and calls of them from one place or two.
fn through_helper(g: &mut Generator, scope: &Scope, target: &Target) {
    let put = g.name("put");
    let value_type = target.value_type();
    let takes_address = target.block.is_none() && (target.has_local || g.one_in(2));
    let (parameter, argument) = match takes_address {
        true => (
            format!("at: {}", target.address_type),
            target.address.clone(),
        ),
        false => ("pixel: vec2<u32>".to_owned(), "pixel".to_owned()),
    };
    g.shape(match takes_address {
        true => "helper that stores at its argument",
        false => "helper that finds its place",
    });
    let asks = target.one_to_one && g.geometry.affine && !takes_address && g.one_in(3);
    g.function(
        &format!("fn {put}({parameter}, layer: u32, value: {value_type})"),
        |g| {
            if asks {
                g.shape("guard in a helper");
                g.open("if all(pixel < frame.size)");
            }
            let mut at = target.address.clone();
            if takes_address {
                at = "at".to_owned();
            }
            match target.block {
                None => target.store(&at, "value", g),
                Some([width, height]) => {
                    g.open(format!(
                        "for (var block_y = 0u; block_y < {height}u; block_y++)"
                    ));
                    g.open(format!(
                        "for (var block_x = 0u; block_x < {width}u; block_x++)"
                    ));
                    target.store(&at, "value", g);
                    g.close();
                    g.close();
                }
            }
            if asks {
                g.close();
            }
        },
    );
    let mut callee = put;
    if g.one_in(3) {
        g.shape("helper two calls deep");
        let outer = g.name("put_all");
        let inner = callee.clone();
        let passed = parameter.split(':').next().unwrap_or_default().to_owned();
        g.function(
            &format!("fn {outer}({parameter}, layer: u32, value: {value_type})"),
            |g| g.line(format!("{inner}({passed}, layer, value);")),
        );
        callee = outer;
    }
    let nothing = match takes_address {
        true => format!("{}()", target.address_type),
        false => "vec2<u32>()".to_owned(),
    };
    g.others
        .push(format!("{callee}({nothing}, 0u, {value_type}());"));
    let call = |g: &mut Generator| {
        let value = target.value(scope, 2, g);
        g.line(format!("{callee}({argument}, layer, {value});"));
    };
    match g.below(3) {
        0 => {
            g.shape("helper called from two places");
            let condition = scope.value(Ty::B, 2, g);
            g.open(format!("if {condition}"));
            call(g);
            g.close();
            g.open("else");
            call(g);
            g.close();
        }
        1 => {
            let condition = scope.value(Ty::B, 2, g);
            g.open(format!("if {condition}"));
            call(g);
            g.close();
        }
        _ => call(g),
    }
}
