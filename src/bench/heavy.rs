//! Rows of a heavy pass: the rewritten shader against the author's, by share of primaries and by mode.

use vrcs_passes::{
    Options,
    options::{FullTiles, MaxRate, Mode},
};

use super::{
    BenchError, Lab, Measured, Row, own,
    stage::{self, Built, Inputs},
    timer::Contender,
};
use crate::{
    Pass, Rate,
    check::gpu::{Gpu, by_construction},
    sri::Sri,
};

const TEXT: &str = include_str!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/shaders/bench/heavy.wgsl"
));
const MODES: [Mode; 3] = [Mode::Tiled, Mode::List, Mode::Classified];
/// Shares of primaries that are tried.
const SHARES: [f64; 7] = [0.25, 0.375, 0.5, 0.625, 0.75, 0.85, 0.9];

/// The author's shader and the rewritten ones on the same inputs.
struct Heavy {
    original: stage::Original,
    groups: Vec<wgpu::BindGroup>,
    modes: Vec<(Mode, Pass, Vec<wgpu::BindGroup>)>,
    /// Which of the modes is the one that the rewriter chooses.
    chosen: usize,
}

impl Heavy {
    fn new(lab: &Lab, lights: u32, max_rate: MaxRate) -> Result<Heavy, BenchError> {
        let Lab { bench, gpu, .. } = lab;
        let inputs = Inputs::new(bench, gpu, lights);
        let original = stage::original(gpu, TEXT, "heavy");
        let groups = inputs.groups(gpu, &original.layout);
        let modes = MODES
            .into_iter()
            .map(|mode| {
                let options = Options {
                    mode,
                    max_rate,
                    ..Options::default()
                };
                let pass = stage::rewritten(gpu, TEXT, options)?;
                let groups = inputs.groups(gpu, stage::layout_of(&pass)?);
                Ok((mode, pass, groups))
            })
            .collect::<Result<Vec<_>, BenchError>>()?;
        let options = Options {
            mode: Mode::Auto,
            max_rate,
            ..Options::default()
        };
        let auto = stage::rewritten(gpu, TEXT, options)?.mode().0;
        let chosen = MODES.iter().position(|&mode| mode == auto);
        Ok(Heavy {
            original,
            groups,
            modes,
            chosen: chosen.ok_or_else(|| own("the mode that is chosen is not measured"))?,
        })
    }

    /// The author's shader first, then each mode.
    fn measure(&self, lab: &Lab, built: &Built) -> Result<Measured, BenchError> {
        let [width, height] = lab.bench.size;
        let mut contenders = vec![Contender::new("original", |pass, round| {
            pass.set_pipeline(&self.original.pipeline);
            pass.set_bind_group(0, &self.groups[round % self.groups.len()], &[]);
            pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
        })];
        for (mode, rewritten, groups) in &self.modes {
            contenders.push(Contender::new(
                format!("{mode:?}").to_lowercase(),
                move |pass, round| {
                    pass.set_bind_group(0, &groups[round % groups.len()], &[]);
                    by_construction(rewritten.dispatch(pass, built.view(round)));
                },
            ));
        }
        lab.measure(&contenders)
    }

    /// The time of the best mode over the author's, and which it is.
    fn best(&self, measured: &Measured) -> (Mode, f64) {
        let (best, time) = measured.shortest(1..1 + self.modes.len());
        (self.modes[best - 1].0, time / measured.of(0))
    }
}

/// All rates 1×1: what it costs to be able to. A row for each mode; the goal is for the one that the rewriter chooses.
pub(super) fn identity(lab: &Lab) -> Result<Vec<Row>, BenchError> {
    let mut rows = Vec::new();
    for (name, lights, goal) in [
        ("identity, heavy", lab.bench.lights, 1.01),
        ("identity, light", 4, 1.03),
    ] {
        let heavy = Heavy::new(lab, lights, MaxRate::default())?;
        let sri = |_| Sri::uniform(lab.bench.size[0], lab.bench.size[1], Rate::R1X1);
        let built = stage::built(lab, sri, Rate::R2X2, FullTiles::Promote)?;
        let measured = heavy.measure(lab, &built)?;
        for (index, mode) in MODES.iter().enumerate() {
            let value = measured.of(1 + index) / measured.of(0);
            let mode = format!("{mode:?}").to_lowercase();
            let seen = Measured {
                parts: vec![measured.parts[0].clone(), measured.parts[1 + index].clone()],
                drift: measured.drift,
            };
            let is_chosen = index == heavy.chosen;
            let chosen = if is_chosen { ", which is chosen" } else { "" };
            let row = Row::ratio(format!("{name}, {mode}{chosen}"), value, goal, seen);
            rows.push(if is_chosen { row } else { row.unjudged() });
        }
    }
    Ok(rows)
}

/// A heavy pass by its share of primaries: at most the share and a hundredth.
pub(super) fn shares(lab: &Lab) -> Result<Vec<Row>, BenchError> {
    let mut rows = Vec::new();
    let [width, height] = lab.bench.size;
    let sixteenth = Heavy::new(lab, lab.bench.lights, MaxRate::R4x4)?;
    let sri = |_| Sri::uniform(width, height, Rate::R4X4);
    let built = stage::built(lab, sri, Rate::R4X4, FullTiles::Keep)?;
    rows.push(share_row(lab, "heavy", &sixteenth, &built, 0.01)?);
    drop(sixteenth);
    let heavy = Heavy::new(lab, lab.bench.lights, MaxRate::default())?;
    rows.extend(by_share(lab, "heavy", &heavy, 0.01)?);
    Ok(rows)
}

/// A pass of 0.2 ms, which launches and payload weigh upon.
fn light(lab: &Lab) -> Result<Heavy, BenchError> {
    let [width, height] = lab.bench.size;
    let sri = |_| Sri::uniform(width, height, Rate::R1X1);
    let built = stage::built(lab, sri, Rate::R2X2, FullTiles::Promote)?;
    let probe = Heavy::new(lab, lab.bench.lights, MaxRate::default())?;
    let measured = probe.measure(lab, &built)?;
    drop(probe);
    let lights = (f64::from(lab.bench.lights) * 0.2 / measured.of(0)).round() as u32;
    Heavy::new(lab, lights.clamp(1, lab.bench.lights), MaxRate::default())
}

/// The same for a pass of 0.2 ms.
pub(super) fn light_shares(lab: &Lab) -> Result<Vec<Row>, BenchError> {
    by_share(lab, "light, 0.2 ms", &light(lab)?, 0.03)
}

fn by_share(lab: &Lab, name: &str, heavy: &Heavy, slack: f64) -> Result<Vec<Row>, BenchError> {
    SHARES
        .into_iter()
        .map(|share| {
            let sri = |seed| stage::random(lab.bench.size, share, seed);
            let built = stage::built(lab, sri, Rate::R2X2, FullTiles::Keep)?;
            share_row(lab, name, heavy, &built, slack)
        })
        .collect()
}

fn share_row(
    lab: &Lab,
    name: &str,
    heavy: &Heavy,
    built: &Built,
    slack: f64,
) -> Result<Row, BenchError> {
    let measured = heavy.measure(lab, built)?;
    let (mode, value) = heavy.best(&measured);
    let mode = format!("{mode:?}").to_lowercase();
    let name = format!("{name}, {:.1} % primary, {mode}", 100.0 * built.primaries);
    Ok(Row::ratio(name, value, built.primaries + slack, measured))
}

/// Classified against the better of the other two, over rates of every kind: of the heavy pass, and of one of 0.2 ms.
pub(super) fn classified(lab: &Lab) -> Result<Vec<Row>, BenchError> {
    let [width, height] = lab.bench.size;
    let chessboard = |_| {
        Sri::from_fn(width, height, |x, y| match (x / 8 + y / 8) % 2 {
            0 => Rate::R2X2.code(),
            _ => Rate::R1X1.code(),
        })
    };
    type Rates<'r> = Box<dyn Fn(u64) -> Sri + 'r>;
    let kinds: [(&str, Rates); 5] = [
        (
            "random",
            Box::new(|seed| stage::random(lab.bench.size, 0.625, seed)),
        ),
        (
            "natural",
            Box::new(|seed| stage::natural(lab.bench.size, seed)),
        ),
        (
            "all 2x2",
            Box::new(|_| Sri::uniform(width, height, Rate::R2X2)),
        ),
        (
            "all 1x1",
            Box::new(|_| Sri::uniform(width, height, Rate::R1X1)),
        ),
        ("tiles like a chessboard", Box::new(chessboard)),
    ];
    let passes = [
        (
            "classified",
            Heavy::new(lab, lab.bench.lights, MaxRate::default())?,
        ),
        ("classified, 0.2 ms", light(lab)?),
    ];
    let mut rows = Vec::new();
    for (kind, rates) in kinds {
        let built = stage::built(lab, rates, Rate::R2X2, FullTiles::Promote)?;
        for (name, heavy) in &passes {
            let measured = heavy.measure(lab, &built)?;
            let (_, better) = measured.shortest(1..3);
            let value = measured.of(3) / better;
            rows.push(Row::ratio(format!("{name}, {kind}"), value, 1.02, measured));
        }
    }
    Ok(rows)
}

/// What wgpu's validation of an indirect dispatch's arguments costs, which this program turns off and an application has to ask to be
/// without: the same list on a second device that validates.
pub(super) fn validation(lab: &Lab) -> Result<Vec<Row>, BenchError> {
    let other = Gpu::open_validating(Some(&lab.gpu.info.name))?;
    let second = Lab::new(lab.bench, &other)?;
    let took = |lab: &Lab| -> Result<Measured, BenchError> {
        let heavy = Heavy::new(lab, 4, MaxRate::default())?;
        let sri = |seed| stage::random(lab.bench.size, 0.25, seed);
        let built = stage::built(lab, sri, Rate::R2X2, FullTiles::Keep)?;
        heavy.measure(lab, &built)
    };
    let (without, with) = (took(lab)?, took(&second)?);
    let list = 1 + MODES
        .iter()
        .position(|&mode| mode == Mode::List)
        .unwrap_or_default();
    let part = |measured: &Measured, name: &str| super::Part {
        name: name.to_owned(),
        ..measured.parts[list].clone()
    };
    let value = 1e3 * (with.of(list) - without.of(list));
    let measured = Measured {
        parts: vec![part(&without, "list"), part(&with, "list, validated")],
        drift: with.drift,
    };
    let name = "indirect arguments validated by wgpu, for each dispatch";
    Ok(vec![Row::microseconds(name, value, 10.0, measured)])
}
