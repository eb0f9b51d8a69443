//! Subgroups retire in shaders whose invocations work together: as many as the shading rates promise, counted by atomics in
//! an instrumented build; and none where the work is masked.

mod common;

use vrcs::check::{
    Job,
    gpu::Gpu,
    retired::{Counted, count, subgroup_size},
};
use vrcs_passes::{
    Source,
    instrument::subgroups::WorkKind,
    options::{Barriers, FullTiles},
};

fn shader(name: &str) -> Source {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/barrier_shaders")
        .join(format!("{name}.wgsl"));
    let text = std::fs::read_to_string(&path).expect("a shader of the tests");
    Source::new(path.display().to_string(), text)
}

/// A picture of whole tiles for every shader here.
fn job(seed: u64, barriers: Barriers, wave: u32) -> Job {
    let mut job = Job::new("main");
    job.seed = seed;
    job.size = [64, 48];
    job.cases = 13;
    job.options.barriers = barriers;
    job.options.wave = wave;
    job
}

fn counted(gpu: &Gpu, name: &str, job: &Job) -> Vec<Counted> {
    let mut job = job.clone();
    if name == "occlusion" {
        // everything is a surface: a tile of sky is stored by another statement, and then no single one counts all subgroups
        job.settings.set.insert("far".to_owned(), vec![1e9]);
    }
    count(gpu, &shader(name), &job).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The share of what came by that worked.
fn working(counted: &[Counted], kind: WorkKind) -> (u64, u64) {
    let works = || {
        counted
            .iter()
            .flat_map(|c| &c.works)
            .filter(|w| w.kind == kind)
    };
    (
        works().map(|w| w.went_in).sum(),
        works().map(|w| w.came).sum(),
    )
}

#[test]
fn as_many_retire_as_the_shading_rates_promise() {
    let gpu = common::gpu();
    let Some(size) = subgroup_size(&gpu) else {
        println!("skipped: no subgroups of one size on {}", gpu.info.name);
        return;
    };
    let seed = common::seed();
    println!("{}, subgroups of {size}", gpu.info.name);
    println!(
        "| shader | rates | primaries | launched | retire, predicted | retire, counted | masked: retire |"
    );
    println!("|---|---|---|---|---|---|---|");
    for name in [
        "light_batches",
        "tiled_deferred",
        "blur_apron",
        "bilateral",
        "occlusion",
        "blur_separable",
    ] {
        let split = counted(&gpu, name, &job(seed, Barriers::Split, size.min(32)));
        let masked = counted(&gpu, name, &job(seed, Barriers::Mask, size.min(32)));
        let mut retired = 0;
        for (split, masked) in split.iter().zip(&masked) {
            assert_eq!(split.predicted, masked.predicted, "{name}: the same rates");
            assert!(!split.works.is_empty(), "{name}: nothing was counted");
            for work in &split.works {
                assert!(
                    split.holds(work),
                    "{name}, {}: {work:?} {:?}",
                    split.pattern,
                    split.predicted
                );
            }
            let regions = split.works.iter().filter(|w| w.kind == WorkKind::Region);
            let busy: Vec<u64> = regions
                .filter_map(|work| Some(work.went_in / split.turns(work).filter(|&n| n > 0)?))
                .collect();
            // a shader whose tiles are all empty is never come by
            let counted = busy.first().copied().unwrap_or(0);
            assert!(busy.iter().all(|&n| n == counted), "{name}: {split:?}");
            assert_eq!(counted, split.predicted.busy, "{name}: {split:?}");
            // masked, every subgroup of a workgroup that has a primary does the work
            let stores = || {
                masked
                    .works
                    .iter()
                    .filter(|w| w.kind == WorkKind::MaskedStore)
            };
            assert!(stores().count() > 0, "{name}: nothing is masked");
            let came = stores().map(|work| work.came).max().unwrap_or(0);
            assert_eq!(came, masked.predicted.started, "{name}: {masked:?}");
            retired += split.predicted.retired();
            println!(
                "| {name} | {} | {:.3} | {} | {} | {} | {} |",
                split.pattern,
                split.primaries,
                split.predicted.launched,
                split.predicted.retired(),
                split.predicted.launched - counted,
                split.predicted.launched - came,
            );
        }
        assert!(retired > 0, "{name}: nothing retires with any of the rates");
        // a tile of one subgroup is either empty or busy
        if split.iter().any(|c| c.predicted.busy < c.predicted.started) {
            let (worked, came) = working(&split, WorkKind::Region);
            assert!(worked < came, "{name}: {worked} of {came}");
        }
    }
}

/// With nothing coarse nobody retires, and nobody is counted twice.
#[test]
fn nothing_coarse_retires_nobody() {
    let gpu = common::gpu();
    let Some(size) = subgroup_size(&gpu) else {
        return;
    };
    let mut job = job(common::seed(), Barriers::Split, size.min(32));
    job.cases = 1;
    job.options.full_tiles = FullTiles::Keep;
    let all = counted(&gpu, "tiled_deferred", &job);
    let launched = 64 * 48 / u64::from(size);
    assert_eq!(all[0].predicted.busy, launched);
    for work in &all[0].works {
        assert_eq!((work.came, work.went_in), (launched, launched));
    }
}
