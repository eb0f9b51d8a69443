//! What the analysis's families share: pictures, the twins, and the kernel on the test's driver.

use fastrand::Rng;
use vrcs::{
    Rate,
    analyse::{Colour, Inputs, Output, Settings, exact, integer},
    build::{BuildOptions, cpu as build, primary::Order},
    deblock::cpu as deblock,
    sri::Sri,
};

/// How a frame of a closed loop comes about.
#[derive(Clone, Copy, Debug)]
pub enum Way {
    /// Each pixel is its primary's copy.
    Copies { rotates: bool },
    /// By the builder's coordinates, and deblocked.
    Deblocked { rotates: bool },
}

/// A picture of linear grey by column and row.
pub fn grey([width, height]: [u32; 2], of: impl Fn(u32, u32) -> f32) -> Vec<[f32; 4]> {
    (0..width * height)
        .map(|i| [of(i % width, i / width); 4])
        .collect()
}

/// White noise around a half, the same on every run.
pub fn noise(size: [u32; 2], span: f32) -> Vec<[f32; 4]> {
    let mut rng = Rng::with_seed(7);
    let values: Vec<f32> = (0..size[0] * size[1]).map(|_| rng.f32()).collect();
    grey(size, |x, y| {
        0.5 + span * (values[(y * size[0] + x) as usize] - 0.5)
    })
}

/// Both twins.
pub fn twins(inputs: &Inputs, settings: &Settings) -> Result<[Output; 2], String> {
    let fixed = integer::analyse(inputs, settings).map_err(|error| error.to_string())?;
    let real = exact::analyse(inputs, settings).map_err(|error| error.to_string())?;
    Ok([fixed, real.output])
}

/// The rates by the integer twin.
pub fn rates(inputs: &Inputs, settings: &Settings) -> Sri {
    match integer::analyse(inputs, settings) {
        Ok(found) => found.sri,
        Err(error) => panic!("{error}"),
    }
}

/// The rates of a linear picture that nothing else is known of.
pub fn of_picture(size: [u32; 2], picture: &[[f32; 4]], settings: &Settings) -> Sri {
    rates(&Inputs::of_colour(size, Colour::Linear(picture)), settings)
}

/// The quads of an image, with their codes.
pub fn quads(sri: &Sri) -> impl Iterator<Item = ([u32; 2], u8)> + '_ {
    let layout = sri.layout();
    (0..layout.height)
        .flat_map(move |y| (0..layout.width).map(move |x| [x, y]))
        .map(|[x, y]| ([x, y], sri.code(x, y)))
}

/// How many quads two images of one size have at different rates.
pub fn apart(a: &Sri, b: &Sri) -> usize {
    quads(a).zip(quads(b)).filter(|(a, b)| a.1 != b.1).count()
}

/// Checks that every quad has one rate.
pub fn all_are(sri: &Sri, wanted: Rate, what: &str) -> Result<(), String> {
    match quads(sri).find(|&(_, code)| code != wanted.code()) {
        None => Ok(()),
        Some(([x, y], code)) => Err(format!(
            "{what}: quad {x},{y} is {}, not {wanted}",
            Rate::from_code_or_full(code)
        )),
    }
}

/// A frame shaded at its rates: each pixel is the first of its group, as copies are.
pub fn shade(
    [width, height]: [u32; 2],
    rates: &Sri,
    largest: Rate,
    phase: u32,
    truth: impl Fn(u32, u32) -> f32,
) -> Vec<[f32; 4]> {
    grey([width, height], |x, y| {
        let rate = rates.rate(x / 2, y / 2, largest);
        let (w, h) = (rate.width(), rate.height());
        // the primary moves from frame to frame where rotation is on
        let (left, top) = (x / w * w + phase % w, y / h * h + phase / 2 % h);
        truth(left.min(width - 1), top.min(height - 1))
    })
}

/// A frame shaded by the builder's map and deblocked, as a renderer has it.
pub fn shade_as_built(
    size: [u32; 2],
    rates: &Sri,
    frame: u32,
    rotates: bool,
    truth: impl Fn(u32, u32) -> f32,
) -> Vec<[f32; 4]> {
    let order = match rotates {
        true => Order::Rotating(frame),
        false => Order::Fixed,
    };
    let options = BuildOptions {
        effective: true,
        ..BuildOptions::default()
    };
    let built = build::build_frame(
        rates,
        size,
        &options,
        &build::Frame {
            order,
            ..build::Frame::default()
        },
    );
    let map = built.map();
    let shaded = grey(size, |x, y| {
        let primary = map[(y * size[0] + x) as usize];
        truth(primary % size[0], primary / size[0])
    });
    let bytes = built.effective();
    let pitch = rates.layout().pitch;
    let effective = Sri::from_fn(size[0], size[1], |x, y| bytes[(y * pitch + x) as usize]);
    let found = deblock::deblock(&deblock::Scene {
        extent: size,
        colors: &shaded,
        rates: &effective,
        order: order.code(),
        depth: None,
        surfaces: None,
    });
    let colors = found.colors.into_iter();
    colors.map(|color| color.map(|c| c as f32)).collect()
}
