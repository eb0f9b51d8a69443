//! Rows of a shader with barriers: a loop over batches of lights, split into regions and masked.

use vrcs_passes::{
    Options,
    options::{Barriers, FullTiles, Mode},
};

use super::{
    BenchError, Lab, Row, own,
    stage::{self, Inputs},
    timer::Contender,
};
use crate::{Rate, check::gpu::by_construction};

const TEXT: &str = include_str!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/shaders/bench/batches.wgsl"
));

/// The author's shader with one light looked at instead of a batch: what its invocations do together, and little else.
const ONE_LIGHT: [&str; 2] = [
    "var i = 0u; i < 64u; i++",
    "var i = lane & 63u; i == (lane & 63u); i++",
];

/// The time of the per-pixel part over that of the author's, at most the share of subgroups that stay and 0.05: the whole, less what the
/// cooperative part alone takes, which every subgroup has to do. Beside it the masked form, which retires none.
pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, BenchError> {
    let Lab { bench, gpu, .. } = lab;
    let [width, height] = bench.size;
    let inputs = Inputs::new(bench, gpu, bench.lights.next_multiple_of(64));
    let original = stage::original(gpu, TEXT, "batches");
    let groups = inputs.groups(gpu, &original.layout);
    let [all, one] = ONE_LIGHT;
    let together = TEXT.replace(all, one);
    if together == TEXT {
        return Err(own("the shader's loop over lights is another"));
    }
    let cooperative = stage::original(gpu, &together, "batches");
    let cooperative_groups = inputs.groups(gpu, &cooperative.layout);
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
            Contender::new("cooperative part", |pass, round| {
                let group = &cooperative_groups[round % cooperative_groups.len()];
                pass.set_pipeline(&cooperative.pipeline);
                pass.set_bind_group(0, group, &[]);
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
        let what = format!(
            "{:.0} % primary, {:.1} % of the subgroups stay",
            100.0 * built.primaries,
            100.0 * built.waves
        );
        let [original, cooperative, split] = [0, 1, 2].map(|index| measured.of(index));
        let whole = Row::ratio(
            format!("barriers, the whole, {what}"),
            split / original,
            built.waves + 0.05,
            measured.clone(),
        );
        rows.push(whole.unjudged());
        let value = (split - cooperative) / (original - cooperative);
        let name = format!("barriers, the per-pixel part, {what}");
        rows.push(Row::ratio(name, value, built.waves + 0.05, measured));
    }
    Ok(rows)
}
