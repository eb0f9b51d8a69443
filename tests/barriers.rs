//! Shaders whose invocations work together: the laws of the contract hold for them bit for bit, and the work for a pixel is
//! saved where its pixel is a duplicate.

mod common;

use vrcs::check::{Job, Report};
use vrcs_passes::Source;

fn shader(name: &str) -> Source {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/barrier_shaders")
        .join(format!("{name}.wgsl"));
    let text = std::fs::read_to_string(&path).expect("a shader of the tests");
    Source::new(path.display().to_string(), text)
}

/// How many shading-rate images are tried; `VRCS_CASES` asks for more.
fn cases() -> u32 {
    let cases = std::env::var("VRCS_CASES").ok();
    cases.map_or(24, |cases| cases.parse().expect("VRCS_CASES is a number"))
}

fn hold(name: &str) -> Report {
    let source = shader(name);
    let mut job = Job::new("main");
    job.seed = common::seed();
    job.cases = cases();
    common::hold_every_law(&source, job, 0, 8)
}

macro_rules! laws {
    ($($name:ident)+) => {
        $(
            #[test]
            fn $name() {
                hold(stringify!($name));
            }
        )+
    };
}

laws! {
    bilateral
    blur_apron
    blur_separable
    handed_on
    light_batches
    occlusion
    override_size
    own_stack
    tiled_deferred
}
