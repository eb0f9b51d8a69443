//! `vrcs analyse`: how coarse a picture may be shaded.
//!
//! Does: analyses one picture's content, prints the share of each rate, writes the rates, the hardware-VRS image and an
//! overlay.
//! Needs: a picture in PNG, JPEG, EXR or Radiance HDR. No GPU.
//! Guarantees: all files are written, each whole, or none appears.
//! Refuses: what is no such picture, an output that is the input, a tile without an attachment.

mod overlay;
mod picture;

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use serde_json::json;

use self::picture::Picture;
use super::{Failure, files, talk};
use crate::{
    Rate,
    analyse::content::{self, Sensitivity},
    atomic::Pending,
    attach::{
        AdditionalRates, AttachOptions, Encoding, Samples, Shading, Support, Tile, cpu::Attachment,
        cpu::attach,
    },
    sri::Sri,
};

#[derive(Debug, clap::Args)]
#[command(after_help = "Files:
  SRI.png          one 8-bit grey pixel for each quad of 2x2 pixels: the code of its rate, (log2 W << 2) | log2 H
  the attachment   one 8-bit grey pixel for each tile: a code for d3d12 and khr, for nv an index into the palette whose
                   entries are the values of VkShadingRatePaletteEntryNV

Examples:
  vrcs analyse frame.png -o sri.png --overlay overlay.png
  vrcs analyse frame.exr --threshold 0.1 --attachment khr --tile 16 --attachment-output rates.png")]
pub(super) struct Arguments {
    /// The picture: PNG, JPEG, EXR or Radiance HDR; `-` is standard input.
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    /// Where the rates go, as a grey PNG.
    #[arg(short, long, value_name = "SRI.png")]
    output: Option<PathBuf>,
    /// How large a difference may be, as a share of the luma around it: t of the paper's Eq. 15.
    #[arg(long, default_value_t = Sensitivity::default().threshold, value_name = "T")]
    threshold: f64,
    /// The luma of the room, in the picture's units: l of the paper's Eq. 15.
    #[arg(long, default_value_t = Sensitivity::default().ambient, value_name = "L")]
    ambient: f64,
    /// The coarsest rate, on each axis.
    #[arg(long, default_value = "2x2", value_name = "WxH")]
    largest: Rate,
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
    /// Print the results as JSON.
    #[arg(long)]
    json: bool,
}

/// The interface that an attachment is for.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Kind {
    /// Direct3D 12, tier 2, with the additional shading rates.
    D3d12,
    /// `VK_KHR_fragment_shading_rate`, up to 16 samples in a coarse pixel.
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
    let sensitivity = sensitivity(arguments)?;
    refuse_to_overwrite(arguments)?;
    let picture = Picture::read(&arguments.image)?;
    let [width, height] = picture.size();
    let found = content::analyse(&picture.luma(), &sensitivity);
    let sri = Sri::from_fn(width, height, |x, y| {
        let rate = Rate::from_code_or_full(found.code(x, y));
        rate.meet(arguments.largest).code()
    });
    let attachment = arguments
        .attachment
        .map(|kind| attach(&sri, [width, height], &attach_options(kind, arguments)));
    write(arguments, &picture, &sri, attachment.as_ref())?;
    print(arguments, [width, height], &sri, attachment.as_ref())
}

fn sensitivity(arguments: &Arguments) -> Result<Sensitivity, Failure> {
    for (name, value) in [
        ("threshold", arguments.threshold),
        ("luma of the room", arguments.ambient),
    ] {
        if !value.is_finite() || value < 0.0 {
            return Err(Failure::Misused(format!("the {name} has to be 0 or more")));
        }
    }
    Ok(Sensitivity {
        threshold: arguments.threshold,
        ambient: arguments.ambient,
    })
}

fn outputs(arguments: &Arguments) -> impl Iterator<Item = &Path> {
    [
        &arguments.output,
        &arguments.attachment_output,
        &arguments.overlay,
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
        if files::is_same(path, &arguments.image) {
            return Err(Failure::Misused(format!(
                "{}: this would overwrite the picture that is analysed",
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
        Kind::Khr => (Encoding::Khr, Support::nv(16)),
        Kind::Nv => (Encoding::Nv, Support::nv(16)),
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
            "threshold": arguments.threshold,
            "ambient": arguments.ambient,
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
