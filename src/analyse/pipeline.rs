//! The stage's steps on the deterministic path, in order: the integer twin. The oracle in f64 has steps of its own ([`exact`](super::exact)).
//!
//! 1. Each pixel's source in the previous picture (`past.rs`); outside or hidden means doubt.
//! 2. Each quad's window of 4×4 pixels, the quad in its middle; at the border, pixels repeat. Or each tile's own pixels.
//! 3. The rate by content and motion (Eq. 16 and 22), under the tolerance of the place (`decide.rs`).
//! 4. Transparents; the extra half rate; the mask.
//! 5. Rates of 4 hold for aligned blocks of 4×4 pixels (`agree`); 4x4 becomes 2x4 or 4x2.
//! 6. Smoothing.
//! 7. The application's own rates; then those of half the resolution.
//!
//! *Guarantees*: any doubt means full rate; 4x1 and 1x4 never come out.

use super::{
    decide::{Logs, Quad, Stage},
    inputs::{Inputs, Output, WrongInput, flags},
    integer::Integers,
    motion,
    optics::Optics,
    params::{self, Params},
    past::{NoSource, source},
    reasons::Reason,
    settings::{Granularity, Settings, Smoothing, Stability},
    smoothing::smooth,
};
use crate::{
    rate::Rate,
    sri::{Sri, SriLayout},
};

/// Whether the inputs serve the settings: of both twins.
pub(super) fn check(inputs: &Inputs, settings: &Settings) -> Result<(), WrongInput> {
    inputs.check_for(settings)?;
    let own = settings.own.clone().unwrap_or_default();
    let needs = [
        (
            settings.motion.is_some() || settings.reprojection.is_some(),
            inputs.motion.is_some() || inputs.cameras.is_some() && inputs.depth.is_some(),
            "motion vectors",
        ),
        (
            settings.lens.is_some(),
            inputs.depth.is_some() && settings.motion.is_some(),
            "depth and motion for the lens",
        ),
        (
            settings.later_blur,
            inputs.blur.is_some() && settings.motion.is_some(),
            "the later blur's width and motion vectors",
        ),
        (
            settings.materials.is_some(),
            inputs.materials.is_some(),
            "materials",
        ),
        (
            settings.transparents,
            inputs.after.is_some(),
            "the colour after transparents",
        ),
        (
            settings.stability != Stability::None,
            inputs.previous_rates.is_some(),
            "the previous frame's rates",
        ),
        (own.ids.is_some(), inputs.ids.is_some(), "ids"),
        (own.distance.is_some(), inputs.depth.is_some(), "depth"),
        (own.particles.is_some(), inputs.flags.is_some(), "flags"),
    ];
    if let Some((_, _, name)) = needs.into_iter().find(|&(needed, had, _)| needed && !had) {
        return Err(WrongInput::Missing(name));
    }
    if let (true, Some(effect)) = (settings.is_by_tiles(), settings.first_by_pixel()) {
        return Err(WrongInput::ByTiles(effect));
    }
    match settings.first_of_content() {
        Some(effect) if settings.is_by_motion_alone() => Err(WrongInput::MotionAlone(effect)),
        _ => Ok(()),
    }
}

/// The motion of a scene that has no vectors: its cameras', but for what does not move with the world.
fn camera_vectors(inputs: &Inputs, settings: &Settings) -> Option<Vec<[f32; 2]>> {
    let (None, Some(cameras), Some(depth), Some(_)) =
        (inputs.motion, inputs.cameras, inputs.depth, settings.motion)
    else {
        return None;
    };
    let mut vectors =
        super::reproject::camera_motions(inputs.size, depth, &cameras.now, &cameras.before);
    for (vector, mark) in vectors.iter_mut().zip(inputs.flags.unwrap_or_default()) {
        if mark & flags::STATIC != 0 {
            *vector = [0.0; 2];
        }
    }
    Some(vectors)
}

/// Runs the stage. The inputs have been [checked](check).
pub(super) fn run(
    numbers: &Integers,
    inputs: &Inputs,
    settings: &Settings,
    params: &Params,
) -> Output {
    let vectors = camera_vectors(inputs, settings);
    let inputs = &Inputs {
        motion: inputs.motion.or(vectors.as_deref()),
        ..*inputs
    };
    let [width, height] = inputs.size;
    let layout = SriLayout::new(width, height);
    let sources: Vec<Result<u32, NoSource>> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| source(x, y, inputs, settings, params))
        .collect();
    let content = &settings.content;
    let speeds = motion::table(
        settings.motion.map(|motion| motion.blur),
        content.threshold,
        content.k,
    );
    let stage = Stage {
        numbers,
        inputs,
        settings,
        params,
        sources: &sources,
        speeds,
        optics: Optics::new(settings, &inputs.frame()),
    };
    let mut quads = decided(&stage, settings.granularity_of_rates());
    // the attachment's may be of other areas
    let of_attachment = settings.granularity_of_attachment();
    if of_attachment != settings.granularity_of_rates() {
        let others = decided(&stage, of_attachment);
        for (quad, other) in quads.iter_mut().zip(others) {
            quad.attachment = other.attachment;
            quad.attachment_error = other.attachment_error;
        }
    }
    agree_in_blocks(&mut quads, layout, settings.largest);
    let image = |of: fn(&Quad) -> Logs| {
        Sri::from_fn(width, height, |x, y| {
            code(of(&quads[(y * layout.width + x) as usize]))
        })
    };
    let mut reasons = vec![0; layout.bytes() as usize];
    for (index, quad) in quads.iter().enumerate() {
        let (x, y) = (index as u32 % layout.width, index as u32 / layout.width);
        reasons[(y * layout.pitch + x) as usize] = quad.reason as u8;
    }
    let side = settings.granularity_of_rates();
    let smoothed = |rates: &Sri, side| smooth(rates, inputs.size, settings.smoothing, side);
    let sri = smoothed(&image(|q| q.rate), side);
    if settings.smoothing != Smoothing::None {
        for (at, reason) in reasons.iter_mut().enumerate() {
            let (x, y) = (at as u32 % layout.pitch, at as u32 / layout.pitch);
            if x < layout.width
                && sri.code(x, y) != code(quads[(y * layout.width + x) as usize].rate)
            {
                *reason = Reason::Neighbour as u8;
            }
        }
    }
    // a stage by tiles looks at no flags itself
    let by_tiles = settings.is_by_tiles().then(super::OwnRates::default);
    let own = settings.own.clone().or(by_tiles);
    let sri = match &own {
        Some(own) => super::own::combine(&sri, own, settings.largest, inputs, &mut reasons),
        None => sri,
    };
    let plain = smoothed(&image(|q| q.plain), side);
    let plain = match &own {
        Some(own) => super::own::combine(&plain, own, settings.largest, inputs, &mut []),
        None => plain,
    };
    let half = settings
        .half_resolution
        .map(|kind| super::half::half(&sri, inputs.size, kind));
    let [pw, ph] = inputs.previous_size;
    let pitch = params::luma_pitch(pw);
    let mut sqrt_luma = vec![0; (pitch * ph) as usize];
    for y in 0..ph {
        for x in 0..pw {
            sqrt_luma[(y * pitch + x) as usize] = numbers.sqrt_luma((y * pw + x) as usize);
        }
    }
    Output {
        sri,
        plain,
        half,
        attachment: smoothed(&image(|q| q.attachment), of_attachment),
        sqrt_luma,
        reasons,
    }
}

/// Every quad, each with what its area got.
fn decided(stage: &Stage, granularity: Granularity) -> Vec<Quad> {
    let [width, height] = stage.inputs.size;
    let layout = SriLayout::new(width, height);
    let mut quads = vec![Quad::full(Reason::NoHistory); (layout.width * layout.height) as usize];
    if !stage.inputs.has_history {
        return quads;
    }
    if granularity == Granularity::Quad {
        for (index, quad) in quads.iter_mut().enumerate() {
            *quad = stage.quad([index as u32 % layout.width, index as u32 / layout.width]);
        }
        return quads;
    }
    let side = granularity.side();
    let data = stage
        .settings
        .is_by_tiles()
        .then(|| super::tiles::data(stage));
    for tile in
        (0..height.div_ceil(side)).flat_map(|y| (0..width.div_ceil(side)).map(move |x| [x, y]))
    {
        let found = match &data {
            Some(data) => super::tiles::rate(stage, data, tile),
            None => stage.tile(tile, side),
        };
        let [left, top] = tile.map(|at| at * side / 2);
        for y in top..(top + side / 2).min(layout.height) {
            for x in left..(left + side / 2).min(layout.width) {
                quads[(y * layout.width + x) as usize] = found;
            }
        }
    }
    quads
}

/// Rates of 4 hold where whole blocks of four quads agree.
fn agree_in_blocks(quads: &mut [Quad], layout: SriLayout, largest: Rate) {
    for y in (0..layout.height).step_by(2) {
        for x in (0..layout.width).step_by(2) {
            let places: [Option<usize>; 4] = std::array::from_fn(|i| {
                let (qx, qy) = (x + i as u32 % 2, y + i as u32 / 2);
                (qx < layout.width && qy < layout.height).then(|| (qy * layout.width + qx) as usize)
            });
            let four = places.map(|at| at.map(|at| quads[at]));
            let of = |logs: fn(&Quad) -> Logs, error: fn(&Quad) -> [f64; 2]| {
                let errors = four.map(|quad| quad.as_ref().map_or([0.0; 2], error));
                agree(four.map(|quad| quad.as_ref().map(logs)), errors, largest)
            };
            let rates = of(|q| q.rate, |q| q.error);
            let attached = of(|q| q.attachment, |q| q.attachment_error);
            let plain = of(|q| q.plain, |q| q.error);
            for (i, at) in places.into_iter().enumerate() {
                if let Some(at) = at {
                    quads[at].rate = rates[i];
                    quads[at].attachment = attached[i];
                    quads[at].plain = plain[i];
                }
            }
        }
    }
}

/// The code of a rate given by its logs; 4x1 and 1x4 become 2x1 and 1x2.
pub(super) fn code([x, y]: Logs) -> u8 {
    Rate::from_code(x << 2 | y).map_or(x.min(1) << 2 | y.min(1), Rate::code)
}

/// Rates of 4 hold where all four quads of the aligned block have them; 4x4 keeps 4 on the axis of the smaller error
/// unless it is allowed. Quads outside the picture agree to nothing.
fn agree(four: [Option<Logs>; 4], errors: [[f64; 2]; 4], largest: Rate) -> [Logs; 4] {
    let logs = four.map(Option::unwrap_or_default);
    let mut x = logs.iter().all(|l| l[0] == 2 && l[1] >= 1);
    let mut y = logs.iter().all(|l| l[1] == 2 && l[0] >= 1);
    if x && y && largest != Rate::R4X4 {
        let sum = |axis: usize| -> f64 { errors.iter().map(|error| error[axis]).sum() };
        // the axis of the larger error is the finer (GDC; NVIDIA's sample: 2x4 where dx > dy)
        x = sum(0) <= sum(1);
        y = !x;
    }
    let cap = |log: u8, is_four: bool| if is_four { log } else { log.min(1) };
    let mut out = logs.map(|[a, b]| [cap(a, x), cap(b, y)]);
    if x && y {
        out = [[2, 2]; 4];
    }
    out
}
