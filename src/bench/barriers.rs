//! Rows of a shader with barriers: a loop over batches of lights, split into regions and masked.

use vrcs_passes::{
    Options,
    options::{Barriers, FullTiles, Mode},
};

use super::{
    BenchError, Lab, Row,
    stage::{self, Inputs},
    timer::Contender,
};
use crate::{Rate, check::gpu::by_construction};

const TEXT: &str = include_str!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/shaders/bench/batches.wgsl"
));

/// The time over the author's, at most the share of subgroups that stay and 0.05; beside it the masked form, which retires none.
pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, BenchError> {
    let Lab { bench, gpu, .. } = lab;
    let [width, height] = bench.size;
    let inputs = Inputs::new(bench, gpu, bench.lights.next_multiple_of(64));
    let original = stage::original(gpu, TEXT, "batches");
    let groups = inputs.groups(gpu, &original.layout);
    let form = |barriers| -> Result<_, BenchError> {
        let options = Options {
            mode: Mode::Tiled,
            barriers,
            ..Options::default()
        };
        let pass = stage::rewritten(gpu, TEXT, options)?;
        let groups = inputs.groups(gpu, stage::layout_of(&pass)?);
        Ok((pass, groups))
    };
    let split = form(Barriers::Split)?;
    let masked = form(Barriers::Mask)?;
    let mut rows = Vec::new();
    for share in [0.25, 0.5, 0.75] {
        let sri = |seed| stage::random(bench.size, share, seed);
        let built = stage::built(lab, sri, Rate::R2X2, FullTiles::Promote)?;
        let contenders = [
            Contender::new("original", |pass, round| {
                pass.set_pipeline(&original.pipeline);
                pass.set_bind_group(0, &groups[round % groups.len()], &[]);
                pass.dispatch_workgroups(width.div_ceil(16), height.div_ceil(16), 1);
            }),
            Contender::new("split", |pass, round| {
                pass.set_bind_group(0, &split.1[round % split.1.len()], &[]);
                by_construction(split.0.dispatch(pass, built.view(round)));
            }),
            Contender::new("masked", |pass, round| {
                pass.set_bind_group(0, &masked.1[round % masked.1.len()], &[]);
                by_construction(masked.0.dispatch(pass, built.view(round)));
            }),
        ];
        let measured = lab.measure(&contenders)?;
        let name = format!(
            "barriers, {:.0} % primary, {:.1} % of the subgroups stay",
            100.0 * built.primaries,
            100.0 * built.waves
        );
        let value = measured.of(1) / measured.of(0);
        rows.push(Row::ratio(name, value, built.waves + 0.05, measured));
    }
    Ok(rows)
}
