//! Pictures of a point for the report, as data URIs; rates, reasons and what is skipped are layers of one pixel a quad, to be laid
//! over the scene.
//!
//! *Guarantees*: layers, and pictures of up to a million pixels, are exact (PNG). Larger ones are JPEG of quality 92, for a page of a
//! hundred pictures to be opened at all; errors are measured before.

use std::collections::BTreeMap;

use image::{ExtendedColorType, ImageEncoder};

use super::bench::Last;
use crate::{Rate, analyse::Reason, demo::rate_color, sri::SriLayout};

/// Pixels of a picture that is kept exactly.
const EXACT: u32 = 1 << 20;
/// The colours of quads that are skipped, and of others.
const SKIPPED: [u8; 3] = [0, 150, 220];
const RUN: [u8; 3] = [40, 40, 40];

/// What a reason is called, and its colour.
pub fn reason(reason: Reason) -> (&'static str, [u8; 3]) {
    match reason {
        Reason::None => ("as coarse as is allowed", [60, 60, 60]),
        Reason::Content => ("detail", [226, 60, 45]),
        Reason::NoHistory => ("no frame before", [255, 255, 255]),
        Reason::Invalid => ("no luma", [255, 0, 255]),
        Reason::OffScreen => ("was off the screen", [90, 70, 190]),
        Reason::Disoccluded => ("was hidden", [40, 140, 200]),
        Reason::Material => ("smooth metal", [240, 225, 70]),
        Reason::Mask => ("flagged", [255, 140, 200]),
        Reason::HalfRate => ("half rate", [120, 200, 120]),
        Reason::Neighbour => ("a finer neighbour", [0, 200, 180]),
        Reason::Motion => ("too slow", [245, 170, 40]),
        Reason::Own => ("the application's own", [150, 110, 60]),
        Reason::NoMotion => ("motion missing", [180, 180, 255]),
    }
}

/// Names and colours of the rates and of the reasons, for the report's legends.
pub fn legends() -> BTreeMap<String, Vec<(String, String)>> {
    let css = |[r, g, b]: [u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
    let rates = Rate::ALL
        .into_iter()
        .map(|rate| (rate.to_string(), css(rate_color(rate))))
        .collect();
    let reasons = Reason::ALL
        .into_iter()
        .map(|of| (reason(of).0.to_owned(), css(reason(of).1)))
        .collect();
    let skipped = vec![
        ("sky: material and rays skip it".to_owned(), css(SKIPPED)),
        ("every pass runs".to_owned(), css(RUN)),
    ];
    BTreeMap::from([
        ("rates".to_owned(), rates),
        ("reasons".to_owned(), reasons),
        ("skipped".to_owned(), skipped),
    ])
}

/// A full-colour picture as a data URI.
pub fn picture(size: [u32; 2], rgba: &[u8]) -> String {
    let rgb: Vec<u8> = rgba
        .chunks_exact(4)
        .flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])
        .collect();
    shown(size, &rgb)
}

/// The pictures of a point.
pub fn of_frame(size: [u32; 2], last: &Last, largest: Rate) -> BTreeMap<String, String> {
    let layout = SriLayout::new(size[0], size[1]);
    let quads = [layout.width, layout.height];
    let layer = |colour: &dyn Fn(u32, u32) -> [u8; 3]| {
        let rgb: Vec<u8> = (0..quads[1])
            .flat_map(|y| (0..quads[0]).map(move |x| (x, y)))
            .flat_map(|(x, y)| colour(x, y))
            .collect();
        uri(quads, &rgb)
    };
    let mut pictures = BTreeMap::from([(
        "rates".to_owned(),
        layer(&|x, y| rate_color(last.left.sri.rate(x, y, largest))),
    )]);
    if last.picture != *last.full {
        pictures.insert("variable".to_owned(), picture(size, &last.picture));
        pictures.insert("flip".to_owned(), shown(size, &last.map));
    }
    if let Some(skipped) = &last.skipped {
        let is_skipped = |x: u32, y: u32| {
            let pixels = (0..4).map(|i| [x * 2 + i % 2, y * 2 + i / 2]);
            let mut inside = pixels.filter(|[x, y]| *x < size[0] && *y < size[1]);
            inside.all(|[x, y]| skipped[(y * size[0] + x) as usize])
        };
        let colour = |x, y| if is_skipped(x, y) { SKIPPED } else { RUN };
        pictures.insert("skipped".to_owned(), layer(&colour));
    }
    if let Some(reasons) = &last.left.reasons {
        let at = |x: u32, y: u32| reasons.get((y * layout.pitch + x) as usize).copied();
        pictures.insert(
            "reasons".to_owned(),
            layer(&|x, y| {
                let known = at(x, y).and_then(Reason::from_byte);
                known.map_or([0; 3], |of| reason(of).1)
            }),
        );
    }
    pictures
}

/// A picture as a data URI: exact, or JPEG if it is large.
fn shown(size: [u32; 2], rgb: &[u8]) -> String {
    if size[0] * size[1] <= EXACT {
        return uri(size, rgb);
    }
    let mut jpeg = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 92);
    match encoder.write_image(rgb, size[0], size[1], ExtendedColorType::Rgb8) {
        Ok(()) => format!("data:image/jpeg;base64,{}", base64(&jpeg)),
        // a picture too wide for JPEG, which ends at 65,535 pixels
        Err(_) => uri(size, rgb),
    }
}

/// An RGB picture as a data URI, exactly.
fn uri([width, height]: [u32; 2], rgb: &[u8]) -> String {
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new_with_quality(
        &mut png,
        image::codecs::png::CompressionType::Best,
        image::codecs::png::FilterType::Adaptive,
    );
    match encoder.write_image(rgb, width, height, ExtendedColorType::Rgb8) {
        Ok(()) => format!("data:image/png;base64,{}", base64(&png)),
        Err(error) => unreachable!("memory takes every byte: {error}"),
    }
}

/// Base64 (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let word = (0..3).fold(0, |word, i| {
            word << 8 | u32::from(three.get(i).copied().unwrap_or(0))
        });
        for digit in 0..4 {
            text.push(match digit <= three.len() {
                true => char::from(DIGITS[(word >> (18 - 6 * digit) & 63) as usize]),
                false => '=',
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_rfc() {
        for (plain, coded) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn every_rate_and_reason_has_a_colour_of_its_own_in_the_legend() {
        for (name, legend) in legends() {
            let mut names: Vec<&String> = legend.iter().map(|(name, _)| name).collect();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), legend.len(), "{name}");
        }
    }
}
