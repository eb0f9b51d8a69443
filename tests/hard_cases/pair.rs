//! A shader and its rewrite, run side by side at all rates 1×1: what both wrote, pixel by pixel; and how far apart two floats are.
//!
//! *Needs*: a shader that stores one `vec4<f32>` for each pixel to `out`. *Guarantees*: both programs go to the driver in the same way: on a
//! [`Gpu`] that takes SPIR-V with every float operation decorated `NoContraction`, else as wgpu compiles for users.

use vrcs::{
    Rate,
    build::{BuildOptions, Modes, cpu},
    check::{
        coordinates,
        gpu::Gpu,
        inputs::{Maker, Seeds, Settings},
        run::{Build, Code, Program},
    },
    dispatch::reflect,
    sri::Sri,
    view::Params,
};
use vrcs_passes::{
    Options, Source,
    options::{Mode, Sky},
    rewrite,
};

use crate::common;

/// What both programs wrote.
pub struct Pair {
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// Row by row, the original's.
    pub original: Vec<[f32; 4]>,
    /// Row by row, the rewritten shader's.
    pub rewritten: Vec<[f32; 4]>,
}

impl Pair {
    /// Each pixel, with what both wrote.
    pub fn pixels(&self) -> impl Iterator<Item = ([u32; 2], [f32; 4], [f32; 4])> + '_ {
        let both = self.original.iter().zip(&self.rewritten);
        let width = self.size[0];
        (0..)
            .zip(both)
            .map(move |(i, (&a, &b))| ([i % width, i / width], a, b))
    }
}

/// The text of a shader that stores `body`, an expression of the pixel's column and row as floats `x` and `y`.
pub fn text(head: &str, body: &str) -> String {
    format!(
        "{head}@group(0) @binding(0) var out: texture_storage_2d<rgba32float, write>;
fn value(x: f32, y: f32) -> vec4<f32> {{ {body} }}
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
    textureStore(out, id.xy, value(f32(id.x), f32(id.y)));
}}
"
    )
}

/// What is done to a rewritten module before it is run.
pub type Change = fn(&mut naga::Module);

/// Leaves it as it is.
pub const UNCHANGED: Change = |_| {};

/// A rewriter that changes arithmetic a little: each float literal is 1 % larger.
pub const NUDGED: Change = |module| {
    use naga::{Expression, Literal};
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    for expression in functions.flat_map(|function| function.expressions.iter_mut()) {
        match expression.1 {
            Expression::Literal(Literal::F32(value)) => *value *= 1.01,
            Expression::Literal(Literal::F16(value)) => {
                *value = half::f16::from_f32(value.to_f32() * 1.01);
            }
            _ => {}
        }
    }
};

/// One that changes it more: besides, subtractions and divisions have their operands in the other order.
pub const BROKEN: Change = |module| {
    use naga::{BinaryOperator, Expression};
    NUDGED(module);
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    for expression in functions.flat_map(|function| function.expressions.iter_mut()) {
        if let Expression::Binary { op, left, right } = expression.1
            && matches!(op, BinaryOperator::Subtract | BinaryOperator::Divide)
        {
            std::mem::swap(left, right);
        }
    }
};

/// Runs a shader of [`text`] and its rewrite, to which something is done first.
pub fn run(gpu: &Gpu, text: String, size: [u32; 2], change: Change) -> Result<Pair, String> {
    let (module, info) = common::parse(&Source::new("pair.wgsl", text));
    let options = Options::default();
    let mut rewritten = rewrite(&module, &info, "main", &options).map_err(|why| why.to_string())?;
    change(&mut rewritten.module);
    let manifest = &rewritten.manifest.entries[0];
    let resources = reflect::resources(&module, &info, 0).map_err(|why| why.to_string())?;
    let settings = Settings::default();
    let seeds = Seeds {
        uniforms: 1,
        data: 2,
        breadth: 0,
        reach: 0,
    };
    let is_out = |global: naga::Handle<naga::GlobalVariable>| {
        module.global_variables[global].name.as_deref() == Some("out")
    };
    let made = Maker::new(gpu, &module, &settings, size, 1)
        .make(&resources, &is_out, seeds)
        .map_err(|why| why.to_string())?;
    let program = |label, module, info, entry| {
        let build = Build {
            label,
            module,
            info,
            entry,
            code: Code::Module,
            constants: &[],
            immediate_size: 0,
        };
        Program::new(gpu, build).map_err(|why| why.to_string())
    };
    let groups = [size[0].div_ceil(8), size[1].div_ceil(8), 1];
    let original = program("original", &module, &info, 0)?;
    let (original, _) = original
        .run(gpu, &made, &[], &[], groups, &[])
        .map_err(|why| why.to_string())?;

    let extent = [size[0], size[1], 1];
    let built = BuildOptions {
        tile: manifest.tile_for([8, 8, 1]),
        modes: Modes::NONE.with(Mode::Tiled),
        ..BuildOptions::default()
    };
    let full = cpu::build(&Sri::uniform(size[0], size[1], Rate::R1X1), size, &built);
    let params = Params::new(extent, true, [8, 8, 1], Mode::Tiled, size, &built);
    let mut rng = fastrand::Rng::with_seed(1);
    let (words, _) = coordinates::words(&full, Mode::Tiled, Sky::Skip, &mut rng);
    let params = gpu.buffer(
        "params",
        bytemuck::bytes_of(&params),
        wgpu::BufferUsages::UNIFORM,
    );
    let coords = gpu.buffer(
        "coordinates",
        bytemuck::cast_slice(&words),
        wgpu::BufferUsages::STORAGE,
    );
    let at = |index: usize| naga::ResourceBinding {
        group: manifest.bindings[index].group,
        binding: manifest.bindings[index].binding,
    };
    let extras = [(at(0), &params), (at(1), &coords)];
    let groups = manifest.groups_for(extent, [8, 8, 1]);
    let (got, _) = program("rewritten", &rewritten.module, &rewritten.info, 0)?
        .run(gpu, &made, &extras, &[], groups, &[])
        .map_err(|why| why.to_string())?;
    Ok(Pair {
        size,
        original: pixels(&original[0]),
        rewritten: pixels(&got[0]),
    })
}

fn pixels(bytes: &[u8]) -> Vec<[f32; 4]> {
    bytemuck::pod_collect_to_vec::<u8, [f32; 4]>(bytes)
}

/// How far apart two floats are, in units of the last of `digits` binary digits at the larger of them and of `scale`: infinitely far if only one
/// is NaN, or an infinity of its sign; nothing if both are.
pub fn ulps(a: f32, b: f32, scale: f64, digits: i32) -> f64 {
    if a.is_nan() && b.is_nan() || a == b {
        return 0.0;
    }
    if !a.is_finite() || !b.is_finite() {
        return f64::INFINITY;
    }
    let (a, b) = (f64::from(a), f64::from(b));
    let magnitude = a.abs().max(b.abs()).max(scale);
    let exponent = magnitude.log2().floor().max(-126.0) as i32;
    (a - b).abs() / 2f64.powi(exponent - digits + 1)
}
