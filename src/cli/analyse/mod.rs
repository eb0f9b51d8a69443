//! `vrcs analyse`: how coarse a picture may be shaded.
//!
//! Does: runs the analysis of the library on a picture, or on the frame before it along its motion; prints the share of each
//! rate, writes the rates, the hardware-VRS image, the reasons and an overlay.
//! Needs: a picture in PNG, JPEG, EXR or Radiance HDR; a driver, or `--cpu`, which gives the same bytes.
//! Guarantees: all files are written, each whole, or none appears.
//! Refuses: what is no such picture, inputs of another size, an output that is an input, a tile without an attachment.

mod device;
mod layers;
mod options;
mod overlay;
mod picture;

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use serde_json::json;

use self::{
    device::Found,
    options::{LumaSource, Options},
    picture::{Picture, Pixels},
};
use super::{Failure, files, talk};
use crate::{
    Rate,
    analyse::{
        Colour, Inputs, Settings, integer,
        refit::refit_k,
        reproject,
        settings::{Motion, Reprojection},
    },
    atomic::Pending,
    attach::{
        AdditionalRates, AttachOptions, Encoding, Samples, Shading, Support, Tile, cpu::Attachment,
        cpu::attach,
    },
    check::gpu::Gpu,
    plan::{ColourForm, Plan, Scene},
    sri::Sri,
};

#[derive(Debug, clap::Args)]
#[command(after_help = "Files:
  SRI.png          one 8-bit grey pixel for each quad of 2x2 pixels: the code of its rate, (log2 W << 2) | log2 H
  the attachment   one 8-bit grey pixel for each tile: a code for d3d12 and khr, for nv an index into the palette whose
                   entries are the values of VkShadingRatePaletteEntryNV
  the reasons      one 8-bit grey pixel for each quad: 0 coarse, 1 content, 3 no number, 4 off screen, 5 disoccluded,
                   9 a finer neighbour, 10 too slow
  the motion       an EXR: X and Y, in pixels of the picture, from where a surface was to where it is, y down
  the depth        an EXR: Z, 0 to 1
  the matrices     JSON: view_projection and previous_view_projection, four rows of four numbers each

Examples:
  vrcs analyse frame.png -o sri.png --overlay overlay.png
  vrcs analyse frame.exr --threshold 0.1 --attachment khr --tile 16 --attachment-output rates.png
  vrcs analyse frame2.png --previous frame1.png --motion motion.exr --depth depth2.exr --previous-depth depth1.exr")]
pub(super) struct Arguments {
    /// The picture: PNG, JPEG, EXR or Radiance HDR; `-` is standard input.
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    /// Where the rates go, as a grey PNG.
    #[arg(short, long, value_name = "SRI.png")]
    output: Option<PathBuf>,
    #[command(flatten)]
    options: Options,
    /// The picture of the frame before, which is what is analysed, along motion; without, IMAGE itself is.
    #[arg(long, value_name = "IMAGE")]
    previous: Option<PathBuf>,
    /// IMAGE's motion vectors.
    #[arg(long, value_name = "FILE.exr", conflicts_with = "matrices")]
    motion: Option<PathBuf>,
    /// IMAGE's depth; with --previous-depth it finds what was hidden, with --matrices it gives the motion.
    #[arg(long, value_name = "FILE.exr")]
    depth: Option<PathBuf>,
    /// The depth of the frame before.
    #[arg(long, value_name = "FILE.exr", requires = "depth")]
    previous_depth: Option<PathBuf>,
    /// The cameras of both frames, for the motion of a scene that has no vectors.
    #[arg(long, value_name = "FILE.json", requires = "depth")]
    matrices: Option<PathBuf>,
    /// What depth 0 is: the far plane (reversed) or the near one (standard).
    #[arg(long, value_name = "KIND", default_value = "reversed")]
    z: Z,
    /// Also make the image that hardware variable-rate shading reads.
    #[arg(long, value_name = "KIND", requires = "attachment_output")]
    attachment: Option<Kind>,
    /// Where that image goes, as a grey PNG.
    #[arg(long, value_name = "FILE.png", requires = "attachment")]
    attachment_output: Option<PathBuf>,
    /// The side of its tiles: 8, 16 or 32 pixels.
    #[arg(long, default_value = "16", value_name = "N", value_parser = parse_tile, requires = "attachment")]
    tile: Tile,
    /// Samples for each pixel of the target that is drawn to.
    #[arg(long, default_value = "1", value_name = "N", value_parser = parse_samples, requires = "attachment")]
    samples: Samples,
    /// Where a picture goes that shows the rates.
    #[arg(long, value_name = "FILE.png")]
    overlay: Option<PathBuf>,
    /// Where the reasons go, as a grey PNG.
    #[arg(long, value_name = "FILE.png")]
    reasons: Option<PathBuf>,
    /// Run on the CPU: the same bytes, without a driver.
    #[arg(long, conflicts_with = "adapter")]
    cpu: bool,
    /// The adapter: a part of its name. See `vrcs adapters`.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Print the results as JSON.
    #[arg(long)]
    json: bool,
}

/// Which way depth goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Z {
    /// 1 is near.
    Reversed,
    /// 0 is near.
    Standard,
}

/// The interface that an attachment is for.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Kind {
    /// Direct3D 12, tier 2, with the additional shading rates.
    D3d12,
    /// `VK_KHR_fragment_shading_rate`, with the rates that NVIDIA's driver lists.
    Khr,
    /// `VK_NV_shading_rate_image`, `GL_NV_shading_rate_image` and NVAPI.
    Nv,
}

fn parse_tile(text: &str) -> Result<Tile, String> {
    let side = text.parse().ok().and_then(Tile::new);
    side.ok_or_else(|| "a tile is 8, 16 or 32 pixels wide".to_owned())
}

fn parse_samples(text: &str) -> Result<Samples, String> {
    let count: u32 = text.parse().map_err(|_| "that is no number".to_owned())?;
    Samples::try_from(count).map_err(|error| error.to_string())
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    refuse_what_does_nothing(arguments)?;
    refuse_to_overwrite(arguments)?;
    let has_motion = arguments.motion.is_some() || arguments.matrices.is_some();
    let mut settings = arguments.options.settings(has_motion)?;
    let picture = Picture::read(&arguments.image)?;
    let size = picture.size();
    let given = Given::read(arguments, size)?;
    if given.motion.is_some() {
        settings.reprojection = arguments.previous.as_ref().map(|_| Reprojection {
            reversed_z: arguments.z == Z::Reversed,
            ..Reprojection::default()
        });
        settings.motion.get_or_insert_with(Motion::default);
    }
    let analysed = given.previous.as_ref().unwrap_or(&picture);
    if arguments.options.refit_k {
        settings.content.k = refit(analysed)?;
    }
    let found = analyse(arguments, &settings, size, analysed, &given)?;
    let granularity = arguments.options.granularity;
    let sri = uniform_in(&found.sri, size, granularity);
    let attachment = arguments.attachment.map(|kind| {
        let rates = uniform_in(&found.attachment, size, granularity);
        attach(&rates, size, &attach_options(kind, arguments))
    });
    write(
        arguments,
        &picture,
        &sri,
        &found.reasons,
        attachment.as_ref(),
    )?;
    print(arguments, &settings, size, &sri, attachment.as_ref())
}

/// k of a picture, within what the analysis takes.
fn refit(picture: &Picture) -> Result<f64, Failure> {
    let k = refit_k(&picture.luma()).ok_or_else(|| {
        Failure::Refused(
            "k cannot be refitted: the picture has no differences, a value that is no number, or fewer than 3 pixels on a side"
                .to_owned(),
        )
    })?;
    Ok(k.clamp(1.0, 15.0))
}

/// What the picture is analysed with.
struct Given {
    previous: Option<Picture>,
    motion: Option<Vec<[f32; 2]>>,
    depth: Option<Vec<f32>>,
    previous_depth: Option<Vec<f32>>,
}

impl Given {
    fn read(arguments: &Arguments, size: [u32; 2]) -> Result<Given, Failure> {
        let previous = arguments
            .previous
            .as_deref()
            .map(Picture::read)
            .transpose()?;
        let before = previous.as_ref().map_or(size, Picture::size);
        let depth_of = |path: &Option<PathBuf>, size| {
            path.as_deref()
                .map(|path| layers::depth(path, size))
                .transpose()
        };
        let depth = depth_of(&arguments.depth, size)?;
        let previous_depth = depth_of(&arguments.previous_depth, before)?;
        let motion = match (&arguments.motion, &arguments.matrices, &depth) {
            (Some(path), ..) => Some(layers::motion(path, size)?),
            (None, Some(path), Some(depth)) => {
                let [now, before] = layers::matrices(path)?;
                Some(reproject::camera_motions(size, depth, &now, &before))
            }
            _ => None,
        };
        Ok(Given {
            previous,
            motion,
            // the depth test needs both
            depth: depth.filter(|_| previous_depth.is_some()),
            previous_depth,
        })
    }
}

fn analyse(
    arguments: &Arguments,
    settings: &Settings,
    size: [u32; 2],
    picture: &Picture,
    given: &Given,
) -> Result<Found, Failure> {
    let refused = |error: &dyn std::fmt::Display| Failure::Misused(error.to_string());
    let mut pixels = picture.pixels();
    if arguments.options.luma_source == LumaSource::Root {
        let inputs = Inputs::of_colour(picture.size(), pixels.colour());
        let own = Settings {
            content: settings.content,
            ..Settings::default()
        };
        let rows = integer::analyse(&inputs, &own).map_err(|error| refused(&error))?;
        let width = picture.size()[0] as usize;
        let pitch = rows.sqrt_luma.len() / picture.size()[1] as usize;
        let codes = rows
            .sqrt_luma
            .chunks_exact(pitch)
            .flat_map(|row| &row[..width]);
        pixels = Pixels::Root(codes.copied().collect());
    }
    let inputs = Inputs {
        size,
        motion: given.motion.as_deref(),
        depth: given.depth.as_deref(),
        previous_depth: given.previous_depth.as_deref(),
        ..Inputs::of_colour(picture.size(), pixels.colour())
    };
    if arguments.cpu {
        let output = integer::analyse(&inputs, settings).map_err(|error| refused(&error))?;
        return Ok(Found {
            sri: output.sri,
            attachment: output.attachment,
            reasons: output.reasons,
        });
    }
    inputs.check().map_err(|error| refused(&error))?;
    let scene = Scene {
        colour: match inputs.colour {
            Colour::Codes(_) => ColourForm::Codes,
            Colour::Linear(_) => ColourForm::Linear,
            Colour::SqrtLuma(_) => ColourForm::SqrtLuma,
        },
        motion: inputs.motion.is_some(),
        depth: inputs.depth.is_some(),
        attachment: true,
        reasons: true,
        ..Scene::default()
    };
    let plan = Plan::new(&scene, settings).map_err(|error| refused(&error))?;
    let gpu =
        Gpu::open(arguments.adapter.as_deref()).map_err(|error| match Failure::from(error) {
            Failure::Outside(why) => Failure::Outside(format!("{why}; --cpu needs none")),
            other => other,
        })?;
    device::run(&gpu, &plan, &inputs)
}

/// Rates that hold for whole squares of pixels: the finest of each.
fn uniform_in(sri: &Sri, [width, height]: [u32; 2], side: u32) -> Sri {
    let (layout, quads) = (sri.layout(), side / 2);
    let of_square = |x: u32, y: u32| {
        let (left, top) = (x / quads * quads, y / quads * quads);
        let all = (top..(top + quads).min(layout.height))
            .flat_map(|y| (left..(left + quads).min(layout.width)).map(move |x| (x, y)));
        all.map(|(x, y)| Rate::from_code_or_full(sri.code(x, y)))
            .reduce(Rate::meet)
            .unwrap_or(Rate::R1X1)
    };
    Sri::from_fn(width, height, |x, y| of_square(x, y).code())
}

/// Inputs that would be read and not be used.
fn refuse_what_does_nothing(arguments: &Arguments) -> Result<(), Failure> {
    let has_motion = arguments.motion.is_some() || arguments.matrices.is_some();
    let cases = [
        (
            arguments.depth.is_some()
                && arguments.matrices.is_none()
                && arguments.previous_depth.is_none(),
            "--depth alone tells nothing: --previous-depth finds what was hidden, --matrices gives the motion",
        ),
        (
            arguments.previous_depth.is_some() && !(has_motion && arguments.previous.is_some()),
            "--previous-depth needs --previous, and --motion or --matrices: it is looked up along motion",
        ),
    ];
    match cases.into_iter().find(|&(is_idle, _)| is_idle) {
        Some((_, why)) => Err(Failure::Misused(why.to_owned())),
        None => Ok(()),
    }
}

fn outputs(arguments: &Arguments) -> impl Iterator<Item = &Path> {
    [
        &arguments.output,
        &arguments.attachment_output,
        &arguments.overlay,
        &arguments.reasons,
    ]
    .into_iter()
    .filter_map(|path| path.as_deref())
}

fn refuse_to_overwrite(arguments: &Arguments) -> Result<(), Failure> {
    let paths: Vec<&Path> = outputs(arguments).collect();
    for (index, path) in paths.iter().enumerate() {
        if files::is_stream(path) {
            return Err(Failure::Misused(
                "pictures are written to files; the results are what standard output is for"
                    .to_owned(),
            ));
        }
        let inputs = [
            &arguments.previous,
            &arguments.motion,
            &arguments.depth,
            &arguments.previous_depth,
            &arguments.matrices,
        ];
        let mut inputs = inputs.into_iter().flatten().chain([&arguments.image]);
        if inputs.any(|input| files::is_same(path, input)) {
            return Err(Failure::Misused(format!(
                "{}: this would overwrite what is analysed",
                path.display()
            )));
        }
        if paths[..index]
            .iter()
            .any(|other| files::is_same(path, other))
        {
            return Err(Failure::Misused(format!(
                "{}: two outputs cannot go to one file",
                path.display()
            )));
        }
    }
    Ok(())
}

fn attach_options(kind: Kind, arguments: &Arguments) -> AttachOptions {
    let (encoding, support) = match kind {
        Kind::D3d12 => (Encoding::D3d12, Support::d3d12(AdditionalRates::Yes)),
        Kind::Khr => (Encoding::Khr, Support::nvidia()),
        Kind::Nv => (Encoding::Nv, Support::nvidia()),
    };
    AttachOptions {
        tile: arguments.tile,
        encoding,
        support,
        samples: arguments.samples,
    }
}

/// Writes all files: first each beside its place, then, when all are there, into their places.
fn write(
    arguments: &Arguments,
    picture: &Picture,
    sri: &Sri,
    reasons: &[u8],
    attachment: Option<&Attachment>,
) -> Result<(), Failure> {
    let mut pending: Vec<(&Path, Pending)> = Vec::new();
    if let Some(path) = &arguments.output {
        let layout = sri.layout();
        let png = picture::grey_png([layout.width, layout.height], |x, y| sri.code(x, y));
        pending.push((path, files::prepare(path, &png)?));
    }
    if let (Some(path), Some(attachment)) = (&arguments.attachment_output, attachment) {
        let layout = attachment.layout();
        let png = picture::grey_png([layout.width, layout.height], |x, y| {
            attachment.texel(x, y).unwrap_or_default()
        });
        pending.push((path, files::prepare(path, &png)?));
    }
    if let Some(path) = &arguments.reasons {
        let layout = sri.layout();
        let png = picture::grey_png([layout.width, layout.height], |x, y| {
            reasons[(y * layout.pitch + x) as usize]
        });
        pending.push((path, files::prepare(path, &png)?));
    }
    if let Some(path) = &arguments.overlay {
        let png = overlay::draw(picture, sri);
        pending.push((path, files::prepare(path, &png)?));
    }
    for (path, file) in pending {
        file.appear()
            .map_err(|error| files::unwritable(path, &error))?;
    }
    Ok(())
}

/// The share of quads at each rate, from fine to coarse.
fn shares(rates: impl Iterator<Item = Rate>) -> Vec<(Rate, f64)> {
    let mut counts = [0u64; 7];
    for rate in rates {
        let place = Rate::ALL.iter().position(|&other| other == rate);
        counts[place.unwrap_or(0)] += 1;
    }
    let total = counts.iter().sum::<u64>().max(1) as f64;
    Rate::ALL
        .into_iter()
        .zip(counts.map(|count| count as f64 / total))
        .collect()
}

fn shares_of(sri: &Sri) -> Vec<(Rate, f64)> {
    let layout = sri.layout();
    shares(
        (0..layout.height)
            .flat_map(|y| (0..layout.width).map(move |x| (x, y)))
            .map(|(x, y)| Rate::from_code_or_full(sri.code(x, y))),
    )
}

fn shares_of_tiles(attachment: &Attachment, tile: Tile) -> Vec<(Rate, f64)> {
    let layout = attachment.layout();
    shares(
        (0..layout.height)
            .flat_map(|y| (0..layout.width).map(move |x| (x, y)))
            .map(
                |(x, y)| match attachment.shading_at(x * tile.side(), y * tile.side()) {
                    Shading::Coarse(rate) => rate,
                    Shading::Cull | Shading::Supersampled(_) => Rate::R1X1,
                },
            ),
    )
}

/// The share of invocations that are left, if every quad holds its rate.
fn invocations(shares: &[(Rate, f64)]) -> f64 {
    shares
        .iter()
        .map(|(rate, share)| share / f64::from(rate.pixels()))
        .sum()
}

fn print(
    arguments: &Arguments,
    settings: &Settings,
    [width, height]: [u32; 2],
    sri: &Sri,
    attachment: Option<&Attachment>,
) -> Result<(), Failure> {
    let quads = shares_of(sri);
    let tiles = attachment.map(|attachment| shares_of_tiles(attachment, arguments.tile));
    if arguments.json {
        let object = |shares: &[(Rate, f64)]| -> serde_json::Value {
            shares
                .iter()
                .map(|(rate, share)| (rate.to_string(), json!(share)))
                .collect::<serde_json::Map<_, _>>()
                .into()
        };
        let result = json!({
            "image": files::display_name(&arguments.image),
            "width": width,
            "height": height,
            "k": settings.content.k,
            "threshold": settings.content.threshold,
            "ambient": settings.content.ambient * 2f64.powi(settings.content.white_log2),
            "rates": object(&quads),
            "invocations": invocations(&quads),
            "attachment": tiles.as_deref().map(|tiles| json!({
                "tile": arguments.tile.side(),
                "rates": object(tiles),
                "invocations": invocations(tiles),
            })),
        });
        return talk::data(&result.to_string());
    }
    talk::data(&format!("{:<12} {width}x{height}", "picture"))?;
    if arguments.options.refit_k {
        talk::data(&format!("{:<12} {:.3}, refitted", "k", settings.content.k))?;
    }
    table("quads", &quads)?;
    if let Some(tiles) = &tiles {
        table(&format!("tiles of {}", arguments.tile.side()), tiles)?;
    }
    for path in outputs(arguments) {
        talk::data(&format!("{:<12} {}", "written", path.display()))?;
    }
    Ok(())
}

fn table(name: &str, shares: &[(Rate, f64)]) -> Result<(), Failure> {
    for (rate, share) in shares.iter().filter(|(_, share)| *share > 0.0) {
        talk::data(&format!(
            "{name:<12} {rate} {:5.1} %  {}",
            100.0 * share,
            overlay::colour_name(*rate)
        ))?;
    }
    talk::data(&format!(
        "{name:<12} {:.1} % of the invocations are left",
        100.0 * invocations(shares)
    ))
}
