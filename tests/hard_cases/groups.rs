//! Groups, lists and rays: numbers at the edge of what a field holds, rotation, and shares of a ray.

use proptest::prelude::*;
use vrcs::{
    Rate,
    build::{
        BuildOptions,
        cpu::{self, Frame},
        primary::Order,
    },
    coverage::{Coverage, Sky, cpu::Samples},
    sri::Sri,
};
use vrcs_passes::{Source, graded, input, options::FullTiles};

use crate::{
    case::{Case, Family},
    property,
};

pub const FAMILY: Family = Family {
    name: "groups",
    about: "Coordinate buffers at the edge of what their fields hold, primaries that rotate, and rays that are shared.",
    cases: &[
        Case {
            id: "E27",
            name: "tiles with 0, 1, 31, 32, 33, 223, 224, 225, 255 and 256 primaries",
            hazard: "a count of 8 bits wraps 256 to 0, which means sky; 224 and 225 fall on different sides of the rule",
            bound: "the header counts each; only a tile that is full is an identity, and only one without cover is sky",
            guard: "the sky flag of TileBuild::finish is told by a count of 9 bits; with `covered & 0xff == 0` the tile of 256 is sky (tried)",
            run: counts,
        },
        Case {
            id: "E42",
            name: "all 16 covers of a quad, at every rate, in every phase",
            hazard: "the primary of a rotation is a pixel that nothing covers",
            bound: "each pixel's primary is covered as it is, is its own primary, and lies in its block; each pixel of a pair and of three is primary in some frame",
            guard: "Order::first takes the first of what is left; with `flip` alone as the place pixel 15 has pixel 0 for its primary (tried)",
            run: rotation,
        },
        Case {
            id: "partition",
            name: "random rates and surfaces at random sizes",
            hazard: "a pixel has two primaries, or none",
            bound: "the map is idempotent, stays in a block, joins only pixels of one surface, and has as many primaries as entries",
            guard: "TileBuild::block: members leave what is left, and lie in the extent; without the extent's width they lie outside (tried)",
            run: partitions,
        },
        Case {
            id: "E41",
            name: "1 to 16 rays among 1 to 16 pixels: 20,000 frames each of stochastic rounding",
            hazard: "n / (1 + copies) is 0 for few rays; truncation loses rays, and rounding up makes light",
            bound: "never 0; the mean of rays times weight lies within 5 standard errors, computed from the coin's own variance, of n",
            guard: "graded::share tosses a coin for the remainder; without `more` 3 rays among 2 pixels are 2 on average, 200 standard errors off (tried)",
            run: rays,
        },
        Case {
            id: "E43",
            name: "implicit derivatives and levels of detail in compute shaders",
            hazard: "after remapping a neighbour is another pixel: a derivative across invocations is of the wrong pixels",
            bound: "refused with a reason before anything is rewritten; explicit levels and gradients are taken as they are, unless detail is asked to follow the rate",
            guard: "input::wgsl validates for a compute stage; where what is invalid is let through, textureSample is accepted (tried), and would read other invocations' coordinates",
            run: derivatives,
        },
    ],
};

/// One tile of which the first `count` pixels, in an order that is no row's, are covered.
fn tile(count: u32) -> cpu::Coordinates {
    let samples = Samples {
        size: [16, 16],
        surfaces: (0..256u32)
            .map(|at| u32::from(at * 37 % 256 < count))
            .collect(),
        ..Samples::default()
    };
    let options = BuildOptions {
        full_tiles: FullTiles::Keep,
        coverage: Coverage {
            surfaces: true,
            sky: Some(Sky::Surface(0)),
            ..Coverage::default()
        },
        ..BuildOptions::default()
    };
    let frame = Frame {
        samples: Some(&samples),
        ..Frame::default()
    };
    let full = Sri::uniform(16, 16, Rate::R1X1);
    cpu::build_frame(&full, [16, 16], &options, &frame)
}

fn counts() -> Result<String, String> {
    let all = [0, 1, 31, 32, 33, 223, 224, 225, 255, 256];
    for count in all {
        let header = tile(count).header(0);
        let holds = match count {
            0 => header.is_sky() && header.is_identity(),
            256 => header.is_identity() && !header.is_sky(),
            _ => {
                header.count() == count
                    && header.sky_count() == 256 - count
                    && !header.is_sky()
                    && !header.is_identity()
            }
        };
        if !holds {
            return Err(format!("{count}: {header:?}"));
        }
    }
    // without sky: the slides' rule at its edge
    let options = BuildOptions::default();
    let mut seen = Vec::new();
    for coarse in 8..=12u32 {
        // each 2x2 saves three
        let sri = Sri::from_fn(16, 16, |x, y| match y * 8 + x < coarse {
            true => Rate::R2X2.code(),
            false => Rate::R1X1.code(),
        });
        let header = cpu::build(&sri, [16, 16], &options).header(0);
        let primaries = 256 - 3 * coarse;
        if header.is_identity() != (primaries > 224) {
            return Err(format!("{primaries} primaries: {header:?}"));
        }
        seen.push(primaries);
    }
    Ok(format!(
        "{} counts; promoted above 224 of {seen:?}",
        all.len()
    ))
}

fn rotation() -> Result<String, String> {
    let mut times = 0;
    for rate in Rate::ALL {
        for mask in 0..16u32 {
            let samples = Samples {
                size: [4, 4],
                surfaces: (0..16u32)
                    .map(|at| mask >> (at / 4 % 2 * 2 + at % 2) & 1)
                    .collect(),
                ..Samples::default()
            };
            let options = BuildOptions {
                largest: Rate::R4X4,
                coverage: Coverage {
                    surfaces: true,
                    sky: Some(Sky::Surface(0)),
                    ..Coverage::default()
                },
                ..BuildOptions::default()
            };
            let mut turns = std::collections::HashSet::new();
            for phase in 0..4 {
                let frame = Frame {
                    order: Order::Rotating(phase),
                    samples: Some(&samples),
                    ..Frame::default()
                };
                let sri = Sri::uniform(4, 4, rate);
                let map = cpu::build_frame(&sri, [4, 4], &options, &frame).map();
                for (at, &primary) in (0..).zip(&map) {
                    let block = |at: u32| [at % 4 / rate.width(), at / 4 / rate.height()];
                    let is_covered = |at: u32| samples.surfaces[at as usize];
                    if is_covered(at) != is_covered(primary)
                        || map[primary as usize] != primary
                        || block(at) != block(primary)
                    {
                        return Err(format!("{rate}, cover {mask:04b}, phase {phase}: {map:?}"));
                    }
                    if is_covered(at) == 1 && block(at) == [0, 0] {
                        turns.insert(primary);
                    }
                }
                times += 1;
            }
            let covered = mask.count_ones() as usize;
            let turned = match (rate, covered) {
                (Rate::R2X2, 3) => 3,
                (Rate::R2X2, 4) => 2,
                _ => continue,
            };
            if turns.len() != turned {
                return Err(format!(
                    "{rate}, cover {mask:04b}: {} primaries",
                    turns.len()
                ));
            }
        }
    }
    Ok(format!("{times} maps"))
}

fn partitions() -> Result<String, String> {
    let side = || prop_oneof![1u32..20, 1u32..70, Just(256u32)];
    let sizes = (
        side(),
        1u32..40,
        1u32..5,
        any::<u64>(),
        0u32..4,
        any::<bool>(),
    );
    property::hold(160, &sizes, |(width, height, kinds, seed, phase, keeps)| {
        let extent = [width, height];
        let mut rng = fastrand::Rng::with_seed(seed);
        let surfaces: Vec<u32> = (0..width * height)
            .map(|at| (at % width / 3 + at / width / 5) % kinds)
            .collect();
        let samples = Samples {
            size: extent,
            surfaces: surfaces.clone(),
            ..Samples::default()
        };
        let options = BuildOptions {
            largest: Rate::R4X4,
            full_tiles: if keeps {
                FullTiles::Keep
            } else {
                FullTiles::Promote
            },
            coverage: Coverage {
                surfaces: true,
                ..Coverage::default()
            },
            ..BuildOptions::default()
        };
        let sri = Sri::from_fn(width, height, |_, _| match rng.bool() {
            true => Rate::R4X4.code(),
            false => rng.u8(..),
        });
        let frame = Frame {
            order: Order::Rotating(phase),
            samples: Some(&samples),
            ..Frame::default()
        };
        let built = cpu::build_frame(&sri, extent, &options, &frame);
        let map = built.map();
        for (at, &primary) in map.iter().enumerate() {
            prop_assert_eq!(map[primary as usize], primary);
            prop_assert_eq!(surfaces[at], surfaces[primary as usize]);
            let block = |at: u32| [at % width / 4, at / width / 4];
            prop_assert_eq!(block(at as u32), block(primary));
        }
        let own = (0..)
            .zip(&map)
            .filter(|(at, primary)| at == *primary)
            .count();
        prop_assert_eq!(built.list().iter().map(Vec::len).sum::<usize>(), own);
        Ok(())
    })
}

fn rays() -> Result<String, String> {
    const FRAMES: u32 = 20_000;
    let mut rng = fastrand::Rng::with_seed(41);
    let mut worst = 0.0f64;
    for pixels in [1u32, 2, 3, 4, 8, 16] {
        for rays in [1u32, 2, 3, 4, 5, 7, 16] {
            let mut sum = 0.0;
            for _ in 0..FRAMES {
                for _ in 0..pixels {
                    let (fired, weight) = graded::share(rays, pixels - 1, rng.f32());
                    if fired == 0 {
                        return Err(format!("{rays} rays among {pixels} pixels: none"));
                    }
                    sum += f64::from(fired) * f64::from(weight);
                }
            }
            let mean = sum / f64::from(FRAMES);
            // each pixel tosses a coin for the remainder; below one ray a pixel there is no coin
            let share = f64::from(rays) / f64::from(pixels);
            let part = if share < 1.0 { 0.0 } else { share.fract() };
            let variance = part * (1.0 - part) * f64::from(pixels);
            let error = (variance / f64::from(FRAMES)).sqrt();
            let off = (mean - f64::from(rays)).abs();
            if off > 5.0 * error + 1e-5 {
                return Err(format!(
                    "{rays} rays among {pixels} pixels: {mean}, {:.1} standard errors off",
                    off / error
                ));
            }
            worst = worst.max(if error > 0.0 { off / error } else { 0.0 });
        }
    }
    Ok(format!("at most {worst:.1} standard errors off"))
}

fn derivatives() -> Result<String, String> {
    let shader = |read: &str| {
        let text = format!(
            "@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var smooth_: sampler;
@group(0) @binding(2) var out: texture_storage_2d<rgba8unorm, write>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
    let at = vec2<f32>(id.xy) / 64.0;
    textureStore(out, id.xy, {read});
}}
"
        );
        input::wgsl(&Source::new("derivatives.wgsl", text))
            .map(|_| ())
            .map_err(|invalid| invalid.rendered)
    };
    for read in [
        "textureSample(image, smooth_, at)",
        "textureSampleBias(image, smooth_, at, 1.0)",
        "vec4(dpdx(at.x))",
        "vec4(fwidth(at.y))",
    ] {
        if shader(read).is_ok() {
            return Err(format!("{read} was accepted"));
        }
    }
    for read in [
        "textureSampleLevel(image, smooth_, at, 1.5)",
        "textureSampleGrad(image, smooth_, at, vec2(0.1, 0.0), vec2(0.0, 0.1))",
    ] {
        shader(read).map_err(|why| format!("{read}: {why}"))?;
    }
    Ok("4 refused, 2 taken".to_owned())
}
