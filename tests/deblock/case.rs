//! Scenes to deblock: in memory, by chance, in every format and size.

use fastrand::Rng;
use vrcs::{
    Rate,
    deblock::{Depth, Options, Packing, Picture, cpu::Scene},
    sri::Sri,
};
use wgpu::TextureFormat;

/// A scene that owns its parts.
#[derive(Clone)]
pub struct Case {
    pub extent: [u32; 2],
    pub colors: Vec<[f32; 4]>,
    pub rates: Sri,
    pub order: u32,
    pub depth: Option<(Depth, Vec<f32>)>,
    pub surfaces: Option<Vec<u32>>,
    /// Whether it is counted what is filtered: one pixel after the other then.
    pub is_counted: bool,
    /// Whether coverage is declared.
    pub has_coverage: bool,
}

impl Case {
    /// Colors that the picture's function gives at full rate.
    pub fn new(extent: [u32; 2], rates: Sri, color: impl Fn(u32, u32) -> [f32; 4]) -> Case {
        let colors = (0..extent[0] * extent[1])
            .map(|i| color(i % extent[0], i / extent[0]))
            .collect();
        Case {
            extent,
            colors,
            rates,
            order: 0,
            depth: None,
            surfaces: None,
            is_counted: true,
            has_coverage: true,
        }
    }

    pub fn scene(&self) -> Scene<'_> {
        Scene {
            extent: self.extent,
            colors: &self.colors,
            rates: &self.rates,
            order: self.order,
            depth: self
                .depth
                .as_ref()
                .map(|(depth, values)| (*depth, &values[..])),
            surfaces: self.surfaces.as_deref(),
        }
    }

    /// The picture that copies make of it: each pixel gets what its group's primary has, where no coverage splits a block.
    pub fn copied(mut self) -> Case {
        let [width, height] = self.extent;
        let full = self.colors.clone();
        for y in 0..height {
            for x in 0..width {
                let [px, py] = primary(&self, x, y);
                self.colors[(y * width + x) as usize] = full[(py * width + px) as usize];
            }
        }
        self
    }

    pub fn options(&self, picture: Picture) -> Options {
        Options {
            depth: self.depth.as_ref().map(|(depth, _)| *depth),
            surfaces: self.surfaces.is_some(),
            coverage: self.has_coverage,
            counters: self.is_counted,
            ..Options::new(picture)
        }
    }

    /// Rounds the colors to a packing, as the GPU will load them.
    pub fn rounded(mut self, packing: Packing) -> Case {
        for color in &mut self.colors {
            *color = packing.unpack(&packing.pack(*color)).unwrap();
        }
        self
    }
}

/// The primary of a pixel, told from the slides: the first of its group, or in odd frames the last; half rates flip a
/// checkerboard. What lies outside the picture is no primary.
pub fn primary(case: &Case, x: u32, y: u32) -> [u32; 2] {
    let rate = case.rates.rate(x / 2, y / 2, Rate::R4X4);
    let (w, h) = (rate.width(), rate.height());
    let (left, top) = (x / w * w, y / h * h);
    let odd = case.order != 0 && (case.order - 1) % 2 == 1;
    let turn = |at: u32| match case.order {
        0 => 0,
        _ => (at + u32::from(odd)) % 2,
    };
    let (px, py) = match rate {
        Rate::R2X1 => (left + turn(y), y),
        Rate::R1X2 => (x, top + turn(x)),
        _ if odd => (left + w - 1, top + h - 1),
        _ => (left, top),
    };
    [px.min(case.extent[0] - 1), py.min(case.extent[1] - 1)]
}

pub fn packing_of(picture: Picture) -> Packing {
    match picture {
        Picture::Texture(TextureFormat::Rgba8Unorm) => Packing::Rgba8Unorm,
        Picture::Texture(TextureFormat::Rgba16Float) => Packing::Rgba16Float,
        Picture::Texture(TextureFormat::Rgba32Float) => Packing::Rgba32Float,
        Picture::Texture(_) => Packing::Rg11b10Ufloat,
        Picture::R32Uint(packing) | Picture::Buffer(packing) => packing,
    }
}

pub const FORMATS: [Picture; 8] = [
    Picture::Texture(TextureFormat::Rgba8Unorm),
    Picture::Texture(TextureFormat::Rgba16Float),
    Picture::Texture(TextureFormat::Rgba32Float),
    Picture::R32Uint(Packing::Rgba8Unorm),
    Picture::R32Uint(Packing::Rg11b10Ufloat),
    Picture::Buffer(Packing::Rgba16Float),
    Picture::Buffer(Packing::Rgba32Float),
    Picture::Buffer(Packing::Rgba8Unorm),
];

pub const COARSE: [Rate; 6] = [
    Rate::R1X2,
    Rate::R2X1,
    Rate::R2X2,
    Rate::R2X4,
    Rate::R4X2,
    Rate::R4X4,
];

pub const SIZES: [[u32; 2]; 9] = [
    [1, 1],
    [2, 3],
    [5, 4],
    [16, 16],
    [33, 31],
    [7, 64],
    [3, 1080],
    [1025, 2],
    [40, 23],
];

pub fn random_rates(extent: [u32; 2], rng: &mut Rng) -> Sri {
    // blocks of 4×4 pixels mostly agree, so that rates 4 wide hold somewhere; some bytes are no code, some blocks are split
    let mut blocks = std::collections::HashMap::new();
    Sri::from_fn(extent[0], extent[1], |x, y| {
        let code = Rate::ALL[rng.usize(0..7)].code();
        let split = if rng.u32(0..4) == 0 { 0x80 } else { 0 };
        let block = *blocks.entry((x / 2, y / 2)).or_insert(code | split);
        match rng.u32(0..8) {
            0 => code,
            1 => rng.u8(..),
            _ => block,
        }
    })
}

pub fn random_color(rng: &mut Rng) -> [f32; 4] {
    [rng.f32(), rng.f32() * rng.f32(), rng.f32() * 0.01, 1.0]
}
