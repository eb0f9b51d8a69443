//! Rows of a heavy pass: the rewritten shader against the author's, by share of primaries and by mode.

use vrcs_passes::{
    Options,
    options::{FullTiles, MaxRate, Mode},
};

use super::{
    Bench, BenchError, Part, Row, Times, parts,
    stage::{self, Built, Inputs},
    timer::{Contender, measure},
};
use crate::{Pass, Rate, check::gpu::Gpu, sri::Sri};

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
}

impl Heavy {
    fn new(bench: &Bench, gpu: &Gpu, lights: u32, max_rate: MaxRate) -> Result<Heavy, BenchError> {
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
        Ok(Heavy {
            original,
            groups,
            modes,
        })
    }

    /// The author's shader first, then each mode.
    fn times(
        &self,
        bench: &Bench,
        gpu: &Gpu,
        built: &Built,
    ) -> Result<(Vec<Times>, Vec<Part>), BenchError> {
        let [width, height] = bench.size;
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
                    rewritten.dispatch(pass, &built.view);
                },
            ));
        }
        let times = measure(gpu, bench.rounds, &contenders)?;
        let parts = parts(&contenders, &times);
        Ok((times, parts))
    }

    /// The time of the best mode over the author's.
    fn best(times: &[Times]) -> f64 {
        let modes = times[1..].iter().map(|times| times.median);
        modes.fold(f64::INFINITY, f64::min) / times[0].median
    }
}

/// All rates 1×1: what it costs to be able to.
pub(super) fn identity(bench: &Bench, gpu: &Gpu) -> Result<Vec<Row>, BenchError> {
    let mut rows = Vec::new();
    for (name, lights, goal) in [
        ("identity, heavy", bench.lights, 1.01),
        ("identity, light", 4, 1.03),
    ] {
        let heavy = Heavy::new(bench, gpu, lights, MaxRate::default())?;
        let sri = Sri::uniform(bench.size[0], bench.size[1], Rate::R1X1);
        let built = stage::built(gpu, &sri, bench.size, Rate::R2X2, FullTiles::Promote)?;
        let (times, parts) = heavy.times(bench, gpu, &built)?;
        rows.push(Row::ratio(name, Heavy::best(&times), goal, parts));
    }
    Ok(rows)
}

/// A heavy pass by its share of primaries: at most the share and a hundredth.
pub(super) fn shares(bench: &Bench, gpu: &Gpu) -> Result<Vec<Row>, BenchError> {
    let mut rows = Vec::new();
    let sixteenth = Heavy::new(bench, gpu, bench.lights, MaxRate::R4x4)?;
    let sri = Sri::uniform(bench.size[0], bench.size[1], Rate::R4X4);
    let built = stage::built(gpu, &sri, bench.size, Rate::R4X4, FullTiles::Keep)?;
    rows.push(share_row(bench, gpu, "heavy", &sixteenth, &built, 0.01)?);
    drop(sixteenth);
    let heavy = Heavy::new(bench, gpu, bench.lights, MaxRate::default())?;
    rows.extend(by_share(bench, gpu, "heavy", &heavy, 0.01)?);
    Ok(rows)
}

/// The same for a pass of 0.2 ms, which launches and payload weigh upon.
pub(super) fn light_shares(bench: &Bench, gpu: &Gpu) -> Result<Vec<Row>, BenchError> {
    let sri = Sri::uniform(bench.size[0], bench.size[1], Rate::R1X1);
    let built = stage::built(gpu, &sri, bench.size, Rate::R2X2, FullTiles::Promote)?;
    let probe = Heavy::new(bench, gpu, bench.lights, MaxRate::default())?;
    let (times, _) = probe.times(bench, gpu, &built)?;
    drop(probe);
    let lights = (f64::from(bench.lights) * 0.2 / times[0].median).round() as u32;
    let heavy = Heavy::new(
        bench,
        gpu,
        lights.clamp(1, bench.lights),
        MaxRate::default(),
    )?;
    by_share(bench, gpu, "light, 0.2 ms", &heavy, 0.03)
}

fn by_share(
    bench: &Bench,
    gpu: &Gpu,
    name: &str,
    heavy: &Heavy,
    slack: f64,
) -> Result<Vec<Row>, BenchError> {
    SHARES
        .into_iter()
        .map(|share| {
            let sri = stage::random(bench.size, share);
            let built = stage::built(gpu, &sri, bench.size, Rate::R2X2, FullTiles::Keep)?;
            share_row(bench, gpu, name, heavy, &built, slack)
        })
        .collect()
}

fn share_row(
    bench: &Bench,
    gpu: &Gpu,
    name: &str,
    heavy: &Heavy,
    built: &Built,
    slack: f64,
) -> Result<Row, BenchError> {
    let (times, parts) = heavy.times(bench, gpu, built)?;
    let name = format!("{name}, {:.1} % primary", 100.0 * built.primaries);
    let goal = built.primaries + slack;
    Ok(Row::ratio(name, Heavy::best(&times), goal, parts))
}

/// Classified against the better of the other two, over rates of every kind.
pub(super) fn classified(bench: &Bench, gpu: &Gpu) -> Result<Vec<Row>, BenchError> {
    let heavy = Heavy::new(bench, gpu, bench.lights, MaxRate::default())?;
    let [width, height] = bench.size;
    let checkered = Sri::from_fn(width, height, |x, y| match (x / 8 + y / 8) % 2 {
        0 => Rate::R2X2.code(),
        _ => Rate::R1X1.code(),
    });
    let kinds = [
        ("random", stage::random(bench.size, 0.625)),
        ("natural", stage::natural(bench.size)),
        ("all 2x2", Sri::uniform(width, height, Rate::R2X2)),
        ("all 1x1", Sri::uniform(width, height, Rate::R1X1)),
        ("tiles like a chessboard", checkered),
    ];
    let mut rows = Vec::new();
    for (kind, sri) in kinds {
        let built = stage::built(gpu, &sri, bench.size, Rate::R2X2, FullTiles::Promote)?;
        let (times, parts) = heavy.times(bench, gpu, &built)?;
        let better = times[1].median.min(times[2].median);
        let name = format!("classified, {kind}");
        rows.push(Row::ratio(name, times[3].median / better, 1.02, parts));
    }
    Ok(rows)
}
