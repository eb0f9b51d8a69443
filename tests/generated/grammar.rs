//! Random well-typed pixel shaders, as WGSL text.
//!
//! *Does*: from a seed, makes a shader of the kinds that people write: one invocation works for one pixel (or a block of
//! pixels), computes something from textures, buffers and uniforms with control flow of every sort, and stores it in several
//! targets at addresses that range from `id.xy` to a Morton curve.
//! *Guarantees*: the text is valid WGSL; the original has no race (unless it says so); and the generator
//! knows whether the rewriter must take the shader or must refuse it, so that refusing too much is found as well.
//!
//! One statement stands on a line, and a block's brackets end and begin lines: the [shrinker](super::shrink) relies on it
//! for speed, not for its result.

use fastrand::Rng;
use vrcs_passes::{
    Code, Options,
    options::{Mode, Policy},
};

use super::{extras, targets::Target, values::Scope};

/// What has to become of a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Expect {
    /// It has to be rewritten, and the laws have to hold.
    Rewritten,
    /// It has to be refused, with this code among the reasons.
    Refused(Code),
    /// As [`Expect::Rewritten`], or refused with this code: whether that is right takes an analysis that a generator has not.
    Either(Code),
}

/// A shader, and what is known of it.
#[derive(Clone, Debug)]
pub struct Shader {
    pub text: String,
    pub expect: Expect,
    /// How it is to be rewritten, apart from what [`judge`](super::judge) chooses.
    pub options: Options,
    /// The picture that it is made for.
    pub size: [u32; 2],
    /// The shapes in it, for the count of what was tried.
    pub shapes: Vec<&'static str>,
    /// What the author has to be warned of where it is rewritten.
    pub warnings: Vec<Code>,
}

/// How the shader keeps out what lies beyond the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guard {
    /// Not at all.
    None,
    /// One column and one row too many pass.
    OffByOne,
    /// Rightly.
    Right,
    /// A border is left out as well.
    Border,
}

/// What the addresses may rely on.
#[derive(Clone, Copy, Debug)]
pub struct Geometry {
    pub size: [u32; 2],
    pub group: [u32; 2],
    pub guard: Guard,
    /// Whether every target has a layer for each z.
    pub layered: bool,
    /// Whether only cells of one colour of a checkerboard store anything.
    pub checkered: bool,
    /// Whether the rewriter knows how the pixel moves with the ids, so that conditions on the ids are allowed at a store.
    pub affine: bool,
}

impl Geometry {
    /// Whether no invocation outside the picture stores.
    pub fn is_confined(&self) -> bool {
        matches!(self.guard, Guard::Right | Guard::Border)
    }

    /// Layers of the targets, as the check has them.
    pub fn layers(&self) -> u32 {
        if self.layered { 3 } else { 1 }
    }
}

/// The text of a shader while it grows.
pub struct Generator {
    pub rng: Rng,
    pub geometry: Geometry,
    /// Variables of the module, with their bindings.
    pub globals: Vec<String>,
    /// Functions.
    pub functions: Vec<String>,
    pub shapes: Vec<&'static str>,
    /// What other entry points of the module do.
    pub others: Vec<String>,
    lines: Vec<String>,
    depth: usize,
    bindings: u32,
    names: u32,
}

impl Generator {
    /// A number below `n`.
    pub fn below(&mut self, n: u32) -> u32 {
        self.rng.u32(0..n)
    }

    /// True once in `n` times.
    pub fn one_in(&mut self, n: u32) -> bool {
        self.rng.u32(0..n) == 0
    }

    pub fn pick<T: Clone>(&mut self, of: &[T]) -> T {
        of[self.rng.usize(0..of.len())].clone()
    }

    /// A name that is not taken.
    pub fn name(&mut self, stem: &str) -> String {
        self.names += 1;
        format!("{stem}{}", self.names)
    }

    /// Notes a shape.
    pub fn shape(&mut self, shape: &'static str) {
        if !self.shapes.contains(&shape) {
            self.shapes.push(shape);
        }
    }

    /// Declares a resource.
    pub fn resource(&mut self, declaration: &str) {
        let binding = self.bindings;
        self.bindings += 1;
        let group = if self.geometry.layered && binding > 3 {
            1
        } else {
            0
        };
        self.globals
            .push(format!("@group({group}) @binding({binding}) {declaration}"));
    }

    pub fn line(&mut self, text: impl AsRef<str>) {
        self.lines
            .push(format!("{}{}", "    ".repeat(self.depth), text.as_ref()));
    }

    /// Opens a block: `head {`.
    pub fn open(&mut self, head: impl AsRef<str>) {
        self.line(format!("{} {{", head.as_ref()).trim_start());
        self.depth += 1;
    }

    pub fn close(&mut self) {
        self.depth -= 1;
        self.line("}");
    }

    /// Whether what has been written says something.
    pub fn says(&self, text: &str) -> bool {
        let mut written = self.lines.iter().chain(&self.functions);
        written.any(|line| line.contains(text))
    }

    /// Writes a function: what `body` writes goes into it.
    pub fn function(&mut self, head: &str, body: impl FnOnce(&mut Generator)) {
        let outer = std::mem::take(&mut self.lines);
        let depth = std::mem::replace(&mut self.depth, 0);
        self.open(head);
        body(self);
        self.close();
        let lines = std::mem::replace(&mut self.lines, outer);
        self.depth = depth;
        self.functions.push(lines.join("\n") + "\n");
    }
}

const FRAME: &str = "struct Frame {
    size: vec2<u32>,
    width: u32,
    height: u32,
    gain: f32,
    threshold: f32,
    flip: u32,
    step_count: u32,
    middle: u32,
    offset: u32,
    tint: vec4<f32>,
}
";

/// Makes the shader of a seed.
pub fn shader(seed: u64) -> Shader {
    let mut rng = Rng::with_seed(seed);
    let size = [rng.u32(13..36), rng.u32(13..36)];
    let mut generator = Generator {
        geometry: Geometry {
            size,
            group: [8, 8],
            guard: Guard::Right,
            layered: rng.u8(0..10) == 0,
            checkered: rng.u8(0..24) == 0,
            affine: true,
        },
        rng,
        globals: Vec::new(),
        functions: Vec::new(),
        shapes: Vec::new(),
        others: Vec::new(),
        lines: Vec::new(),
        depth: 0,
        bindings: 0,
        names: 0,
    };
    let uses_half = generator.one_in(12);
    let mut head = match uses_half {
        true => format!("enable f16;\n{FRAME}"),
        false => FRAME.to_owned(),
    };
    generator.resource("var<uniform> frame: Frame;");
    generator.resource("var input: texture_2d<f32>;");
    let mut scope = Scope::inputs(&mut generator);
    let asks = extras::inputs(&mut generator, &mut scope);
    let entry = super::ids::choose(&mut generator);
    head.push_str(&entry.declarations);
    generator.geometry.group = entry.group;
    generator.geometry.affine = entry.affine;
    generator.geometry.guard = match generator.below(8) {
        _ if entry.needs_guard => Guard::Right,
        0 => Guard::None,
        1 => Guard::OffByOne,
        2 => Guard::Border,
        _ => Guard::Right,
    };
    let count = generator.pick(&[1, 1, 2, 2, 3, 4]);
    let mut textures = 0;
    let targets: Vec<Target> = (0..count)
        .map(|_| Target::choose(&mut generator, &mut textures, uses_half))
        .collect();

    generator.depth = 0;
    generator.line(&entry.attributes);
    generator.open(&entry.signature);
    for line in &entry.pixel {
        generator.line(line);
    }
    for (name, ty) in &entry.names {
        scope.add(name, *ty);
    }
    let closes = super::control::guard(&mut generator);
    super::control::body(&mut generator, &mut scope, &targets);
    let is_plain = entry.linear.is_none() && !entry.is_cooperative && !asks;
    let (expect, options) = match is_plain && generator.one_in(16) {
        true => (super::refused::plant(&mut generator), Options::default()),
        false => extras::choose(&mut generator, &scope, &entry, &targets),
    };
    let mut options = options;
    let expect = match (expect, targets.iter().any(|target| target.beside_by_bounds)) {
        (refused @ Expect::Refused(_), _) | (refused, false) => refused,
        // the bounds may be told in other words than the address; one reason to be refused is enough
        (_, true) => {
            options.targets.clear();
            Expect::Either(Code::ReadsOthersOutput)
        }
    };
    // what runs for every pixel shares nothing
    let is_shared = |target: &&Target| {
        target.accumulates
            && options.mode != Mode::Graded
            && options.policy(&target.name) != Policy::Full
    };
    let warnings = match targets.iter().any(|target| is_shared(&target)) {
        true => vec![Code::SharedState],
        false => Vec::new(),
    };
    if closes {
        generator.close();
    }
    generator.close();
    extras::other_entries(&mut generator);

    let mut text = head;
    for global in &generator.globals {
        text.push_str(global);
        text.push('\n');
    }
    for function in &generator.functions {
        text.push('\n');
        text.push_str(function);
    }
    text.push('\n');
    text.push_str(&generator.lines.join("\n"));
    text.push('\n');
    let mut shapes = generator.shapes;
    shapes.push(match generator.geometry.guard {
        Guard::None => "no guard",
        Guard::OffByOne => "guard off by one",
        Guard::Right => "right guard",
        Guard::Border => "border guard",
    });
    shapes.extend(entry.shapes);
    if uses_half {
        shapes.push("f16");
    }
    Shader {
        text,
        expect,
        options,
        size,
        shapes,
        warnings,
    }
}
