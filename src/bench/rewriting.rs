//! The row of the rewriter itself, on one core: no more than naga's own parse and validation of the same shader.

use std::time::Instant;

use naga::valid::{Capabilities, ValidationFlags, Validator};
use vrcs_passes::{Entries, Options, rewrite};

use super::{BenchError, Lab, Part, Row, Times, own, timer::Measured};

const TEXT: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/plaza.wgsl"));

/// The rewrite of a shader of some 250 lines.
pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, BenchError> {
    let validate = |module: &naga::Module| {
        Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(module)
            .map_err(own)
    };
    let module = naga::front::wgsl::parse_str(TEXT).map_err(own)?;
    let info = validate(&module)?;
    let mut samples = [Vec::new(), Vec::new()];
    // the first rounds warm caches, and the prelude is parsed once for good
    for round in 0..5 + lab.bench.rounds {
        let start = Instant::now();
        let parsed = naga::front::wgsl::parse_str(TEXT).map_err(own)?;
        validate(&parsed)?;
        let of_naga = start.elapsed();
        let start = Instant::now();
        rewrite(&module, &info, Entries::Named("plaza"), &Options::default()).map_err(own)?;
        let of_ours = start.elapsed();
        if round >= 5 {
            samples[0].push(of_naga.as_secs_f64() * 1e3);
            samples[1].push(of_ours.as_secs_f64() * 1e3);
        }
    }
    let [naga, ours] = samples.map(Times::of);
    let measured = Measured {
        parts: vec![Part::new("naga", naga), Part::new("rewrite", ours)],
        drift: None,
    };
    Ok(vec![Row::ratio(
        "rewrite, against naga's parse and validation",
        ours.median / naga.median,
        1.0,
        measured,
    )])
}
