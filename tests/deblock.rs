//! The deblocker: where its taps lie, what it leaves alone, what it does not let through, and that it equals its twin.

mod common;

use std::{cell::RefCell, rc::Rc};

use fastrand::Rng;
use vrcs::{
    Rate, View,
    analyse::{fixed, params::linear_code},
    build::{BuildOptions, Header, user_words},
    check::{
        coordinates::SampleTextures,
        gpu::{Gpu, adapters},
    },
    coverage::{Coverage, Sky, cpu::Samples},
    deblock::{
        Counters, Deblocker, Depth, DepthKind, Inputs, Luma, Options, Packing, Picture,
        PictureInput, Transfer, Way, Weights,
        cpu::{self, Deblocked, Scene},
        luma_pitch,
    },
    sri::Sri,
};
use vrcs_passes::options::FullTiles;
use wgpu::TextureFormat;

/// A scene that owns its parts.
#[derive(Clone)]
struct Case {
    extent: [u32; 2],
    colors: Vec<[f32; 4]>,
    rates: Sri,
    order: u32,
    depth: Option<(Depth, Vec<f32>)>,
    surfaces: Option<Vec<u32>>,
}

impl Case {
    /// Colors that the picture's function gives at full rate.
    fn new(extent: [u32; 2], rates: Sri, color: impl Fn(u32, u32) -> [f32; 4]) -> Case {
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
        }
    }

    fn scene(&self) -> Scene<'_> {
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
    fn copied(mut self) -> Case {
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

    fn options(&self, picture: Picture) -> Options {
        Options {
            depth: self.depth.as_ref().map(|(depth, _)| *depth),
            surfaces: self.surfaces.is_some(),
            counters: true,
            ..Options::new(picture)
        }
    }

    /// Rounds the colors to a packing, as the GPU will load them.
    fn rounded(mut self, packing: Packing) -> Case {
        for color in &mut self.colors {
            *color = packing.unpack(&packing.pack(*color)).unwrap();
        }
        self
    }
}

/// The primary of a pixel, told from the slides: the first of its group, or in odd frames the last; half rates flip a
/// checkerboard. What lies outside the picture is no primary.
fn primary(case: &Case, x: u32, y: u32) -> [u32; 2] {
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

fn packing_of(picture: Picture) -> Packing {
    match picture {
        Picture::Texture(TextureFormat::Rgba8Unorm) => Packing::Rgba8Unorm,
        Picture::Texture(TextureFormat::Rgba16Float) => Packing::Rgba16Float,
        Picture::Texture(TextureFormat::Rgba32Float) => Packing::Rgba32Float,
        Picture::Texture(_) => Packing::Rg11b10Ufloat,
        Picture::R32Uint(packing) | Picture::Buffer(packing) => packing,
    }
}

/// What the GPU made of a case.
struct Got {
    colors: Vec<[f32; 4]>,
    /// The picture's words as they lie in memory.
    words: Vec<u32>,
    counters: Counters,
    luma: Vec<u8>,
}

struct Bench {
    gpu: Gpu,
    adapter: wgpu::Adapter,
    /// Pipelines that were made, by what for: making one takes longer than running it.
    made: RefCell<Vec<(Options, bool, Rc<Deblocker>)>>,
}

impl Bench {
    fn new() -> Bench {
        let gpu = common::gpu();
        let adapter = adapters()
            .into_iter()
            .find(|adapter| adapter.get_info().name == gpu.info.name)
            .expect("the adapter of the device");
        Bench {
            gpu,
            adapter,
            made: RefCell::default(),
        }
    }

    fn texture(
        &self,
        format: TextureFormat,
        [width, height]: [u32; 2],
        texel: u32,
        bytes: &[u8],
    ) -> wgpu::Texture {
        let storage = match format {
            TextureFormat::R32Float | TextureFormat::R8Uint => wgpu::TextureUsages::empty(),
            _ => wgpu::TextureUsages::STORAGE_BINDING,
        };
        let size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        };
        let texture = self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("test"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: storage
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_DST
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        self.gpu.queue.write_texture(
            texture.as_image_copy(),
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * texel),
                rows_per_image: None,
            },
            size,
        );
        texture
    }

    fn deblocker(
        &self,
        case: &Case,
        picture: Picture,
        luma: Option<Luma>,
        with_adapter: bool,
    ) -> Rc<Deblocker> {
        let options = Options {
            luma,
            ..case.options(picture)
        };
        let mut made = self.made.borrow_mut();
        let known = made
            .iter()
            .find(|(known, adapter, _)| *known == options && *adapter == with_adapter);
        if let Some((_, _, deblocker)) = known {
            return deblocker.clone();
        }
        let deblocker = Deblocker::new(
            &self.gpu.device,
            with_adapter.then_some(&self.adapter),
            options,
        );
        let deblocker = Rc::new(deblocker.unwrap_or_else(|error| panic!("{error}")));
        made.push((options, with_adapter, deblocker.clone()));
        deblocker
    }

    fn run(&self, case: &Case, picture: Picture) -> Got {
        self.run_with(&self.deblocker(case, picture, None, true), case)
    }

    fn run_with(&self, deblocker: &Deblocker, case: &Case) -> Got {
        let picture = deblocker.options().picture;
        let packing = packing_of(picture);
        let [width, height] = case.extent;
        // a picture is larger than the extent: what lies beyond is poison, and has to survive
        let room = [width + 3, height + 2];
        let poison = packing.pack([0.125, 0.25, 0.5, 1.0]);
        let mut words = Vec::new();
        for y in 0..room[1] {
            for x in 0..room[0] {
                words.extend(match x < width && y < height {
                    true => packing.pack(case.colors[(y * width + x) as usize]),
                    false => poison.clone(),
                });
            }
        }
        let bytes: &[u8] = bytemuck::cast_slice(&words);
        let texel = packing.words() * 4;
        let rates = self
            .gpu
            .buffer("rates", case.rates.bytes(), wgpu::BufferUsages::STORAGE);
        let pitch = luma_pitch(width);
        let luma = self.gpu.buffer(
            "luma",
            &vec![0xa5; (pitch * height) as usize],
            wgpu::BufferUsages::STORAGE,
        );
        let view =
            |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let depth = case.depth.as_ref().map(|(_, values)| {
            view(&self.texture(
                TextureFormat::R32Float,
                case.extent,
                4,
                bytemuck::cast_slice(values),
            ))
        });
        let surfaces = case.surfaces.as_ref().map(|values| {
            let bytes: Vec<u8> = values.iter().map(|&v| v as u8).collect();
            view(&self.texture(TextureFormat::R8Uint, case.extent, 1, &bytes))
        });
        let format = match picture {
            Picture::Texture(format) => Some(format),
            Picture::R32Uint(_) => Some(TextureFormat::R32Uint),
            Picture::Buffer(_) => None,
        };
        let texture = format.map(|format| self.texture(format, room, texel, bytes));
        let texture_view = texture.as_ref().map(view);
        let buffer = self
            .gpu
            .buffer("picture", bytes, wgpu::BufferUsages::STORAGE);
        let inputs = Inputs {
            picture: match &texture_view {
                Some(view) => PictureInput::Texture(view),
                None => PictureInput::Buffer(&buffer, room[0]),
            },
            rates: &rates,
            depth: depth.as_ref(),
            surfaces: surfaces.as_ref(),
            luma: deblocker.options().luma.is_some().then_some(&luma),
        };
        let mut bound = deblocker
            .bind(&self.gpu.device, &inputs)
            .unwrap_or_else(|e| panic!("{e}"));
        deblocker
            .set_frame(&self.gpu.queue, &mut bound, case.extent, case.order)
            .unwrap_or_else(|e| panic!("{e}"));
        let mut encoder = self.gpu.encoder();
        deblocker.record(&mut encoder, &bound);
        let row = (room[0] * texel).next_multiple_of(256);
        let read = self.gpu.buffer(
            "read",
            &vec![0; (row * room[1]) as usize],
            wgpu::BufferUsages::empty(),
        );
        if let Some(texture) = &texture {
            encoder.copy_texture_to_buffer(
                texture.as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: &read,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(row),
                        rows_per_image: None,
                    },
                },
                texture.size(),
            );
        }
        let result = texture.as_ref().map_or(&buffer, |_| &read);
        let counted = bound.counters().expect("counters");
        let got = self
            .gpu
            .submit_and_read(encoder, &[result, counted, &luma])
            .unwrap_or_else(|error| panic!("{error}"));
        let all: Vec<u32> = bytemuck::pod_collect_to_vec(&got[0]);
        let stride = match texture {
            Some(_) => row / 4,
            None => room[0] * packing.words(),
        };
        let mut words = Vec::new();
        for y in 0..room[1] {
            for x in 0..room[0] {
                let at = (y * stride + x * packing.words()) as usize;
                let pixel = &all[at..at + packing.words() as usize];
                match x < width && y < height {
                    true => words.extend_from_slice(pixel),
                    false => assert_eq!(pixel, poison, "wrote beyond the extent at {x},{y}"),
                }
            }
        }
        Got {
            colors: words
                .chunks_exact(packing.words() as usize)
                .map(|pixel| packing.unpack(pixel).unwrap())
                .collect(),
            words,
            counters: bytemuck::pod_read_unaligned(&got[1]),
            luma: (0..height as usize)
                .flat_map(|y| got[2][y * pitch as usize..][..width as usize].to_vec())
                .collect(),
        }
    }
}

/// The largest distance that rounding to a packing makes, of a value.
fn rounding(packing: Packing, value: f64, channel: usize) -> f64 {
    let relative =
        |bits: i32, smallest: i32| (value.abs() * 2f64.powi(-bits)).max(2f64.powi(smallest));
    // a little over half a step, for f32 arithmetic; a driver may cut off rather than round to small floats (Vulkan, "Floating-Point
    // Format Conversions"): a whole step
    let f32_step = value.abs() * 2f64.powi(-21);
    f32_step
        + match packing {
            Packing::Rgba8Unorm => 0.502 / 255.0,
            Packing::Rgba16Float => relative(10, -24),
            Packing::Rg11b10Ufloat if channel == 2 => relative(5, -19),
            Packing::Rg11b10Ufloat => relative(6, -20),
            Packing::Rgba32Float => 0.0,
        }
}

/// Expects that the GPU made what the twin makes, within what rounding explains.
fn assert_twins(got: &Got, wanted: &Deblocked, packing: Packing, what: &str) {
    assert_eq!(got.counters, wanted.counters, "{what}");
    for (index, (got, wanted)) in got.colors.iter().zip(&wanted.colors).enumerate() {
        for channel in 0..3 {
            let (g, w) = (f64::from(got[channel]), wanted[channel]);
            let is_near = (g - w).abs() <= rounding(packing, w, channel);
            assert!(
                is_near || (g.is_nan() && w.is_nan()) || g == w,
                "{what}: pixel {index}: {got:?} for {wanted:?}"
            );
        }
    }
}

const FORMATS: [Picture; 8] = [
    Picture::Texture(TextureFormat::Rgba8Unorm),
    Picture::Texture(TextureFormat::Rgba16Float),
    Picture::Texture(TextureFormat::Rgba32Float),
    Picture::R32Uint(Packing::Rgba8Unorm),
    Picture::R32Uint(Packing::Rg11b10Ufloat),
    Picture::Buffer(Packing::Rgba16Float),
    Picture::Buffer(Packing::Rgba32Float),
    Picture::Buffer(Packing::Rgba8Unorm),
];

const COARSE: [Rate; 6] = [
    Rate::R1X2,
    Rate::R2X1,
    Rate::R2X2,
    Rate::R2X4,
    Rate::R4X2,
    Rate::R4X4,
];

const SIZES: [[u32; 2]; 9] = [
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

fn random_rates(extent: [u32; 2], rng: &mut Rng) -> Sri {
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

fn random_color(rng: &mut Rng) -> [f32; 4] {
    [rng.f32(), rng.f32() * rng.f32(), rng.f32() * 0.01, 1.0]
}

#[test]
fn a_full_rate_picture_keeps_its_bits() {
    let bench = Bench::new();
    let mut rng = Rng::with_seed(common::seed());
    for picture in FORMATS {
        let case = Case::new([33, 17], Sri::uniform(33, 17, Rate::R1X1), |_, _| [0.0; 4]);
        let mut case = case.rounded(packing_of(picture));
        case.colors.fill_with(|| random_color(&mut rng));
        case.colors[40] = [f32::NAN, f32::INFINITY, -0.0, 1.0];
        let got = bench.run(&case, picture);
        let wanted: Vec<u32> = case
            .colors
            .iter()
            .flat_map(|c| packing_of(picture).pack(*c))
            .collect();
        assert_eq!(got.words, wanted, "{picture:?}");
        assert_eq!(got.counters, Counters::default(), "nothing is coarse");
    }
}

#[test]
fn a_plain_picture_and_every_primary_keep_their_bits() {
    let bench = Bench::new();
    let seed = common::seed();
    for (index, picture) in FORMATS.into_iter().enumerate() {
        let packing = packing_of(picture);
        let mut rng = Rng::with_seed(seed + index as u64);
        let rates = random_rates([40, 23], &mut rng);
        let plain = Case::new([40, 23], rates, |_, _| [0.3, 0.7, 0.11, 0.5]).rounded(packing);
        let words = packing.pack(plain.colors[0]);
        let got = bench.run(&plain, picture);
        assert!(
            got.words
                .chunks_exact(words.len())
                .all(|pixel| pixel == words)
        );

        let rate = COARSE[index % COARSE.len()];
        for order in 0..=4 {
            let mut case = Case::new([40, 23], Sri::uniform(40, 23, rate), |_, _| [0.0; 4]);
            case.colors.fill_with(|| random_color(&mut rng));
            case.order = order;
            let case = case.copied().rounded(packing);
            let got = bench.run(&case, picture);
            let mut moved = 0;
            for (i, (got, was)) in got.colors.iter().zip(&case.colors).enumerate() {
                let (x, y) = (i as u32 % 40, i as u32 / 40);
                if primary(&case, x, y) == [x, y] {
                    assert_eq!(got, was, "the primary {x},{y} at {rate}, order {order}");
                }
                moved += u32::from(got != was);
            }
            assert!(moved > 100, "the filter did nothing at {rate}");
        }
    }
}

/// The root of the mean square distance from a ramp, over the pixels that have samples on both sides.
fn ramp_error(
    case: &Case,
    colors: impl Iterator<Item = f64>,
    value: impl Fn(u32, u32) -> f64,
) -> f64 {
    let [width, height] = case.extent;
    let mut sum = 0.0;
    let mut count = 0.0;
    for (i, color) in colors.enumerate() {
        let (x, y) = (i as u32 % width, i as u32 / width);
        if (4..width - 4).contains(&x) && (4..height - 4).contains(&y) {
            sum += (color - value(x, y)).powi(2);
            count += 1.0;
        }
    }
    f64::sqrt(sum / count)
}

/// The number: how much nearer to a linear ramp the filter comes than the copies. Where all groups are of one size it is
/// exact but for f32; where rates are mixed, neighbours' samples lie in other rows and columns, and the factor is what is left.
#[test]
fn a_ramp_comes_back() {
    let bench = Bench::new();
    let seed = common::seed();
    let extent = [64, 48];
    let picture = Picture::Buffer(Packing::Rgba32Float);
    for (dx, dy) in [(1.0, 0.0), (0.0, 1.0), (0.75, -0.5)] {
        let value = move |x: u32, y: u32| 40.0 + dx * f64::from(x) + dy * f64::from(y);
        let color = move |x, y| [value(x, y) as f32, 1.0, 0.0, 1.0];
        for rate in COARSE {
            for order in 0..=4 {
                let mut case = Case::new(extent, Sri::uniform(64, 48, rate), color);
                case.order = order;
                let case = case.copied();
                let before = ramp_error(&case, case.colors.iter().map(|c| f64::from(c[0])), value);
                let got = bench.run(&case, picture);
                let after = ramp_error(&case, got.colors.iter().map(|c| f64::from(c[0])), value);
                // a half rate does not touch a ramp along its fine axis
                let is_blocked = before > 0.0;
                assert_eq!(
                    is_blocked,
                    dx != 0.0 && rate.width() > 1 || dy != 0.0 && rate.height() > 1
                );
                assert!(
                    after * 1e5 <= before,
                    "{rate}, order {order}, slope {dx},{dy}: {before} became {after}"
                );
            }
        }
        let mut rng = Rng::with_seed(seed);
        let mixed = Sri::from_fn(64, 48, |_, _| Rate::ALL[rng.usize(0..4)].code());
        let blocks: Vec<Rate> = (0..16 * 12).map(|_| Rate::ALL[rng.usize(0..7)]).collect();
        let coarse = Sri::from_fn(64, 48, |x, y| blocks[(y / 2 * 16 + x / 2) as usize].code());
        for (name, rates, factor) in [("up to 2x2", mixed, 4.0), ("up to 4x4", coarse, 3.0)] {
            for order in 0..=4 {
                let mut case = Case::new(extent, rates.clone(), color);
                case.order = order;
                let case = case.copied();
                let before = ramp_error(&case, case.colors.iter().map(|c| f64::from(c[0])), value);
                let got = bench.run(&case, picture);
                let after = ramp_error(&case, got.colors.iter().map(|c| f64::from(c[0])), value);
                println!(
                    "mixed {name}, order {order}, slope {dx},{dy}: {:.2}",
                    before / after
                );
                assert!(
                    after * factor <= before,
                    "{name}, order {order}: {before} became {after}"
                );
            }
        }
    }
}

#[test]
fn the_slides_averages_are_what_comes_out() {
    // 2x1: the mean of two across; 1x2: of two down; 2x2: of the four around a corner
    let bench = Bench::new();
    let picture = Picture::Buffer(Packing::Rgba32Float);
    let of = |rate| {
        let case = Case::new([4, 4], Sri::uniform(4, 4, rate), |x, y| {
            [(x + 10 * y) as f32, 0.0, 0.0, 1.0]
        });
        let case = case.copied();
        bench
            .run(&case, picture)
            .colors
            .iter()
            .map(|c| c[0])
            .collect::<Vec<_>>()
    };
    assert_eq!(of(Rate::R2X1)[..4], [0.0, 1.0, 2.0, 2.0]);
    let down = of(Rate::R1X2);
    assert_eq!(
        [down[0], down[4], down[8], down[12]],
        [0.0, 10.0, 20.0, 20.0]
    );
    let both = of(Rate::R2X2);
    assert_eq!(both[..2], [0.0, 1.0]);
    assert_eq!(both[4..6], [10.0, (0.0 + 2.0 + 20.0 + 22.0) / 4.0]);
}

#[test]
fn the_gpu_makes_what_its_twin_makes() {
    let bench = Bench::new();
    let seed = common::seed();
    let (mut tried, mut doubtful) = (0, 0);
    // every format with a third of the sizes, every size with a third of the formats; VRCS_ALL tries all
    let all = std::env::var_os("VRCS_ALL").is_some();
    for (f, picture) in FORMATS.into_iter().enumerate() {
        let packing = packing_of(picture);
        for (s, extent) in SIZES.into_iter().enumerate() {
            if !all && (f + s / 3) % 3 != s % 3 {
                continue;
            }
            tried += 1;
            let mut rng = Rng::with_seed(seed + (f * 100 + s) as u64);
            let rates = random_rates(extent, &mut rng);
            let mut case = Case::new(extent, rates, |_, _| [0.0; 4]);
            case.order = rng.u32(0..5);
            // few different colors, so that split blocks have equal pixels; not copied, the law is about any picture
            let colors: Vec<_> = (0..4).map(|_| random_color(&mut rng)).collect();
            case.colors.fill_with(|| colors[rng.usize(0..4)]);
            let pixels = case.colors.len();
            if s % 2 == 0 {
                case.surfaces = Some((0..pixels).map(|_| u32::from(rng.u32(0..9) == 0)).collect());
            }
            if s % 3 != 0 {
                let kind = [
                    DepthKind::Reversed,
                    DepthKind::Linear,
                    DepthKind::Standard {
                        near: 0.5,
                        far: 100.0,
                    },
                    DepthKind::ReversedFinite {
                        near: 0.5,
                        far: 100.0,
                    },
                ][rng.usize(0..4)];
                // two planes with jumps between them
                let values = (0..pixels)
                    .map(|i| {
                        let (x, y) = (i as u32 % extent[0], i as u32 / extent[0]);
                        let is_far = rng.u32(0..6) == 0;
                        let inverse =
                            0.2 + 0.0002 * f64::from(x % 256) + 0.0001 * f64::from(y % 256);
                        let z = 1.0 / (inverse * if is_far { 0.3 } else { 1.0 });
                        (match kind {
                            DepthKind::Linear => z,
                            DepthKind::Reversed => 0.5 / z,
                            DepthKind::Standard { near, far } => {
                                let (n, f) = (f64::from(near), f64::from(far));
                                f / (f - n) - f * n / (f - n) / z
                            }
                            DepthKind::ReversedFinite { near, far } => {
                                let (n, f) = (f64::from(near), f64::from(far));
                                f * n / (f - n) / z - n / (f - n)
                            }
                        }) as f32
                    })
                    .collect();
                case.depth = Some((Depth::new(kind), values));
            }
            let case = case.rounded(packing);
            let wanted = cpu::deblock(&case.scene());
            if wanted.margin < 1e-4 {
                // a comparison too near for f32 to tell
                doubtful += 1;
                continue;
            }
            let got = bench.run(&case, picture);
            assert_twins(
                &got,
                &wanted,
                packing,
                &format!("{picture:?} {extent:?} order {}", case.order),
            );
        }
    }
    assert!(
        tried >= 24 && doubtful * 3 < tried,
        "{doubtful} of {tried} cases told nothing"
    );
}

#[test]
fn every_format_is_told_how_it_is_stored() {
    let bench = Bench::new();
    let case = Case::new([20, 12], Sri::uniform(20, 12, Rate::R2X2), |x, y| {
        [x as f32 / 20.0, y as f32 / 12.0, 0.5, 1.0]
    });
    for format in [
        TextureFormat::Rgba8Unorm,
        TextureFormat::Rgba16Float,
        TextureFormat::Rgba32Float,
    ] {
        // without the adapter only what WebGPU guarantees: through a scratch texture; the picture is the same, bit for bit
        let portable = bench.deblocker(&case, Picture::Texture(format), None, false);
        assert_eq!(portable.way(), Way::Scratch);
        let own = bench.deblocker(&case, Picture::Texture(format), None, true);
        println!("{format:?}: {}", own.way());
        assert_eq!(
            bench.run_with(&portable, &case).words,
            bench.run_with(&own, &case).words
        );
    }
    let r11 = Picture::Texture(TextureFormat::Rg11b10Ufloat);
    match Deblocker::new(&bench.gpu.device, Some(&bench.adapter), case.options(r11)) {
        Ok(deblocker) => {
            println!("rg11b10ufloat: {}", deblocker.way());
            let case = case.clone().copied().rounded(Packing::Rg11b10Ufloat);
            let wanted = cpu::deblock(&case.scene());
            assert_twins(
                &bench.run_with(&deblocker, &case),
                &wanted,
                Packing::Rg11b10Ufloat,
                "rg11b10ufloat",
            );
        }
        Err(error) => assert!(
            error.to_string().contains("not stored by this device"),
            "{error}"
        ),
    }
    let refused = Deblocker::new(
        &bench.gpu.device,
        None,
        case.options(Picture::Texture(TextureFormat::R8Unorm)),
    );
    assert!(
        refused
            .unwrap_err()
            .to_string()
            .contains("R8Unorm is not supported")
    );
    let refused = Deblocker::new(
        &bench.gpu.device,
        None,
        case.options(Picture::R32Uint(Packing::Rgba16Float)),
    );
    assert!(refused.unwrap_err().to_string().contains("one word"));
}

/// E30. The slides' filter, in place, races. This one's samples are never written.
#[test]
fn fifty_runs_are_one_run() {
    let bench = Bench::new();
    let mut rng = Rng::with_seed(common::seed());
    let extent = [257, 131];
    let mut case = Case::new(extent, random_rates(extent, &mut rng), |_, _| [0.0; 4]);
    case.colors.fill_with(|| random_color(&mut rng));
    case.surfaces = Some((0..extent[0] * extent[1]).map(|i| i / 50 % 2).collect());
    for picture in [
        Picture::Texture(TextureFormat::Rgba8Unorm),
        Picture::Buffer(Packing::Rgba16Float),
    ] {
        let luma = Luma::linear(0);
        let deblocker = bench.deblocker(&case, picture, Some(luma), true);
        let first = bench.run_with(&deblocker, &case);
        for run in 1..50 {
            let got = bench.run_with(&deblocker, &case);
            assert_eq!(got.words, first.words, "run {run}");
            assert_eq!(
                (got.counters, &got.luma),
                (first.counters, &first.luma),
                "run {run}"
            );
        }
    }
}

/// E31. Half the picture is a wall at 1e4; the other half, right behind its silhouette, is dark.
fn silhouette(rate: Rate, order: u32, edge: u32) -> (Case, impl Fn(u32) -> bool) {
    let is_bright = move |x: u32| x < edge;
    let rates = Sri::from_fn(32, 16, |x, _| {
        // coverage splits the blocks that the edge crosses
        let block = rate.width().max(2);
        let left = x * 2 / block * block;
        let is_split = (left..left + block).any(|x| is_bright(x) != is_bright(left));
        rate.code() | if is_split { 0x80 } else { 0 }
    });
    let color = move |x: u32, _| match is_bright(x) {
        true => [1e4, 1e4, 1e4, 1.0],
        false => [0.01, 0.02, 0.03, 1.0],
    };
    let mut case = Case::new([32, 16], rates, color);
    case.order = order;
    (case, is_bright)
}

#[test]
fn a_bright_silhouette_does_not_leak() {
    let bench = Bench::new();
    let picture = Picture::Buffer(Packing::Rgba32Float);
    for rate in COARSE {
        for order in [0, 1, 2] {
            for edge in 13..=18 {
                let (case, is_bright) = silhouette(rate, order, edge);
                let mut by_surface = case.clone();
                by_surface.surfaces =
                    Some((0..512).map(|i| u32::from(is_bright(i % 32))).collect());
                let mut by_depth = case.clone();
                let distance = |i: u32| match is_bright(i % 32) {
                    true => 2.0 + 0.02 * (i % 32) as f32,
                    false => 60.0,
                };
                by_depth.depth = Some((
                    Depth::new(DepthKind::Linear),
                    (0..512).map(distance).collect(),
                ));
                for guarded in [by_surface, by_depth] {
                    let got = bench.run(&guarded, picture);
                    assert_eq!(
                        got.colors, guarded.colors,
                        "{rate}, order {order}, edge {edge}"
                    );
                }
                // the test can fail: with nothing declared the slides' filter spills where it blends across
                if rate.width() > 1 && edge == 16 {
                    assert_ne!(
                        bench.run(&case, picture).colors,
                        case.colors,
                        "{rate}, order {order}"
                    );
                }
            }
        }
    }
}

/// A highlight runs over an edge between two triangles of one surface. Coverage by triangles has split the blocks at the edge.
#[test]
fn an_edge_inside_a_surface_does_blend() {
    let bench = Bench::new();
    let picture = Picture::Buffer(Packing::Rgba32Float);
    // the edge lies at x = 7, inside quads: pixel 6 is its own group, pixel 7 too
    let rates = Sri::from_fn(16, 8, |x, _| {
        Rate::R2X2.code() | if x == 3 { 0x80 } else { 0 }
    });
    let mut case = Case::new([16, 8], rates, |x, y| {
        let first = match x {
            7 => 7,
            _ => x & !1,
        };
        [(first * first) as f32, (y & !1) as f32, 0.0, 1.0]
    });
    case.surfaces = Some(vec![5; 128]);
    case.depth = Some((Depth::new(DepthKind::Linear), vec![4.0; 128]));
    let got = bench.run(&case, picture);
    let at = |x: usize, y: usize| got.colors[y * 16 + x];
    assert_eq!(
        at(5, 2)[0],
        (16.0 + 36.0) / 2.0,
        "over the edge of the triangle"
    );
    assert_eq!(
        (at(6, 2)[0], at(7, 2)[0]),
        (36.0, 49.0),
        "each its own group across"
    );
    assert_eq!((at(6, 3)[1], at(7, 3)[1]), (3.0, 3.0), "and pairs down");
    assert_eq!(at(9, 2)[0], (64.0 + 100.0) / 2.0);
}

#[test]
fn a_floor_that_recedes_steeply_is_one_surface() {
    // linear depth doubles within a few rows of the horizon; inverse depth is a plane
    let bench = Bench::new();
    let picture = Picture::Buffer(Packing::Rgba32Float);
    for kind in [DepthKind::Linear, DepthKind::Reversed] {
        for scale in [0.01, 1.0, 100.0] {
            let mut case = Case::new([16, 32], Sri::uniform(16, 32, Rate::R2X2), |_, y| {
                [y as f32, 0.0, 0.0, 1.0]
            })
            .copied();
            let depth = (0..512).map(|i| {
                let inverse = (i / 16 + 2) as f32 / 20.0 / scale;
                match kind {
                    DepthKind::Linear => 1.0 / inverse,
                    _ => inverse * 0.1 * scale,
                }
            });
            case.depth = Some((Depth::new(kind), depth.collect()));
            let got = bench.run(&case, picture);
            assert_eq!(got.counters.refused, 0, "{kind:?} {scale}");
            assert_eq!(got.colors[9 * 16 + 4][0], 9.0);
        }
    }
}

/// E31. Stronger than asked: what is not finite is not spread at all, and is reported.
#[test]
fn what_is_not_finite_does_not_spread_and_is_reported() {
    let bench = Bench::new();
    for picture in [
        Picture::Buffer(Packing::Rgba32Float),
        Picture::Texture(TextureFormat::Rgba16Float),
        Picture::R32Uint(Packing::Rg11b10Ufloat),
    ] {
        let packing = packing_of(picture);
        for rate in COARSE {
            for bad in [f32::NAN, f32::INFINITY] {
                let case = Case::new([24, 16], Sri::uniform(24, 16, rate), |x, y| {
                    match (
                        x / rate.width() * rate.width(),
                        y / rate.height() * rate.height(),
                    ) {
                        (8, 8) => [bad, 0.5, 0.5, 1.0],
                        (x, y) => [x as f32 * 0.25, y as f32 * 0.5, 0.25, 1.0],
                    }
                });
                let case = case.rounded(packing);
                let got = bench.run(&case, picture);
                let area = rate.width() * rate.height();
                assert_eq!(got.counters.not_finite, area, "{picture:?} {rate} {bad}");
                for (i, (got, was)) in got.colors.iter().zip(&case.colors).enumerate() {
                    let finite = |c: &[f32; 4]| c.iter().all(|v| v.is_finite());
                    assert_eq!(
                        finite(got),
                        finite(was),
                        "{picture:?} {rate} {bad}: pixel {i}"
                    );
                    assert_eq!(got[3], was[3], "alpha");
                }
                assert_twins(&got, &cpu::deblock(&case.scene()), packing, "not finite");
            }
        }
    }
}

#[test]
fn every_result_lies_between_the_values_around_it() {
    let bench = Bench::new();
    let mut rng = Rng::with_seed(common::seed());
    let extent = [48, 40];
    let mut case = Case::new(extent, random_rates(extent, &mut rng), |_, _| [0.0; 4]);
    case.order = rng.u32(0..5);
    case.colors
        .fill_with(|| [rng.f32() * 65504.0, -rng.f32(), rng.f32(), rng.f32()]);
    let got = bench.run(&case, Picture::Buffer(Packing::Rgba32Float));
    for (i, color) in got.colors.iter().enumerate() {
        let (x, y) = (i as u32 % 48, i as u32 / 48);
        for (channel, &value) in color.iter().enumerate().take(3) {
            // no tap is farther than the next group's farthest sample
            let around = (y.saturating_sub(7)..(y + 8).min(40))
                .flat_map(|y| {
                    (x.saturating_sub(7)..(x + 8).min(48)).map(move |x| (y * 48 + x) as usize)
                })
                .map(|i| case.colors[i][channel]);
            let (low, high) = around.fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(v), h.max(v)));
            let slack = (high - low) * 1e-6;
            assert!((low - slack..=high + slack).contains(&value), "pixel {i}");
        }
        assert_eq!(color[3], case.colors[i][3], "alpha is not filtered");
    }
}

/// The coarse quads of every class of tiles are filtered: of mixed tiles, of tiles of one rate, of sky; and of any of them whether
/// or not the user marked it, as DOOM does tiles in fog, where it shipped without.
#[test]
fn every_class_of_tiles_is_deblocked_in_fog_too() {
    let bench = Bench::new();
    let mut rng = Rng::with_seed(common::seed());
    // four columns of tiles: full rate, one rate, mixed, sky; the second row of them lies in fog
    let extent = [64, 32];
    let sri = Sri::from_fn(extent[0], extent[1], |x, _| match x / 8 {
        0 => Rate::R1X1.code(),
        2 => [Rate::R1X1, Rate::R2X2, Rate::R2X1, Rate::R1X2][rng.usize(0..4)].code(),
        _ => Rate::R2X2.code(),
    });
    let samples = Samples {
        size: extent,
        surfaces: (0..64 * 32).map(|i| u32::from(i % 64 < 48)).collect(),
        ..Samples::default()
    };
    let coverage = Coverage {
        surfaces: true,
        sky: Some(Sky::Surface(0)),
        ..Coverage::default()
    };
    let options = BuildOptions {
        coverage,
        effective: true,
        full_tiles: FullTiles::Keep,
        user: true,
        ..BuildOptions::default()
    };
    let gpu = &bench.gpu;
    let textures = SampleTextures::new(gpu, &coverage, &samples);
    let mut view = View::new(&gpu.device, &gpu.queue, [64, 32, 1], options).expect("a view");
    view.cover(&gpu.queue, &textures.get())
        .expect("its textures");
    view.write_sri(&gpu.queue, &sri).expect("its rates");
    let mut effective = Vec::new();
    for fog in [0, 1] {
        let marks = user_words((0..8).map(|tile| if tile >= 4 { fog } else { 0 }));
        let user = view.user().expect("asked for");
        gpu.queue
            .write_buffer(user, 0, bytemuck::cast_slice(&marks));
        let mut encoder = gpu.encoder();
        view.build(&mut encoder).expect("covered");
        let built = [view.coords(), view.effective()].map(|b| b.expect("asked for"));
        let read = gpu
            .submit_and_read(encoder, &built)
            .expect("what was built");
        let headers: Vec<Header> = bytemuck::pod_collect_to_vec::<u8, u32>(&read[0])[..8]
            .iter()
            .map(|&word| Header(word))
            .collect();
        for (tile, header) in headers.iter().enumerate() {
            let class = (header.is_identity(), header.is_uniform(), header.is_sky());
            let wanted = [
                (true, false, false),
                (false, true, false),
                (false, false, false),
                (false, true, true),
            ][tile % 4];
            assert_eq!(class, wanted, "tile {tile}");
            assert_eq!(
                header.user(),
                if tile >= 4 { fog } else { 0 },
                "tile {tile}"
            );
        }
        effective.push(read[1].clone());
    }
    assert_eq!(effective[0], effective[1], "a mark is no rate");
    let pitch = sri.layout().pitch;
    let rates = Sri::from_fn(64, 32, |x, y| effective[1][(y * pitch + x) as usize]);
    let case = Case::new(extent, rates, |x, y| {
        let value = 0.01 * x as f32 + 0.007 * y as f32;
        [value, 0.5 * value, 1.0 - value, 1.0]
    })
    .copied();
    let picture = Picture::Buffer(Packing::Rgba32Float);
    let got = bench.run(&case, picture);
    assert_twins(
        &got,
        &cpu::deblock(&case.scene()),
        packing_of(picture),
        "fog",
    );
    for tile in 0..8usize {
        let changed = (0..256)
            .filter(|i| {
                let at = (tile / 4 * 16 + i / 16) * 64 + tile % 4 * 16 + i % 16;
                got.colors[at] != case.colors[at]
            })
            .count();
        match tile % 4 {
            0 => assert_eq!(changed, 0, "full rate"),
            _ => assert!(changed > 64, "tile {tile}: {changed} pixels filtered"),
        }
    }
}

#[test]
fn the_luma_of_the_next_frame_comes_with_it() {
    let bench = Bench::new();
    let seed = common::seed();
    for (s, extent) in SIZES.into_iter().enumerate() {
        for luma in [Luma::linear(2), Luma::SRGB] {
            let mut rng = Rng::with_seed(seed + s as u64);
            let picture = Picture::Buffer(Packing::Rgba32Float);
            let mut case = Case::new(extent, random_rates(extent, &mut rng), |_, _| [0.0; 4]);
            case.colors.fill_with(|| random_color(&mut rng));
            if let Some(color) = case.colors.get_mut(11) {
                color[1] = f32::NAN;
            }
            let plain = bench.run(&case, picture);
            let deblocker = bench.deblocker(&case, picture, Some(luma), true);
            let got = bench.run_with(&deblocker, &case);
            assert_eq!(got.words, plain.words, "luma changes no pixel");
            let wanted = cpu::deblock(&case.scene());
            for (i, (&code, &color)) in got.luma.iter().zip(&wanted.colors).enumerate() {
                let at = [i as u32 % extent[0], i as u32 / extent[0]];
                let wanted = cpu::luma_code(&luma, color.map(|c| c as f32), at);
                // f32 against f64, of a channel that was filtered: near 0 a unit of it is worth a few codes
                let is_filtered = got.words[4 * i..4 * i + 3] != case_words(&case, i);
                let most = if is_filtered { 4 } else { 0 };
                assert!(
                    code.abs_diff(wanted) <= most,
                    "{extent:?} pixel {i}: {code} for {wanted}"
                );
            }
        }
    }
    let luma = Luma::linear(0);
    assert_eq!(cpu::luma_code(&luma, [1.0; 4], [0, 0]), 255);
    assert_eq!(
        cpu::luma_code(&luma, [0.2501; 4], [0, 0]),
        128,
        "the root of a quarter"
    );
    assert_eq!(cpu::luma_code(&luma, [f32::NAN; 4], [3, 4]), 255);
    assert_eq!(cpu::luma_code(&luma, [f32::NAN; 4], [4, 4]), 0);
}

/// The bits of a pixel's color.
fn case_words(case: &Case, pixel: usize) -> [u32; 3] {
    std::array::from_fn(|channel| case.colors[pixel][channel].to_bits())
}

/// The deblocker and the analysis write the same √luma for the same color, whatever it is but for what is not finite: of all bytes,
/// of linear values up to white and beyond, of negative ones.
#[test]
fn the_luma_is_that_of_the_analysis() {
    let bench = Bench::new();
    let mut rng = Rng::with_seed(common::seed());
    let extent = [64, 64];
    let full = || Sri::uniform(extent[0], extent[1], Rate::R1X1);
    let bytes = Case::new(extent, full(), |x, y| {
        let byte = |v: u32| (v % 256) as f32 / 255.0;
        [
            byte(x + y * 64),
            byte(x * 5 + y * 3),
            byte(x * 11 + y * 17),
            1.0,
        ]
    });
    let mut linear = Case::new(extent, full(), |_, _| [0.0; 4]);
    linear.colors.fill_with(|| {
        std::array::from_fn(|_| match rng.u32(0..12) {
            0 => 4.0,
            1 => 4.0001,
            2 => -0.01,
            3 => -1e-7,
            _ => rng.f32() * 4.0,
        })
    });
    let analysis = |luma: &Luma, color: [f32; 4]| {
        let units = [color[0], color[1], color[2]].map(|channel| match luma.transfer {
            Some(transfer) => Some(linear_code((channel * 255.0).round() as u8, transfer)),
            None => fixed::quantise(channel, luma.white_log2),
        });
        match units {
            [Some(r), Some(g), Some(b)] => {
                fixed::sqrt_code(fixed::luma([r, g, b], luma.weights.fixed())) as u8
            }
            // integer::analyse: doubt is white
            _ => 255,
        }
    };
    let rec709 = |luma: Luma| Luma {
        weights: Weights::Rec709,
        ..luma
    };
    let squared = Luma {
        transfer: Some(Transfer::Square),
        ..Luma::SRGB
    };
    let mut seen = std::collections::BTreeSet::new();
    for (case, luma, picture) in [
        (
            &bytes,
            Luma::SRGB,
            Picture::Texture(TextureFormat::Rgba8Unorm),
        ),
        (
            &bytes,
            rec709(squared),
            Picture::R32Uint(Packing::Rgba8Unorm),
        ),
        (
            &linear,
            Luma::linear(2),
            Picture::Buffer(Packing::Rgba32Float),
        ),
        (
            &linear,
            rec709(Luma::linear(2)),
            Picture::Texture(TextureFormat::Rgba32Float),
        ),
    ] {
        let deblocker = bench.deblocker(case, picture, Some(luma), true);
        let got = bench.run_with(&deblocker, case);
        for (i, (&code, &color)) in got.luma.iter().zip(&case.colors).enumerate() {
            assert_eq!(
                code,
                analysis(&luma, color),
                "{luma:?} pixel {i}: {color:?}"
            );
            seen.insert(code);
        }
    }
    assert!(seen.len() > 200, "{} codes", seen.len());
}

#[test]
fn inputs_that_are_missing_or_small_are_refused() {
    let bench = Bench::new();
    let case = Case::new([20, 12], Sri::uniform(20, 12, Rate::R2X2), |_, _| [0.0; 4]);
    let picture = Picture::Buffer(Packing::Rgba8Unorm);
    let options = Options {
        surfaces: true,
        ..Options::new(picture)
    };
    let deblocker = Deblocker::new(&bench.gpu.device, None, options).unwrap();
    let buffer = bench
        .gpu
        .buffer("picture", &[0; 20 * 12 * 4], wgpu::BufferUsages::STORAGE);
    let rates = bench
        .gpu
        .buffer("rates", case.rates.bytes(), wgpu::BufferUsages::STORAGE);
    let inputs = Inputs {
        picture: PictureInput::Buffer(&buffer, 20),
        rates: &rates,
        depth: None,
        surfaces: None,
        luma: None,
    };
    let refused = deblocker.bind(&bench.gpu.device, &inputs).unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("surfaces was declared and is missing"),
        "{refused}"
    );
    let deblocker = Deblocker::new(&bench.gpu.device, None, Options::new(picture)).unwrap();
    let mut bound = deblocker.bind(&bench.gpu.device, &inputs).unwrap();
    for extent in [[21, 12], [20, 13]] {
        let refused = deblocker
            .set_frame(&bench.gpu.queue, &mut bound, extent, 0)
            .unwrap_err();
        assert!(refused.to_string().contains("20x12 given"), "{refused}");
    }
    assert!(
        deblocker
            .set_frame(&bench.gpu.queue, &mut bound, [20, 12], 0)
            .is_ok()
    );
    for depth in [
        Depth {
            kind: DepthKind::Linear,
            tolerance: 0,
        },
        Depth::new(DepthKind::Standard {
            near: 2.0,
            far: 1.0,
        }),
    ] {
        let options = Options {
            depth: Some(depth),
            ..Options::new(picture)
        };
        assert!(Deblocker::new(&bench.gpu.device, None, options).is_err());
    }
}
