//! How much is coarse: the share of each rate, as text and as JSON.

use serde_json::json;

use super::{Arguments, overlay};
use crate::{
    Rate,
    analyse::Settings,
    attach::{Shading, Tile, cpu::Attachment},
    cli::{Failure, files, talk},
    sri::Sri,
};

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

/// Prints what was found.
pub(super) fn print(
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
    for path in arguments.outputs.paths() {
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
