//! What the integration tests share.
#![allow(dead_code, reason = "each test uses a part")]

use std::path::{Path, PathBuf};

use vrcs::check::{Job, Law, Report, Route, Verdict, check, gpu::Gpu};
use vrcs_passes::{Source, input};

/// The device that tests run on: the one that `WGPU_ADAPTER_NAME` names, or any.
pub fn gpu() -> Gpu {
    Gpu::open(None)
        .expect("a Vulkan driver: `apt-get install mesa-vulkan-drivers` brings a software one")
}

/// A fresh seed, printed; `VRCS_SEED` gives a certain one.
pub fn seed() -> u64 {
    let seed = match std::env::var("VRCS_SEED") {
        Ok(seed) => seed.parse().expect("VRCS_SEED is a number"),
        Err(_) => {
            let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
            now.expect("a clock").as_nanos() as u64 % 1_000_000_007
        }
    };
    println!("VRCS_SEED={seed}");
    seed
}

pub fn shader_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/shaders")
        .join(format!("{name}.wgsl"))
}

/// One of the tests' shaders.
pub fn shader(name: &str) -> Source {
    let path = shader_path(name);
    let text = std::fs::read_to_string(&path).expect("a shader of the tests");
    Source::new(path.display().to_string(), text)
}

/// Parses a shader that is known to be good.
pub fn parse(source: &Source) -> (naga::Module, naga::valid::ModuleInfo) {
    input::wgsl(source).unwrap_or_else(|invalid| panic!("{}", invalid.rendered))
}

/// Checks the entry point `main` of a shader with a job.
pub fn run(source: &Source, job: &Job) -> Report {
    run_on(&gpu(), source, job)
}

/// The same on a device that is there: the builders that it has made are not made again.
pub fn run_on(gpu: &Gpu, source: &Source, job: &Job) -> Report {
    let (module, info) = parse(source);
    check(gpu, source, &module, &info, job, &mut |_| {}).unwrap_or_else(|error| panic!("{error}"))
}

/// Checks a shader with a job, and expects that every law held, each more often than `times`; then once more as a module, with
/// another picture and so many cases: the two routes give the same pixels.
pub fn hold_every_law(source: &Source, job: Job, times: u32, as_module: u32) -> Report {
    let report = run(source, &job);
    assert_passed(&report);
    for law in [
        Law::Identity,
        Law::Off,
        Law::Replication,
        Law::Locality,
        Law::Contract,
        Law::Partition,
        Law::Builder,
    ] {
        assert!(
            report.held.get(&law).is_some_and(|&held| held > times),
            "{law}: {report:?}"
        );
    }
    let job = Job {
        route: Route::Module,
        size: [40, 33],
        cases: as_module,
        ..job
    };
    assert_passed(&run(source, &job));
    report
}

/// Expects that every law held.
pub fn assert_passed(report: &Report) {
    let failure = report.failure.as_ref().map(|failure| vrcs::check::Failure {
        picture: Vec::new(),
        ..failure.clone()
    });
    assert_eq!(
        report.verdict,
        Verdict::Passed,
        "{}: {:?} {failure:#?}",
        report.entry,
        report.why
    );
}
