//! Random values: floats, integers, vectors and conditions, from textures, buffers, uniforms and locals.
//!
//! No expression is constant, so that nothing is evaluated (and rejected) before the shader runs. NaNs and infinities come about
//! now and then.

use super::grammar::Generator;

/// The types of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ty {
    F,
    V4,
    U,
    I,
    B,
}

impl Ty {
    pub fn name(self) -> &'static str {
        match self {
            Ty::F => "f32",
            Ty::V4 => "vec4<f32>",
            Ty::U => "u32",
            Ty::I => "i32",
            Ty::B => "bool",
        }
    }
}

/// What can be named.
#[derive(Clone, Debug, Default)]
pub struct Scope {
    names: Vec<(String, Ty)>,
    /// Whether `texel`, `pixel` and the inputs can be named.
    pub has_texel: bool,
    has_numbers: bool,
    has_table: bool,
    has_sampler: bool,
    has_random: bool,
    /// What can be said anywhere in the module.
    pub anywhere: Vec<(&'static str, Ty)>,
}

impl Scope {
    /// Declares the inputs besides the uniforms and the first texture.
    pub fn inputs(generator: &mut Generator) -> Scope {
        let mut scope = Scope::default();
        if generator.one_in(4) {
            generator.resource("var<storage, read> numbers: array<vec4<f32>>;");
            generator.shape("read-only buffer");
            scope.has_numbers = true;
        }
        if generator.one_in(4) {
            generator.resource("var table: texture_2d<u32>;");
            generator.shape("integer texture");
            scope.has_table = true;
        }
        if generator.one_in(4) {
            generator.resource("var smooth_sampler: sampler;");
            generator.shape("sampled");
            scope.has_sampler = true;
        }
        if generator.one_in(5) {
            generator
                .globals
                .push("var<private> state: u32;".to_owned());
            generator.shape("private state");
            generator.function("fn random() -> f32", |g| {
                g.line("state = state * 747796405u + 2891336453u;");
                g.line("let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;");
                g.line("return f32((word >> 22u) ^ word) / 4294967295.0;");
            });
            scope.has_random = true;
        }
        scope
    }

    /// The scope of a helper function: its arguments, and the module's variables.
    pub fn of_function(&self, arguments: &[(String, Ty)]) -> Scope {
        Scope {
            names: arguments.to_vec(),
            has_texel: false,
            has_random: false,
            ..self.clone()
        }
    }

    pub fn add(&mut self, name: &str, ty: Ty) {
        self.names.push((name.to_owned(), ty));
    }

    /// What may be said in a block and not after it.
    pub fn inner(&self) -> Scope {
        self.clone()
    }

    fn local(&self, ty: Ty, generator: &mut Generator) -> Option<String> {
        let fitting: Vec<&String> = self
            .names
            .iter()
            .filter(|(_, of)| *of == ty)
            .map(|(name, _)| name)
            .collect();
        (!fitting.is_empty()).then(|| generator.pick(&fitting).clone())
    }

    /// An expression of a type, never a constant one.
    pub fn value(&self, ty: Ty, depth: u32, g: &mut Generator) -> String {
        if depth == 0 || g.one_in(5) {
            return self.leaf(ty, g);
        }
        let deeper = depth - 1;
        match ty {
            Ty::F => self.float(deeper, g),
            Ty::V4 => self.vector(deeper, g),
            Ty::U => self.unsigned(deeper, g),
            Ty::I => self.signed(deeper, g),
            Ty::B => self.condition(deeper, g),
        }
    }

    fn leaf(&self, ty: Ty, g: &mut Generator) -> String {
        if g.one_in(2)
            && let Some(local) = self.local(ty, g)
        {
            return local;
        }
        let anywhere = self.anywhere.iter().filter(|(_, of)| *of == ty);
        let anywhere: Vec<&str> = anywhere.map(|(text, _)| *text).collect();
        if !anywhere.is_empty() && g.one_in(3) {
            return g.pick(&anywhere).to_owned();
        }
        let component = g.pick(&["x", "y", "z", "w"]);
        match ty {
            Ty::F if self.has_texel => match g.below(6) {
                0 => "frame.gain".to_owned(),
                1 => format!("f32(pixel.{})", g.pick(&["x", "y"])),
                2 if self.has_random => "random()".to_owned(),
                3 if self.has_numbers => {
                    format!("numbers[pixel.{} & 15u].{component}", g.pick(&["x", "y"]))
                }
                _ => format!("texel.{component}"),
            },
            Ty::F => format!("frame.tint.{component}"),
            Ty::V4 if self.has_texel => match g.below(6) {
                0 => "frame.tint".to_owned(),
                1 => format!(
                    "textureLoad(input, vec2<i32>(pixel) + vec2<i32>({}, {}), 0)",
                    g.below(3) as i32 - 1,
                    g.below(3) as i32 - 1
                ),
                2 if self.has_sampler => format!(
                    "textureSampleLevel(input, smooth_sampler, (vec2<f32>(pixel) + 0.5) / vec2<f32>(frame.size), {}.0)",
                    g.below(3)
                ),
                _ => "texel".to_owned(),
            },
            Ty::V4 => "frame.tint".to_owned(),
            Ty::U if self.has_texel => match g.below(6) {
                0 => "frame.offset".to_owned(),
                1 if self.has_table => "textureLoad(table, pixel, 0).x".to_owned(),
                2 => "u32(texel.y * 7.0)".to_owned(),
                3 => "pack4x8unorm(texel)".to_owned(),
                _ => format!("pixel.{}", g.pick(&["x", "y"])),
            },
            Ty::U => "frame.middle".to_owned(),
            Ty::I if self.has_texel => format!("i32(pixel.{})", g.pick(&["x", "y"])),
            Ty::I => "i32(frame.offset)".to_owned(),
            Ty::B if self.has_texel => {
                format!("(texel.{component} > {})", g.pick(&["0.2", "0.5", "0.8"]))
            }
            Ty::B => "(frame.flip > 3u)".to_owned(),
        }
    }

    /// A right operand: a value, or a number.
    fn operand(&self, ty: Ty, depth: u32, g: &mut Generator) -> String {
        if !g.one_in(4) {
            return self.value(ty, depth, g);
        }
        match ty {
            Ty::F => g.pick(&["0.5", "2.0", "0.1", "3.0", "1.0"]).to_owned(),
            Ty::U => g.pick(&["1u", "2u", "3u", "7u", "5u"]).to_owned(),
            Ty::I => g.pick(&["1i", "2i", "3i", "7i"]).to_owned(),
            Ty::V4 | Ty::B => self.value(ty, depth, g),
        }
    }

    fn float(&self, d: u32, g: &mut Generator) -> String {
        match g.below(14) {
            0..=4 => {
                let op = g.pick(&["+", "-", "*", "*", "/"]);
                let (a, b) = (self.value(Ty::F, d, g), self.operand(Ty::F, d, g));
                format!("({a} {op} {b})")
            }
            5 => {
                let of = g.pick(&[
                    "sqrt", "sin", "abs", "fract", "floor", "exp2", "log2", "saturate",
                ]);
                if of == "sqrt" || of == "log2" {
                    g.shape("NaNs");
                    return format!("{of}({} - 0.4)", self.value(Ty::F, d, g));
                }
                format!("{of}({})", self.value(Ty::F, d, g))
            }
            6 => {
                let of = g.pick(&["min", "max", "step", "atan2"]);
                let (a, b) = (self.value(Ty::F, d, g), self.operand(Ty::F, d, g));
                format!("{of}({a}, {b})")
            }
            7 => format!("clamp({}, 0.0, 1.0)", self.value(Ty::F, d, g)),
            8 => {
                let (a, b) = (self.value(Ty::F, d, g), self.operand(Ty::F, d, g));
                format!("select({a}, {b}, {})", self.value(Ty::B, d, g))
            }
            9 => format!("length({})", self.value(Ty::V4, d, g)),
            10 => {
                let (a, b) = (self.value(Ty::V4, d, g), self.value(Ty::V4, d, g));
                format!("dot({a}, {b})")
            }
            11 => format!("f32({})", self.value(Ty::U, d, g)),
            12 => format!("f32({})", self.value(Ty::I, d, g)),
            _ => format!("-{}", self.value(Ty::F, d, g)).replace("--", "- -"),
        }
    }

    fn vector(&self, d: u32, g: &mut Generator) -> String {
        match g.below(9) {
            0 | 1 => {
                let op = g.pick(&["+", "-", "*"]);
                let (a, b) = (self.value(Ty::V4, d, g), self.value(Ty::V4, d, g));
                format!("({a} {op} {b})")
            }
            2 => {
                let (a, b) = (self.value(Ty::V4, d, g), self.operand(Ty::F, d, g));
                format!("({a} * {b})")
            }
            3 | 4 => {
                let parts: Vec<String> = (0..4).map(|_| self.operand(Ty::F, d, g)).collect();
                format!("vec4<f32>({})", parts.join(", "))
            }
            5 => format!(
                "{}.{}",
                self.value(Ty::V4, d, g),
                g.pick(&["wzyx", "yxwz", "xxyy", "zwzw"])
            ),
            6 => {
                let (a, b) = (self.value(Ty::V4, d, g), self.value(Ty::V4, d, g));
                format!("mix({a}, {b}, {})", self.operand(Ty::F, d, g))
            }
            7 => {
                let (a, b) = (self.value(Ty::V4, d, g), self.value(Ty::V4, d, g));
                format!("select({a}, {b}, {})", self.value(Ty::B, d, g))
            }
            _ => {
                let of = g.pick(&["normalize", "abs", "fract", "floor", "saturate"]);
                format!("{of}({})", self.value(Ty::V4, d, g))
            }
        }
    }

    fn unsigned(&self, d: u32, g: &mut Generator) -> String {
        match g.below(8) {
            0..=3 => {
                let op = g.pick(&["+", "-", "*", "^", "&", "|", "%", "/"]);
                let (a, b) = (self.value(Ty::U, d, g), self.operand(Ty::U, d, g));
                format!("({a} {op} {b})")
            }
            4 => {
                let op = g.pick(&["<<", ">>"]);
                format!(
                    "({} {op} ({} & 15u))",
                    self.value(Ty::U, d, g),
                    self.value(Ty::U, d, g)
                )
            }
            5 => format!("u32({})", self.value(Ty::I, d, g)),
            6 => format!("u32(saturate({}) * 9.0)", self.value(Ty::F, d, g)),
            _ => {
                let of = g.pick(&["countOneBits", "reverseBits", "firstTrailingBit"]);
                format!("{of}({})", self.value(Ty::U, d, g))
            }
        }
    }

    fn signed(&self, d: u32, g: &mut Generator) -> String {
        match g.below(5) {
            0..=2 => {
                let op = g.pick(&["+", "-", "*", "^", "/", "%"]);
                let (a, b) = (self.value(Ty::I, d, g), self.operand(Ty::I, d, g));
                format!("({a} {op} {b})")
            }
            3 => format!("i32({})", self.value(Ty::U, d, g)),
            _ => format!("i32(saturate({}) * 9.0)", self.value(Ty::F, d, g)),
        }
    }

    /// A condition on data. (What may depend on the ids alone is the [targets'](super::control) business.)
    fn condition(&self, d: u32, g: &mut Generator) -> String {
        if !self.has_texel {
            return self.leaf(Ty::B, g);
        }
        match g.below(6) {
            0..=2 => {
                let op = g.pick(&["<", ">", "<=", ">="]);
                let (a, b) = (self.value(Ty::F, d, g), self.operand(Ty::F, d, g));
                format!("({a} {op} {b} + texel.x)")
            }
            3 => {
                let op = g.pick(&["&&", "||", "!="]);
                let (a, b) = (self.value(Ty::B, d, g), self.value(Ty::B, d, g));
                format!("({a} {op} {b})")
            }
            4 => format!("!{}", self.value(Ty::B, d, g)),
            _ => {
                let mask = g.pick(&["1u", "2u", "3u"]);
                format!(
                    "((u32(texel.{} * 8.0) & {mask}) == 0u)",
                    g.pick(&["x", "y", "z"])
                )
            }
        }
    }
}
