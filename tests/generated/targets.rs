//! What a shader stores to, and where: storage textures of every dimension and many formats, and buffers in every order.

use super::{
    grammar::Generator,
    values::{Scope, Ty},
};

/// A resource that is stored to.
#[derive(Clone, Debug)]
pub struct Target {
    pub name: String,
    place: Place,
    /// The address, made of `pixel` and `layer`, and of `block_x` and `block_y` where there is a block.
    pub address: String,
    /// The type of the address.
    pub address_type: &'static str,
    /// Lines that come before the address, in which `AT` stands for a new name.
    pub preparation: Vec<String>,
    /// Texels of the block that an invocation writes.
    pub block: Option<[u32; 2]>,
    /// Whether the address names a variable of the entry point.
    pub has_local: bool,
    /// Whether the target is read at the place that is then written.
    pub accumulates: bool,
    /// Another place of it that is read besides: where nobody stores, or the invocation's own.
    pub beside: Option<String>,
    /// Whether it takes bounds of the shader's own to see that nobody else stores there.
    pub beside_by_bounds: bool,
    /// Whether the address surely moves with the pixel one-to-one, so that conditions on the ids are allowed.
    pub one_to_one: bool,
}

#[derive(Clone, Debug)]
enum Place {
    /// A texture of floats, of unsigned or of signed integers; arrayed or not.
    Texture { of: &'static str, arrayed: bool },
    /// An element of a buffer: what comes after its name, what comes after the index, and what is stored.
    Buffer {
        array: &'static str,
        part: &'static str,
        stored: Stored,
    },
}

/// What is stored in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stored {
    Of(Ty),
    Two,
    Three,
    /// `f16`, one or four.
    Half,
    HalfFour,
}

const FORMATS: [(&str, &str); 16] = [
    ("rgba8unorm", "f32"),
    ("rgba8snorm", "f32"),
    ("rgba16float", "f32"),
    ("rgba32float", "f32"),
    ("rg32float", "f32"),
    ("r32float", "f32"),
    ("rgba8uint", "u32"),
    ("rgba16uint", "u32"),
    ("rgba32uint", "u32"),
    ("rg32uint", "u32"),
    ("r32uint", "u32"),
    ("rgba8sint", "i32"),
    ("rgba16sint", "i32"),
    ("rgba32sint", "i32"),
    ("rg32sint", "i32"),
    ("r32sint", "i32"),
];

/// WebGPU's default limit on storage textures.
const MOST_TEXTURES: u32 = 4;

impl Target {
    /// Declares a target. `textures` counts those that there are.
    pub fn choose(g: &mut Generator, textures: &mut u32, uses_half: bool) -> Target {
        if uses_half && g.one_in(2) {
            return Target::buffer(g, true);
        }
        if *textures < MOST_TEXTURES && g.below(5) < 3 {
            *textures += 1;
            return Target::texture(g);
        }
        Target::buffer(g, false)
    }

    fn texture(g: &mut Generator) -> Target {
        let accumulates = g.one_in(6);
        let (format, of) = match accumulates {
            true => g.pick(&[("r32float", "f32"), ("r32uint", "u32"), ("r32sint", "i32")]),
            false => g.pick(&FORMATS),
        };
        let access = if accumulates { "read_write" } else { "write" };
        let name = g.name("picture");
        let layered = g.geometry.layered;
        let (dimension, arrayed) = match layered {
            true if g.one_in(2) => ("3d", false),
            true => ("2d_array", true),
            false if g.one_in(24) => ("1d", false),
            false => ("2d", false),
        };
        g.resource(&format!(
            "var {name}: texture_storage_{dimension}<{format}, {access}>;"
        ));
        g.shape(match dimension {
            "3d" => "3-D texture",
            "2d_array" => "arrayed texture",
            "1d" => "1-D texture",
            _ => "2-D texture",
        });
        let mut target = Target {
            place: Place::Texture { of, arrayed },
            address: String::new(),
            address_type: "vec2<u32>",
            preparation: Vec::new(),
            block: None,
            has_local: false,
            accumulates,
            beside: None,
            beside_by_bounds: false,
            one_to_one: false,
            name,
        };
        match dimension {
            "1d" => target.linear_texture(),
            "2d" if accumulates && g.geometry.checkered => {
                // the cells beside it are of the other colour
                g.shape("the other colour's cells are read");
                target.address = "pixel".to_owned();
                target.one_to_one = true;
                target.beside_by_bounds = true;
                target.beside = Some(g.pick(&[
                    "pixel + vec2<u32>(1u, 0u)".to_owned(),
                    "vec2<u32>(pixel.x, pixel.y + 1u)".to_owned(),
                    "vec2<i32>(pixel) - vec2<i32>(0, 1)".to_owned(),
                ]));
            }
            _ => target.plane(g),
        }
        if dimension == "3d" {
            let scalar = &target.address_type[5..8];
            target.address = format!("vec3<{scalar}>({}, {scalar}(layer))", target.address);
            target.address_type = match scalar {
                "u32" => "vec3<u32>",
                _ => "vec3<i32>",
            };
        }
        if accumulates {
            g.shape("own pixel read");
        }
        target
    }

    fn linear_texture(&mut self) {
        self.address = "pixel.y * (frame.width + 32u) + pixel.x".to_owned();
        self.address_type = "u32";
        self.one_to_one = true;
    }

    /// An address in a plane.
    fn plane(&mut self, g: &mut Generator) {
        self.one_to_one = true;
        let (shape, address, signed): (_, String, _) = match g.below(16) {
            0 => ("signed address", "vec2<i32>(pixel)".into(), true),
            1 => (
                "address by components",
                "vec2<u32>(pixel.x, pixel.y)".into(),
                false,
            ),
            2 => (
                "offset address",
                "pixel + vec2<u32>(frame.offset, 1u)".into(),
                false,
            ),
            3 => (
                "flipped address",
                "vec2<i32>(i32(frame.width) - 1 - i32(pixel.x), i32(pixel.y))".into(),
                true,
            ),
            4 => (
                "rotated address",
                "vec2<i32>(frame.size) - 1 - vec2<i32>(pixel)".into(),
                true,
            ),
            5 => ("transposed address", "pixel.yx".into(), false),
            6 => {
                self.one_to_one = false;
                (
                    "address by select",
                    "select(vec2<i32>(pixel), vec2<i32>(i32(pixel.x), i32(frame.height) - 1 - i32(pixel.y)), frame.flip > 3u)".into(),
                    true,
                )
            }
            7 => {
                self.one_to_one = false;
                self.preparation = vec![
                    "var AT = vec2<i32>(pixel);".into(),
                    "if frame.flip > 3u {".into(),
                    "    AT.x = i32(frame.width) - 1 - AT.x;".into(),
                    "}".into(),
                ];
                ("address by a branch", "AT".into(), true)
            }
            8 => {
                self.one_to_one = false;
                (
                    "address through floats",
                    "vec2<u32>(vec2<f32>(pixel) + 0.5)".into(),
                    false,
                )
            }
            9 => {
                self.one_to_one = false;
                ("address by xor", "pixel ^ vec2<u32>(1u, 2u)".into(), false)
            }
            10 if !self.accumulates => {
                let block = [g.below(3) + 1, g.below(2) + 1];
                self.block = Some(block);
                (
                    "block of texels",
                    format!(
                        "pixel * vec2<u32>({}u, {}u) + vec2<u32>(block_x, block_y)",
                        block[0], block[1]
                    ),
                    false,
                )
            }
            11 => {
                let name = g.name("moved");
                g.function(
                    &format!("fn {name}(at: vec2<u32>) -> vec2<u32>"),
                    |g| match g.one_in(2) {
                        true => g.line("return at + vec2<u32>(2u, frame.offset);"),
                        false => g.line("return vec2<u32>(at.y, at.x + 1u);"),
                    },
                );
                self.one_to_one = false;
                ("address by a helper", format!("{name}(pixel)"), false)
            }
            _ => ("own address", "pixel".into(), false),
        };
        g.shape(shape);
        self.address = address;
        self.address_type = if signed { "vec2<i32>" } else { "vec2<u32>" };
    }

    fn buffer(g: &mut Generator, is_half: bool) -> Target {
        use Stored::{Half, HalfFour, Of, Three, Two};
        let name = g.name("values");
        let elements: [(&str, u32, &str, Stored); 8] = [
            ("f32", 4, "", Of(Ty::F)),
            ("u32", 4, "", Of(Ty::U)),
            ("i32", 4, "", Of(Ty::I)),
            ("vec2<f32>", 8, "", Two),
            ("vec4<f32>", 16, "", Of(Ty::V4)),
            ("vec4<f32>", 16, ".z", Of(Ty::F)),
            ("TEXEL", 32, ".color", Three),
            ("TEXEL", 32, ".weight", Of(Ty::F)),
        ];
        let (element, _, part, stored) = match (is_half, g.one_in(2)) {
            (true, true) => ("f16", 2, "", Half),
            (true, false) => ("vec4<f16>", 8, "", HalfFour),
            _ => g.pick(&elements),
        };
        let (element, part, stored) = match (element, g.below(4)) {
            ("TEXEL", 0) => (element, ".ids[2u]", Of(Ty::U)),
            ("TEXEL", 1) => (element, ".ids[frame.flip & 3u]", Of(Ty::U)),
            ("TEXEL", 2) => (element, ".color.y", Of(Ty::F)),
            _ => (element, part, stored),
        };
        let mut target = Target {
            place: Place::Buffer {
                array: "",
                part,
                stored,
            },
            address: String::new(),
            address_type: "u32",
            preparation: Vec::new(),
            block: None,
            has_local: false,
            accumulates: g.one_in(5),
            beside: None,
            beside_by_bounds: false,
            one_to_one: true,
            name,
        };
        if target.accumulates {
            g.shape("own element read");
        }
        if !part.is_empty() {
            g.shape("part of an element");
        }
        let (shape, index, mut count) = target.index(g);
        g.shape(shape);
        target.address = index;
        if g.geometry.layered {
            target.address = format!("layer * {count}u + {}", target.address);
            let beside = target.beside.take();
            target.beside = beside.map(|beside| format!("layer * {count}u + {beside}"));
            count *= g.geometry.layers();
        }
        target.declare(g, element, count);
        target
    }

    fn declare(&mut self, g: &mut Generator, element: &str, count: u32) {
        let [width, height] = g.geometry.size;
        let element = match element {
            "TEXEL" => {
                let name = g.name("Texel");
                g.globals.push(format!(
                    "struct {name} {{\n    color: vec3<f32>,\n    weight: f32,\n    ids: array<u32, 4>,\n}}"
                ));
                name
            }
            other => other.to_owned(),
        };
        let room = width * height * g.geometry.layers() * 4;
        let is_open = count <= room && !g.one_in(3);
        let array = match is_open {
            true => format!("array<{element}>"),
            false => format!("array<{element}, {count}>"),
        };
        g.shape(if is_open { "open array" } else { "sized array" });
        let is_wrapped = g.one_in(4);
        let ty = match is_wrapped {
            true => {
                let name = g.name("Picture");
                g.globals.push(format!(
                    "struct {name} {{\n    frames: vec4<u32>,\n    texels: {array},\n}}"
                ));
                g.shape("array in a struct");
                name
            }
            false => array,
        };
        if let Place::Buffer { array, .. } = &mut self.place {
            *array = if is_wrapped { ".texels" } else { "" };
        }
        let name = self.name.clone();
        g.resource(&format!("var<storage, read_write> {name}: {ty};"));
    }

    /// An index, and how many elements it needs.
    fn index(&mut self, g: &mut Generator) -> (&'static str, String, u32) {
        let geometry = g.geometry;
        let [width, height] = geometry.size;
        let confined = geometry.is_confined();
        let (stride, columns) = match confined {
            true => {
                let name = g.pick(&["frame.width", "frame.size.x", "textureDimensions(input).x"]);
                (name.to_owned(), width)
            }
            false => match g.one_in(2) {
                true => ("(frame.width + 32u)".to_owned(), width + 32),
                false => ("96u".to_owned(), 96),
            },
        };
        let rows = if confined { height } else { height + 17 };
        let linear = columns * rows;
        match g.below(11) {
            0 => {
                let k = g.below(3) + 2;
                let j = g.below(k);
                let of = |j: u32| format!("(pixel.y * {stride} + pixel.x) * {k}u + {j}u");
                if self.accumulates && g.one_in(2) {
                    g.shape("another element of its own is read");
                    self.beside = Some(of((j + 1) % k));
                }
                ("strided buffer", of(j), linear * k)
            }
            10 if confined && self.accumulates && !g.geometry.layered => {
                let planes = g.below(2) + 2;
                let [p, q] = [g.below(planes), g.below(planes)];
                let size = g.pick(&[
                    "frame.width * frame.height",
                    "(frame.size.x * frame.size.y)",
                ]);
                let of = |p: u32| format!("pixel.y * {stride} + pixel.x + {p}u * {size}");
                g.shape("another plane is read");
                self.beside = Some(of(q));
                self.beside_by_bounds = true;
                ("plane of a buffer", of(p), linear * planes)
            }
            1 => {
                self.one_to_one = false;
                let across = columns / 8 + 1;
                (
                    "tiled buffer",
                    format!(
                        "((pixel.y / 8u) * {across}u + pixel.x / 8u) * 64u + (pixel.y & 7u) * 8u + (pixel.x & 7u)"
                    ),
                    across * (rows / 8 + 1) * 64,
                )
            }
            2 => {
                self.one_to_one = false;
                if !g.functions.iter().any(|f| f.contains("fn morton")) {
                    g.function("fn morton(at: vec2<u32>) -> u32", |g| {
                        g.line("var code = 0u;");
                        g.open("for (var bit = 0u; bit < 6u; bit++)");
                        g.line("code |= ((at.x >> bit) & 1u) << (2u * bit);");
                        g.line("code |= ((at.y >> bit) & 1u) << (2u * bit + 1u);");
                        g.close();
                        g.line("return code;");
                    });
                }
                ("Morton order", "morton(pixel)".to_owned(), 4096)
            }
            3 => (
                "column by column",
                format!("pixel.x * {}u + pixel.y", rows),
                columns * rows,
            ),
            4 => (
                "index through signed integers",
                format!("u32(i32(pixel.y) * i32({stride}) + i32(pixel.x))"),
                linear,
            ),
            5 if confined => (
                "rows from below",
                format!("(frame.height - 1u - pixel.y) * {stride} + pixel.x"),
                linear,
            ),
            6 if !self.accumulates => {
                let block = [g.below(2) + 1, g.below(2) + 1];
                self.block = Some(block);
                let [w, h] = block;
                (
                    "block of elements",
                    format!(
                        "(pixel.y * {h}u + block_y) * ({stride} * {w}u) + pixel.x * {w}u + block_x"
                    ),
                    linear * w * h,
                )
            }
            7 => {
                self.one_to_one = false;
                let name = g.name("index_of");
                g.function(&format!("fn {name}(at: vec2<u32>) -> u32"), |g| {
                    g.line(format!("let row = at.y * {stride};"));
                    g.line("return row + at.x;");
                });
                ("index by a helper", format!("{name}(pixel)"), linear)
            }
            _ => (
                "linear buffer",
                format!("pixel.y * {stride} + pixel.x"),
                linear,
            ),
        }
    }

    /// The type of a stored value, for a helper's argument.
    pub fn value_type(&self) -> String {
        match &self.place {
            Place::Texture { of, .. } => format!("vec4<{of}>"),
            Place::Buffer { stored, .. } => match stored {
                Stored::Of(ty) => ty.name().to_owned(),
                Stored::Two => "vec2<f32>".to_owned(),
                Stored::Three => "vec3<f32>".to_owned(),
                Stored::Half => "f16".to_owned(),
                Stored::HalfFour => "vec4<f16>".to_owned(),
            },
        }
    }

    /// A value that can be stored.
    pub fn value(&self, scope: &Scope, depth: u32, g: &mut Generator) -> String {
        let several = |count: u32, of: &str, ty: Ty, g: &mut Generator| {
            let parts: Vec<String> = (0..count).map(|_| scope.value(ty, depth, g)).collect();
            format!("vec{count}<{of}>({})", parts.join(", "))
        };
        match &self.place {
            Place::Texture { of, .. } => match *of {
                "f32" => scope.value(Ty::V4, depth + 1, g),
                "u32" => several(4, "u32", Ty::U, g),
                _ => several(4, "i32", Ty::I, g),
            },
            Place::Buffer { stored, .. } => match stored {
                Stored::Of(ty) => scope.value(*ty, depth + 1, g),
                Stored::Two => several(2, "f32", Ty::F, g),
                Stored::Three => several(3, "f32", Ty::F, g),
                Stored::Half => format!("f16({})", scope.value(Ty::F, depth, g)),
                Stored::HalfFour => format!("vec4<f16>({})", scope.value(Ty::V4, depth, g)),
            },
        }
    }

    /// Writes the store of a value at an address.
    pub fn store(&self, address: &str, value: &str, g: &mut Generator) {
        let name = &self.name;
        match &self.place {
            Place::Texture { of, arrayed } => {
                let layer = if *arrayed { ", layer" } else { "" };
                let value = match (self.accumulates, &self.beside) {
                    (true, Some(beside)) => format!(
                        "textureLoad({name}, {address}) + textureLoad({name}, {beside}) * {value}"
                    ),
                    (true, None) => format!("textureLoad({name}, {address}{layer}) + {value}"),
                    (false, _) => value.to_owned(),
                };
                debug_assert!(["f32", "u32", "i32"].contains(of));
                g.line(format!("textureStore({name}, {address}{layer}, {value});"));
            }
            Place::Buffer { array, part, .. } => {
                let mut place = format!("{name}{array}[{address}]{part}");
                if g.one_in(4) {
                    g.shape("store through a pointer");
                    let pointer = g.name("element");
                    g.line(format!("let {pointer} = &{name}{array}[{address}];"));
                    place = match part.is_empty() {
                        true => format!("*{pointer}"),
                        false => format!("(*{pointer}){part}"),
                    };
                }
                match (self.accumulates, g.one_in(2)) {
                    (true, _) if self.beside.is_some() => {
                        let beside = self.beside.as_deref().unwrap_or_default();
                        let beside = format!("{name}{array}[{beside}]{part}");
                        g.line(format!("{place} = {place} + {beside} * {value};"));
                    }
                    (true, true) => g.line(format!("{place} += {value};")),
                    (true, false) => g.line(format!("{place} = {place} * {value};")),
                    (false, _) => g.line(format!("{place} = {value};")),
                }
            }
        }
    }
}
