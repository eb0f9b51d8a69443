//! `vrcs analyse`: how coarse a picture may be shaded.
//!
//! Does: runs the analysis of the library on a picture, or on the frame before it along its motion; prints the share of each
//! rate, writes the rates, the hardware-VRS image, the reasons and an overlay. All that the library can be given has a file of its own,
//! and all its settings a name in a file of settings.
//! Needs: a picture in PNG, JPEG, EXR or Radiance HDR; a driver, or `--cpu`, which gives the same bytes.
//! Guarantees: all files are written, each whole, or none appears.
//! Refuses: what is no such picture, inputs of another size, inputs that nothing looks at, an output that is an input, a tile without an
//! attachment.

mod device;
mod given;
mod layers;
pub(super) mod options;
mod outputs;
mod overlay;
mod picture;
mod shares;

use std::path::PathBuf;

use clap::ValueEnum;

use self::{
    device::Found,
    given::{Given, GivenFiles},
    options::{LumaSource, Options},
    outputs::{Made, OutputFiles},
    picture::{Picture, Pixels},
};
use super::Failure;
use crate::{
    analyse::{Colour, Granularity, Inputs, Settings, integer, refit::refit_k},
    attach::{AdditionalRates, AttachOptions, Encoding, Samples, Support, Tile, cpu::attach},
    check::gpu::Gpu,
    plan::{ColourForm, Plan, Scene},
};

const EXAMPLES: &str = "Examples:
  vrcs analyse frame.png -o sri.png --overlay overlay.png
  vrcs analyse frame.exr --threshold 0.1 --attachment khr --attachment-output rates.png
  vrcs analyse frame2.png --previous frame1.png --motion motion.exr --depth depth2.exr
`vrcs analyse --help` has all options, and what the files hold.";

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES, after_long_help = "Files:
  SRI.png          one 8-bit grey pixel for each quad of 2x2 pixels: the code of its rate, (log2 W << 2) | log2 H
  the attachment   one 8-bit grey pixel for each tile: a code for d3d12 and khr, for nv an index into the palette whose
                   entries are the values of VkShadingRatePaletteEntryNV
  the reasons      one 8-bit grey pixel for each quad: 0 coarse, 1 content, 2 no frame before, 3 no number, 4 off screen,
                   5 disoccluded, 6 a mirror, 7 masked, 8 the extra half rate, 9 a finer neighbour, 10 too slow,
                   11 the application's own rate, 12 motion missing
  the √luma        one 8-bit grey pixel for each pixel of what is analysed: round(255 √luma)
  the motion       an EXR: X and Y, in pixels of the picture, from where a surface was to where it is, y down
  the depth        an EXR: Z, 0 to 1
  the blur         an EXR: blur, coc or R, in pixels
  the matrices     JSON: view_projection and previous_view_projection, four rows of four numbers each
  the settings     TOML, every line of which may be left out; an effect that is not named is not there:
                     largest = \"4x2\"               # and smoothing, stability, overshoot, half-resolution
                     granularity = \"16x16\"         # one rate a tile; attachment = \"quad\" for the finest of a tile's quads
                     [content]                       # norm, pairs, difference, transfer, form, weights, threshold, ambient, k
                     threshold = 0.1
                     [motion]                        # blur, weight, scale
                     blur = { standalone = { error = 0.1 } }
                     [reprojection]                  # fetch, tolerance, reversed-z, near-over-far
                     fetch = \"tile\"
                     [lens]                          # focus, infinity, most, near, far, reversed-z
                     focus = 3.0
                     [materials]                     # least, slow, mirror, of
                     [half-rate]                     # tolerance, fast
                     [foveation]                     # centre, falloff, strength
                     [safe-area]                     # width, tolerance
                     [own.ids]
                     rates = { 3 = \"2x2\", 7 = \"1x1\" }
                     [own.distance]                  # steps, combiner, near, far, reversed-z
                     steps = [[20.0, \"2x1\"], [60.0, \"2x2\"]]
                     [own.particles]                 # rate, combiner

Examples:
  vrcs analyse frame.png -o sri.png --overlay overlay.png
  vrcs analyse frame.exr --threshold 0.1 --attachment khr --tile 16 --attachment-output rates.png
  vrcs analyse frame2.png --previous frame1.png --motion motion.exr --depth depth2.exr --previous-depth depth1.exr
  vrcs analyse frame.png --settings mine.toml --materials smoothness_rf0.png --mask hud.png --reasons why.png")]
pub(super) struct Arguments {
    /// The picture: PNG, JPEG, EXR or Radiance HDR; `-` is standard input.
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    #[command(flatten)]
    outputs: OutputFiles,
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    given: GivenFiles,
    /// What depth 0 is: the far plane (reversed) or the near one (standard).
    ///
    /// Reversed, unless the settings say otherwise.
    #[arg(long, value_name = "KIND", hide_short_help = true)]
    z: Option<Z>,
    /// Also make the image for hardware: d3d12, khr or nv.
    ///
    /// The image that hardware variable-rate shading reads.
    #[arg(
        long,
        value_name = "KIND",
        requires = "attachment_output",
        hide_possible_values = true
    )]
    attachment: Option<Kind>,
    /// The side of its tiles: 8, 16 or 32 pixels.
    #[arg(long, default_value = "16", value_name = "N", value_parser = parse_tile, requires = "attachment")]
    tile: Tile,
    /// Samples for each pixel of the target that is drawn to.
    #[arg(long, default_value = "1", value_name = "N", value_parser = parse_samples, requires = "attachment", hide_short_help = true)]
    samples: Samples,
    /// For nv: shade so many of a pixel's samples where the rate is full, as far as it has them.
    ///
    /// Coarse where it may be, supersampled where it must not: neither D3D12 nor Vulkan KHR has that.
    #[arg(long, value_name = "N", value_parser = parse_samples, requires = "attachment", hide_short_help = true)]
    supersample: Option<Samples>,
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
    outputs::refuse_to_overwrite(arguments)?;
    if arguments.supersample.is_some() && !matches!(arguments.attachment, Some(Kind::Nv)) {
        return Err(Failure::Misused(
            "--supersample needs --attachment nv: the others have no rate finer than a pixel"
                .to_owned(),
        ));
    }
    let mut settings = settings_of(arguments)?;
    let picture = Picture::read(&arguments.image)?;
    let size = picture.size();
    let mut given = arguments.given.read(&settings, size)?;
    // what is analysed is the frame before, if there is one; it is taken out, since what belongs to it stays
    let before = given.previous.take();
    let analysed = before.as_ref().unwrap_or(&picture);
    if arguments.options.refit_k {
        settings.content.k = refit(analysed)?;
    }
    let sizes = [size, analysed.size()];
    let (pixels, after) = pixels_of(arguments, &settings, analysed, &given)?;
    given.complete(&settings, &pixels, sizes);
    let inputs = Inputs {
        resolution_scale: arguments.options.resolution_scale,
        ..given.inputs(sizes, &pixels, after.as_ref())
    };
    let found = analyse(arguments, &settings, &inputs)?;
    let sri = &found.sri;
    let attachment = arguments
        .attachment
        .map(|kind| attach(&found.attachment, size, &attach_options(kind, arguments)));
    let made = Made {
        picture: &picture,
        sri,
        found: &found,
        analysed_size: analysed.size(),
        attachment: attachment.as_ref(),
    };
    outputs::write(arguments, &made)?;
    shares::print(arguments, &settings, size, sri, attachment.as_ref())
}

/// The settings: those of the file or the estimator, changed by the options, with the effects that files are given for.
fn settings_of(arguments: &Arguments) -> Result<Settings, Failure> {
    let given = &arguments.given;
    let mut settings = arguments.options.settings(given.has_motion())?;
    given.turn_on(&mut settings);
    if settings.attachment.is_tile()
        && let Some(tile) = Granularity::of_side(arguments.tile.side())
    {
        // the estimate is that of the very tiles
        settings.attachment = tile;
    }
    if arguments.outputs.half.is_some() {
        settings.half_resolution.get_or_insert_default();
    }
    if let Some(z) = arguments.z {
        let is_reversed = z == Z::Reversed;
        let kinds = [
            settings.reprojection.as_mut().map(|r| &mut r.reversed_z),
            settings.lens.as_mut().map(|lens| &mut lens.reversed_z),
            settings
                .own
                .as_mut()
                .and_then(|own| own.distance.as_mut())
                .map(|ladder| &mut ladder.reversed_z),
        ];
        for kind in kinds.into_iter().flatten() {
            *kind = is_reversed;
        }
    }
    given.check(&settings)?;
    Ok(settings)
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

/// What is analysed, before and after transparents, in the form that is asked for.
fn pixels_of(
    arguments: &Arguments,
    settings: &Settings,
    picture: &Picture,
    given: &Given,
) -> Result<(Pixels, Option<Pixels>), Failure> {
    let before = picture.pixels();
    let after = given.after().map(Picture::pixels);
    if arguments.options.luma_source == LumaSource::Root {
        let root = |pixels: &Pixels| root_of(pixels, picture.size(), settings);
        return Ok((root(&before)?, after.as_ref().map(root).transpose()?));
    }
    match &after {
        Some(after) if !before.is_like(after) => Err(Failure::Misused(
            "--after: it has another kind of pixels than what it follows (8 bits, or linear light)"
                .to_owned(),
        )),
        _ => Ok((before, after)),
    }
}

/// √luma of a picture, as the analysis writes it.
fn root_of(pixels: &Pixels, size: [u32; 2], settings: &Settings) -> Result<Pixels, Failure> {
    let own = Settings {
        content: settings.content,
        ..Settings::default()
    };
    let rows = integer::analyse(&Inputs::of_colour(size, pixels.colour()), &own)
        .map_err(|error| Failure::Misused(error.to_string()))?;
    let pitch = rows.sqrt_luma.len() / size[1] as usize;
    let lines = rows.sqrt_luma.chunks_exact(pitch);
    let codes = lines.flat_map(|row| &row[..size[0] as usize]);
    Ok(Pixels::Root(codes.copied().collect()))
}

fn analyse(arguments: &Arguments, settings: &Settings, inputs: &Inputs) -> Result<Found, Failure> {
    let refused = |error: &dyn std::fmt::Display| Failure::Misused(error.to_string());
    inputs
        .check_for(settings)
        .map_err(|error| refused(&error))?;
    let outputs = &arguments.outputs;
    let scene = Scene {
        colour: match inputs.colour {
            Colour::Codes(_) => ColourForm::Codes,
            Colour::Linear(_) => ColourForm::Linear,
            Colour::SqrtLuma(_) => ColourForm::SqrtLuma,
        },
        after_transparents: inputs.after.is_some(),
        motion: inputs.motion.is_some(),
        depth: inputs.depth.is_some(),
        cameras: inputs.cameras.is_some(),
        previous_rates: inputs.previous_rates.is_some(),
        materials: inputs.materials.is_some(),
        noise: inputs.noise.is_some(),
        ids: inputs.ids.is_some(),
        flags: inputs.flags.is_some(),
        blur: inputs.blur.is_some(),
        attachment: arguments.attachment.is_some(),
        plain_rates: outputs.plain.is_some(),
        reasons: outputs.reasons.is_some(),
        sqrt_luma: outputs.luma.is_some(),
        origin: false,
    };
    let plan = Plan::new(&scene, settings).map_err(|error| refused(&error))?;
    if arguments.cpu {
        let output = integer::analyse(inputs, settings).map_err(|error| refused(&error))?;
        return Ok(Found::from(output));
    }
    let gpu =
        Gpu::open(arguments.adapter.as_deref()).map_err(|error| match Failure::from(error) {
            Failure::Outside(why) => Failure::Outside(format!("{why}; --cpu needs none")),
            other => other,
        })?;
    device::run(&gpu, &plan, inputs)
}

fn attach_options(kind: Kind, arguments: &Arguments) -> AttachOptions {
    let (encoding, support) = match kind {
        Kind::D3d12 => (Encoding::D3d12, Support::d3d12(AdditionalRates::Yes)),
        Kind::Khr => (Encoding::Khr, Support::nvidia()),
        Kind::Nv => (
            arguments
                .supersample
                .map_or(Encoding::Nv, Encoding::NvSupersampled),
            Support::nvidia(),
        ),
    };
    AttachOptions {
        tile: arguments.tile,
        encoding,
        support,
        samples: arguments.samples,
    }
}
