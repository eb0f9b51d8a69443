//! Sizes that fit nothing: the laws, and the lists, at all of them.

use vrcs::{
    Pass, PassOptions, Rate, View,
    analyse::{Colour, Inputs, Settings},
    build::{
        BuildOptions, CoordLayout,
        cpu::{self, Coordinates},
    },
    check::{Job, Verdict, gpu::Gpu},
    plan::ColourForm,
    sri::Sri,
};
use vrcs_passes::{
    Options, Source,
    options::{MaxRate, Mode},
};

use crate::{
    case::{Case, Family},
    common, driver,
    stage::rates,
};

pub const FAMILY: Family = Family {
    name: "sizes",
    about: "From a single pixel to the largest pictures: odd, prime, thinner than a subgroup.",
    cases: &[
        Case {
            id: "E22",
            name: "the laws at sizes that no tile, quad or wave divides",
            hazard: "reads outside give false edges; the last column wraps into the next row; a partial tile is dropped",
            bound: "every law, bit for bit, at 20 sizes from 1×1 to 97×3",
            guard: "vrcs_members_in_extent in the prelude; where it returns the whole mask, the picture of 1×1 has another value in its one pixel (tried)",
            run: laws_at_odd_sizes,
        },
        Case {
            id: "E22-analysis",
            name: "the analysis on this driver, 1×1 to 16,384 in either direction, odd, prime, thinner than a subgroup",
            hazard: "what is outside is read as 0: false edges along the border; a last workgroup is left out",
            bound: "every byte as the integer twin; a plain picture is coarse up to its last quad; a picture and its border repeated agree",
            guard: "fill_square clamps to the picture. Without the clamp at the near side the rates of 1080×3 are not the twin's (tried); at the far side the driver's own bounds check does the same, and the rates stay (tried)",
            run: analysis_at_odd_sizes,
        },
        Case {
            id: "E23",
            name: "each pixel written exactly once, up to 16,384 wide or high",
            hazard: "a pixel written twice, or never, in the last odd column",
            bound: "once, at 12 sizes, all rates mixed",
            guard: "TileBuild::block cuts its mask to the extent; without that (1, 0) of a picture of one pixel is written (tried)",
            run: exactly_once,
        },
        Case {
            id: "E28",
            name: "coordinates past 4,096 and 16,384",
            hazard: "12- or 14-bit coordinates wrap",
            bound: "every primary's position is its own at 16,384×1 and 1×16,384",
            guard: "entries are relative to their tile, and a tile's first pixel is of 32 bits (Coordinates::origin); cut to 12 bits, 4,096 places come four times (tried)",
            run: far_coordinates,
        },
        Case {
            id: "E28-driver",
            name: "rewritten shaders drawn on this driver at 16,384×3 and 3×16,384, tiled and as a list, all rates mixed",
            hazard: "a rewritten shader or the builder's kernel cuts a coordinate: pixels far out are shaded for others",
            bound: "every pixel holds the place of its primary, by the builder's twin",
            guard: "vrcs_tile_prefix and the list's entries count tiles in 32 bits; with the tile's first pixel cut to 12 bits in the prelude pixel (4096, 0) is never written (tried)",
            run: drawn_far_out,
        },
    ],
};

fn analysis_at_odd_sizes() -> Result<String, String> {
    let gpu = common::gpu();
    let mut sizes = vec![[1080, 3], [3, 1080], [2159, 5], [5, 2159]];
    let sides = [1, 2, 3, 7, 8, 9, 15, 16, 17, 31, 33];
    sizes.extend(sides.iter().zip(sides.iter().rev()).map(|(&a, &b)| [a, b]));
    sizes.extend(sides.map(|side| [side, side]));
    // a prime below the limit, and the limit
    sizes.extend([[16_381, 3], [2, 16_381], [16_384, 1], [1, 16_384]]);
    let mut rng = fastrand::Rng::with_seed(22);
    let most = gpu.device.limits().max_texture_dimension_2d;
    let settings = Settings {
        largest: Rate::R4X4,
        ..Settings::default()
    };
    let kernel = driver::Kernel::new(&gpu, ColourForm::Codes, &settings)?;
    for &size in &sizes {
        if size[0].max(size[1]) > most {
            println!("skipped: {size:?}: this driver's pictures end at {most}");
            continue;
        }
        let count = (size[0] * size[1]) as usize;
        let noise: Vec<[u8; 4]> = (0..count)
            .map(|i| std::array::from_fn(|_| (i * 3 % 200) as u8 + rng.u8(..40)))
            .collect();
        for picture in [vec![[180; 4]; count], noise] {
            let found = kernel.of_codes(size, &picture)?;
            let inputs = Inputs::of_colour(size, Colour::Codes(&picture));
            if found != rates(&inputs, &settings) {
                return Err(format!("{size:?}: the driver's rates are not the twin's"));
            }
            if picture[0] == picture[count - 1] && picture.iter().all(|p| *p == picture[0]) {
                let edge = [size[0].div_ceil(2) - 1, size[1].div_ceil(2) - 1];
                let code = found.code(edge[0], edge[1]);
                if !Rate::R2X2.is_within(Rate::from_code_or_full(code)) {
                    return Err(format!("{size:?}: the last quad is {code}"));
                }
            }
        }
    }
    Ok(format!("equal at {} sizes", sizes.len()))
}

fn laws_at_odd_sizes() -> Result<String, String> {
    let source = Source::new(
        "sizes.wgsl",
        "@group(0) @binding(0) var<storage, read_write> out: array<vec2<u32>>;
@group(0) @binding(1) var<uniform> width: u32;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width || id.y >= arrayLength(&out) / width { return; }
    out[id.y * width + id.x] = vec2(id.x * 3u + 1u, id.y * 5u + id.x * 7919u);
}
",
    );
    let sizes = [
        [1, 1],
        [2, 1],
        [1, 2],
        [3, 2],
        [2, 3],
        [7, 1],
        [1, 7],
        [8, 8],
        [9, 9],
        [15, 17],
        [16, 16],
        [17, 17],
        [31, 2],
        [33, 5],
        [5, 33],
        [13, 47],
        [64, 3],
        [3, 64],
        [61, 67],
        [97, 3],
    ];
    let gpu = common::gpu();
    for (number, size) in sizes.into_iter().enumerate() {
        let mut job = Job::new("main");
        job.size = size;
        job.seed = number as u64;
        job.cases = 24;
        job.options.max_rate = MaxRate::R4x4;
        job.settings
            .set
            .insert("width".to_owned(), vec![f64::from(size[0])]);
        let report = common::run_on(&gpu, &source, &job);
        // a picture of one pixel or one group is the same everywhere, and cannot tell
        let is_told = report.verdict == Verdict::Passed
            || report.verdict == Verdict::Inconclusive
                && size[0] * size[1] <= 2
                && report.failure.is_none();
        if !is_told {
            return Err(format!(
                "{size:?}: {:?} {:?} {:?}",
                report.verdict, report.why, report.failure
            ));
        }
    }
    Ok(format!("all held at {} sizes", sizes.len()))
}

/// Mixed rates, the same on every run.
fn mixed(width: u32, height: u32) -> Sri {
    let mut rng = fastrand::Rng::with_seed(u64::from(width) << 32 | u64::from(height));
    Sri::from_fn(width, height, |x, y| match (x / 4 + y / 4) % 3 {
        0 => Rate::ALL[rng.usize(..7)].code(),
        1 => Rate::R4X4.code(),
        _ => rng.u8(..),
    })
}

fn options() -> BuildOptions {
    BuildOptions {
        largest: Rate::R4X4,
        ..BuildOptions::default()
    }
}

/// Each pixel that is written, with the pixel that is shaded for it; the pixels of an identity tile are their own.
fn members(built: &Coordinates) -> impl Iterator<Item = ([u32; 2], [u32; 2])> {
    let ([wide, high], extent) = (built.options.tile, built.extent);
    (0..built.layout.tile_count()).flat_map(move |tile| {
        let origin = built.origin(tile);
        let mut pairs = Vec::new();
        if built.header(tile).is_identity() {
            for y in origin[1]..(origin[1] + high).min(extent[1]) {
                pairs.extend(
                    (origin[0]..(origin[0] + wide).min(extent[0])).map(|x| ([x, y], [x, y])),
                );
            }
        }
        for entry in built.entries(tile) {
            let primary = [origin[0] + entry.x(), origin[1] + entry.y()];
            for bit in (0..16).filter(|bit| entry.mask() >> bit & 1 != 0) {
                pairs.push((
                    [
                        (primary[0] & !3) + (bit & 3),
                        (primary[1] & !3) + (bit >> 2),
                    ],
                    primary,
                ));
            }
        }
        pairs
    })
}

fn exactly_once() -> Result<String, String> {
    let sizes = [
        [1, 1],
        [1, 2],
        [5, 3],
        [17, 31],
        [257, 2],
        [1920, 1080],
        [1081, 2159],
        [16384, 1],
        [1, 16384],
        [16384, 3],
        [3, 16383],
        [8192, 16],
    ];
    for [width, height] in sizes {
        let built = cpu::build(&mixed(width, height), [width, height], &options());
        let mut written = vec![0u8; width as usize * height as usize];
        for ([x, y], _) in members(&built) {
            if x >= width || y >= height {
                return Err(format!("{width}x{height}: ({x}, {y}) lies outside"));
            }
            written[y as usize * width as usize + x as usize] += 1;
        }
        if let Some(at) = written.iter().position(|&times| times != 1) {
            let (x, y) = (at as u32 % width, at as u32 / width);
            return Err(format!(
                "{width}x{height}: ({x}, {y}) is written {} times",
                written[at]
            ));
        }
    }
    Ok(format!("once at {} sizes", sizes.len()))
}

fn far_coordinates() -> Result<String, String> {
    for extent in [[16_384, 1], [1, 16_384]] {
        let layout = CoordLayout::new(extent, &options());
        let built = cpu::build(
            &Sri::uniform(extent[0], extent[1], Rate::R1X1),
            extent,
            &options(),
        );
        let mut seen: Vec<u32> = members(&built).map(|(_, [x, y])| x.max(y)).collect();
        seen.sort_unstable();
        if seen != (0..16_384).collect::<Vec<u32>>() {
            return Err(format!(
                "{extent:?}: {} primaries, {} tiles",
                seen.len(),
                layout.tile_count()
            ));
        }
    }
    Ok("16,384 of 16,384".to_owned())
}

/// A shader that stores the place of the pixel that it shades.
const PLACES: &str = "@group(0) @binding(0) var<storage, read_write> places: array<vec2<u32>>;
@group(0) @binding(1) var<uniform> size: vec4<u32>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= size.xy) { return; }
    places[id.y * size.x + id.x] = id.xy;
}
";

fn drawn_far_out() -> Result<String, String> {
    let gpu = common::gpu();
    let source = Source::new("places.wgsl", PLACES);
    for mode in [Mode::Tiled, Mode::List] {
        let rewrite = Options {
            mode,
            max_rate: MaxRate::R4x4,
            ..Options::default()
        };
        let options = PassOptions {
            rewrite,
            ..PassOptions::default()
        };
        let pass = Pass::new(&gpu.device, &source, &options).map_err(|why| why.to_string())?;
        let built = pass.build_options(self::options());
        for size in [[16_384, 3], [3, 16_384]] {
            let rates = mixed(size[0], size[1]);
            let drawn = draw(&gpu, &pass, built, &rates, size)?;
            let map = cpu::build(&rates, size, &built).map();
            let place = |at: u32| [at % size[0], at / size[0]];
            for ((at, &primary), found) in (0..).zip(&map).zip(drawn) {
                if found != place(primary) {
                    return Err(format!(
                        "{mode:?}, {size:?}: pixel {:?} holds {found:?}, not {:?}",
                        place(at),
                        place(primary)
                    ));
                }
            }
        }
    }
    Ok("all pixels, 2 sizes, 2 modes".to_owned())
}

/// What [`PLACES`], rewritten, stores for each pixel.
fn draw(
    gpu: &Gpu,
    pass: &Pass,
    built: BuildOptions,
    rates: &Sri,
    [width, height]: [u32; 2],
) -> Result<Vec<[u32; 2]>, String> {
    let say = |why: &dyn std::fmt::Display| why.to_string();
    let view = View::new(&gpu.device, &gpu.queue, [width, height, 1], built);
    let view = view.map_err(|why| say(&why))?;
    view.write_sri(&gpu.queue, rates).map_err(|why| say(&why))?;
    let poison = vec![0xa5; (width * height * 8) as usize];
    let places = gpu.buffer("places", &poison, wgpu::BufferUsages::STORAGE);
    let size = bytemuck::cast::<[u32; 4], [u8; 16]>([width, height, 0, 0]);
    let size = gpu.buffer("size", &size, wgpu::BufferUsages::UNIFORM);
    let bound = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: pass.bind_group_layout(0).ok_or("no group 0")?,
        entries: &[(0, &places), (1, &size)].map(|at| wgpu::BindGroupEntry {
            binding: at.0,
            resource: at.1.as_entire_binding(),
        }),
    });
    let mut encoder = gpu.encoder();
    let mut compute = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    view.build_in(&mut compute).map_err(|why| say(&why))?;
    compute.set_bind_group(0, &bound, &[]);
    pass.dispatch(&mut compute, &view)
        .map_err(|why| say(&why))?;
    drop(compute);
    let read = gpu.submit_and_read(encoder, &[&places]);
    Ok(bytemuck::pod_collect_to_vec(
        &read.map_err(|why| say(&why))?[0],
    ))
}
