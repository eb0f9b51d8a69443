//! Pictures of a point for the report, as data URIs: the whole frame, a close-up, the ꟻLIP map; and rates, reasons and what is skipped,
//! layers of one pixel a quad, to be laid over either.
//!
//! *Guarantees*: layers are exact, in as few bits as their colours need. A frame that is larger than a page shows is reduced to that,
//! and has a close-up beside it, pixel by pixel, of where settings differ most from full rate: so a page of six scenes stays one
//! that a browser opens at once. Pictures of more than a few pixels are JPEG; errors are measured before.

use std::collections::BTreeMap;

use image::{ExtendedColorType, GrayImage, ImageEncoder, RgbImage, imageops};

use super::{bench::Last, study::Close};
use crate::{Rate, analyse::Reason, demo::rate_color, metrics, sri::SriLayout};

/// The longer side of a whole frame, as a page shows it.
const WHOLE: u32 = 960;
/// Width and height of a close-up.
const CLOSE: [u32; 2] = [640, 360];
/// Close-ups begin at multiples of this, so that blocks of 4×4 are whole in them.
const STEP: usize = 8;
/// Pixels of a picture that is kept exactly.
const EXACT: u32 = 1 << 14;
/// JPEG qualities of frames, close-ups and maps.
const QUALITY: Quality = Quality {
    whole: 82,
    close: 90,
    map: 72,
};

struct Quality {
    whole: u8,
    close: u8,
    map: u8,
}

/// A part of a frame: left, top, width, height.
pub type Window = [u32; 4];

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

fn rgb_of(rgba: &[u8]) -> Vec<u8> {
    let mut rgb = Vec::with_capacity(rgba.len() / 4 * 3);
    for pixel in rgba.chunks_exact(4) {
        rgb.extend_from_slice(&pixel[..3]);
    }
    rgb
}

/// The size at which a page shows a whole frame.
fn whole_size([width, height]: [u32; 2]) -> [u32; 2] {
    let longer = width.max(height);
    match longer <= WHOLE {
        true => [width, height],
        false => [width, height].map(|side| (side * WHOLE).div_ceil(longer)),
    }
}

/// A whole frame, RGBA, as a data URI: reduced if it is larger than a page shows.
pub fn whole(size: [u32; 2], rgba: &[u8]) -> String {
    let wanted = whole_size(size);
    let rgb = rgb_of(rgba);
    let rgb = match (wanted == size, RgbImage::from_raw(size[0], size[1], rgb)) {
        (true, Some(picture)) => picture.into_raw(),
        (false, Some(picture)) => imageops::thumbnail(&picture, wanted[0], wanted[1]).into_raw(),
        (_, None) => unreachable!("four bytes for each pixel"),
    };
    picture(wanted, &rgb, QUALITY.whole)
}

/// Where to look closely: the window in which the errors of all these frames together are greatest; nothing if a page shows whole
/// frames pixel by pixel anyway. Of frames without any error, their middle.
pub fn window(size: [u32; 2], errors: &[Vec<f32>]) -> Option<Window> {
    if whole_size(size) == size {
        return None;
    }
    let [width, height] = size.map(|side| side as usize);
    let [wide, high] = [0, 1].map(|i| CLOSE[i].min(size[i]) as usize);
    // sums over all above and to the left
    let mut sums = vec![0.0; (width + 1) * (height + 1)];
    for y in 0..height {
        let mut row = 0.0;
        for x in 0..width {
            row += errors
                .iter()
                .map(|e| f64::from(e[y * width + x]))
                .sum::<f64>();
            sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + row;
        }
    }
    let sum = |left: usize, top: usize| {
        let at = |x: usize, y: usize| sums[y * (width + 1) + x];
        at(left + wide, top + high) - at(left, top + high) - at(left + wide, top) + at(left, top)
    };
    let lefts = (0..=width - wide).step_by(STEP);
    let places = lefts.flat_map(|left| {
        (0..=height - high)
            .step_by(STEP)
            .map(move |top| (left, top))
    });
    let middle = [(width - wide) / 2, (height - high) / 2].map(|side| side / STEP * STEP);
    let mut best = (sum(middle[0], middle[1]), middle);
    for (left, top) in places {
        let found = sum(left, top);
        // not for what rounding alone adds
        if found > best.0 * 1.001 + 1e-6 {
            best = (found, [left, top]);
        }
    }
    let [left, top] = best.1;
    Some([left, top, wide, high].map(|value| value as u32))
}

/// A part of a frame, RGBA, as a data URI, pixel by pixel.
pub fn close_up(size: [u32; 2], rgba: &[u8], [left, top, wide, high]: Window) -> String {
    let mut rgb = Vec::with_capacity((wide * high * 3) as usize);
    for y in top..top + high {
        let from = (y * size[0] + left) as usize * 4;
        rgb.extend(rgb_of(&rgba[from..from + wide as usize * 4]));
    }
    picture([wide, high], &rgb, QUALITY.close)
}

/// The close-up of the full-rate frame.
pub fn close(size: [u32; 2], full: &[u8], window: Option<Window>) -> Option<Close> {
    let window = window?;
    Some(Close {
        window,
        full: close_up(size, full, window),
    })
}

/// A map of errors in the magma colours, as large as whole frames are shown.
fn map(size: [u32; 2], errors: &[f32]) -> String {
    let wanted = whole_size(size);
    let codes: Vec<u8> = errors
        .iter()
        .map(|error| (error.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)
        .collect();
    let Some(codes) = GrayImage::from_raw(size[0], size[1], codes) else {
        unreachable!("an error for each pixel")
    };
    let codes = match wanted == size {
        true => codes,
        false => imageops::thumbnail(&codes, wanted[0], wanted[1]),
    };
    let errors: Vec<f32> = codes.iter().map(|&code| f32::from(code) / 255.0).collect();
    picture(wanted, &metrics::magma(&errors), QUALITY.map)
}

/// The pictures of a point. `errors` are those of ꟻLIP, for each pixel.
pub fn of_frame(
    size: [u32; 2],
    last: &Last,
    largest: Rate,
    errors: &[f32],
    window: Option<Window>,
) -> BTreeMap<String, String> {
    let layout = SriLayout::new(size[0], size[1]);
    let quads = [layout.width, layout.height];
    let layer = |colours: &[[u8; 3]], index: &dyn Fn(u32, u32) -> usize| {
        let places = (0..quads[1]).flat_map(|y| (0..quads[0]).map(move |x| (x, y)));
        let indexes: Vec<u8> = places.map(|(x, y)| index(x, y) as u8).collect();
        indexed(quads, colours, &indexes)
    };
    let place = |wanted: Rate| Rate::ALL.iter().position(|&rate| rate == wanted);
    let mut pictures = BTreeMap::from([(
        "rates".to_owned(),
        layer(&Rate::ALL.map(rate_color), &|x, y| {
            place(last.left.sri.rate(x, y, largest)).unwrap_or_default()
        }),
    )]);
    if last.picture != *last.full {
        pictures.insert("variable".to_owned(), whole(size, &last.picture));
        pictures.insert("flip".to_owned(), map(size, errors));
        if let Some(window) = window {
            pictures.insert("close".to_owned(), close_up(size, &last.picture, window));
        }
    }
    if let Some(skipped) = &last.skipped {
        let is_skipped = |x: u32, y: u32| {
            let pixels = (0..4).map(|i| [x * 2 + i % 2, y * 2 + i / 2]);
            let mut inside = pixels.filter(|[x, y]| *x < size[0] && *y < size[1]);
            inside.all(|[x, y]| skipped[(y * size[0] + x) as usize])
        };
        let index = |x, y| usize::from(is_skipped(x, y));
        pictures.insert("skipped".to_owned(), layer(&[RUN, SKIPPED], &index));
    }
    if let Some(reasons) = &last.left.reasons {
        // what is no reason is black
        let mut colours: Vec<[u8; 3]> = Reason::ALL.iter().map(|&of| reason(of).1).collect();
        colours.push([0; 3]);
        let index = |x: u32, y: u32| {
            let byte = reasons.get((y * layout.pitch + x) as usize).copied();
            let known = byte.and_then(Reason::from_byte);
            known
                .and_then(|known| Reason::ALL.iter().position(|&of| of == known))
                .unwrap_or(colours.len() - 1)
        };
        pictures.insert("reasons".to_owned(), layer(&colours, &index));
    }
    pictures
}

/// A picture as a data URI: exact if it is small, else JPEG.
fn picture([width, height]: [u32; 2], rgb: &[u8], quality: u8) -> String {
    if width * height > EXACT {
        let mut jpeg = Vec::new();
        let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, quality);
        if encoder
            .write_image(rgb, width, height, ExtendedColorType::Rgb8)
            .is_ok()
        {
            return format!("data:image/jpeg;base64,{}", base64(&jpeg));
        }
    }
    let mut bytes = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    match encoder.write_image(rgb, width, height, ExtendedColorType::Rgb8) {
        Ok(()) => format!("data:image/png;base64,{}", base64(&bytes)),
        Err(error) => unreachable!("memory takes every byte: {error}"),
    }
}

/// A picture of a few colours as a data URI, exactly: for each pixel the place of its colour.
fn indexed([width, height]: [u32; 2], colours: &[[u8; 3]], indexes: &[u8]) -> String {
    let (depth, bits) = match colours.len() {
        0..=2 => (png::BitDepth::One, 1),
        3..=4 => (png::BitDepth::Two, 2),
        5..=16 => (png::BitDepth::Four, 4),
        _ => (png::BitDepth::Eight, 8),
    };
    let a_byte = 8 / bits;
    let packed: Vec<u8> = indexes
        .chunks_exact(width as usize)
        .flat_map(|row| {
            row.chunks(a_byte).map(|few| {
                let shifted = few.iter().enumerate();
                shifted.fold(0, |byte, (i, &index)| byte | index << (8 - bits * (i + 1)))
            })
        })
        .collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(depth);
    encoder.set_palette(colours.concat());
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    let written = encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(&packed));
    match written {
        Ok(()) => format!("data:image/png;base64,{}", base64(&bytes)),
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

    /// The bytes of a data URI of a PNG.
    fn png_of(uri: &str) -> RgbImage {
        let text = uri.strip_prefix("data:image/png;base64,").expect("a PNG");
        let digit = |c: u8| match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            _ => 63,
        };
        let mut bytes = Vec::new();
        for four in text.trim_end_matches('=').as_bytes().chunks(4) {
            let word = four.iter().fold(0u32, |w, &c| w << 6 | u32::from(digit(c)));
            let word = word << (6 * (4 - four.len()));
            bytes.extend_from_slice(&word.to_be_bytes()[1..four.len()]);
        }
        image::load_from_memory(&bytes)
            .expect("a picture")
            .to_rgb8()
    }

    #[test]
    fn layers_are_exact_whatever_the_number_of_colours_and_the_width() {
        let mut rng = fastrand::Rng::with_seed(5);
        for (count, width) in [(2, 9), (3, 5), (7, 13), (14, 8), (40, 3)] {
            let colours: Vec<[u8; 3]> = (0..count).map(|i| [i * 5, 255 - i, i]).collect();
            let indexes: Vec<u8> = (0..width * 7).map(|_| rng.u8(0..count)).collect();
            let found = png_of(&indexed([width, 7], &colours, &indexes));
            assert_eq!(found.dimensions(), (width, 7));
            for (pixel, &index) in found.pixels().zip(&indexes) {
                assert_eq!(pixel.0, colours[usize::from(index)], "{count} colours");
            }
        }
    }

    #[test]
    fn a_close_up_is_where_errors_are_and_only_of_frames_that_are_reduced() {
        assert_eq!(window([960, 540], &[vec![1.0; 960 * 540]]), None);
        let size = [1920, 1080];
        let mut errors = vec![0.0; 1920 * 1080];
        assert_eq!(window(size, &[errors.clone()]), Some([640, 360, 640, 360]));
        for y in 900..1000 {
            errors[y * 1920 + 100..y * 1920 + 300].fill(0.5);
        }
        let [left, top, wide, high] = window(size, &[errors]).expect("a window");
        assert!(left <= 100 && left + wide >= 300 && top <= 900 && top + high >= 1000);
        assert_eq!([left % 8, top % 8], [0, 0]);
    }

    #[test]
    fn a_close_up_has_the_frames_own_pixels() {
        let rgba: Vec<u8> = (0..20 * 10u32)
            .flat_map(|i| [(i % 20) as u8, (i / 20) as u8, 9, 255])
            .collect();
        let found = png_of(&close_up([20, 10], &rgba, [8, 4, 5, 3]));
        assert_eq!(found.dimensions(), (5, 3));
        assert_eq!(found.get_pixel(2, 1).0, [10, 5, 9]);
    }

    #[test]
    fn a_large_frame_is_reduced_in_its_own_shape() {
        assert_eq!(whole_size([1920, 1080]), [960, 540]);
        assert_eq!(whole_size([640, 360]), [640, 360]);
        assert_eq!(whole_size([1080, 1920]), [540, 960]);
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
