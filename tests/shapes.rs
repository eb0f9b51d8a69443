//! Shapes of shaders beyond the common one, each proved on a driver: what the options choose (policies, atomics,
//! one-dimensional dispatches), odd places to store, odd ways to find them.

mod common;

use vrcs::check::{Job, Law, Verdict};
use vrcs_passes::{
    Code, Options, Source,
    options::{Atomics, Linear, MaxRate, Policy},
};

/// One of the shapes.
fn shape(name: &str) -> Source {
    let path = common::shader_path("")
        .with_file_name("../shapes")
        .join(format!("{name}.wgsl"));
    let text = std::fs::read_to_string(&path).expect("a shader of the tests");
    Source::new(path.display().to_string(), text)
}

/// Checks a shape, with options and inputs as `set` chooses: rates up to 2x2, and up to 4x4.
fn hold(name: &str, set: impl Fn(&mut Job)) {
    for (max_rate, cases) in [(MaxRate::R2x2, 48), (MaxRate::R4x4, 24)] {
        let mut job = Job::new("main");
        job.seed = common::seed();
        job.cases = cases;
        job.options.max_rate = max_rate;
        set(&mut job);
        let report = common::run(&shape(name), &job);
        common::assert_passed(&report);
        for law in [
            Law::Identity,
            Law::Replication,
            Law::Contract,
            Law::Partition,
        ] {
            assert!(report.held.contains_key(&law), "{law}: {report:?}");
        }
    }
}

fn named(width: &str) -> Option<Linear> {
    Some(Linear::Named(width.to_owned()))
}

#[test]
fn a_line_of_invocations_over_a_picture() {
    hold("linear", |job| job.options.linear = named("frame.width"));
}

#[test]
fn a_line_whose_width_is_an_override_or_a_number() {
    hold("linear_override", |job| job.options.linear = named("WIDTH"));
    hold("linear_override", |job| {
        job.options.linear = Some(Linear::Pixels(61))
    });
}

#[test]
fn atomics_count_for_all_pixels() {
    hold("atomics", |job| job.options.atomics = Atomics::Weight);
}

#[test]
fn duplicates_keep_what_a_leader_does_not_store() {
    hold("leader", |job| {
        job.options
            .targets
            .insert("seeds".to_owned(), Policy::Leader);
    });
}

/// Every pixel stores what the original does to the targets that are `full`, whatever the rates; the colour follows its primary.
#[test]
fn full_targets_are_the_originals_at_every_pixel() {
    hold("full", |job| {
        for name in ["normals", "bright", "note", "history"] {
            job.options.targets.insert(name.to_owned(), Policy::Full);
        }
    });
}

/// Without the policy, each of them has its reason for a refusal.
#[test]
fn what_only_full_allows_is_refused_without_it() {
    let source = shape("full");
    let (module, info) = common::parse(&source);
    for (left_out, code) in [("bright", Code::Atomic), ("note", Code::AddressNotOneToOne)] {
        let mut options = Options::default();
        for name in ["normals", "bright", "note", "history"] {
            options.targets.insert(name.to_owned(), Policy::Full);
        }
        options.targets.remove(left_out);
        let refusal = vrcs_passes::rewrite(&module, &info, "main", &options).expect_err(left_out);
        assert!(refusal.findings.iter().any(|f| f.code == code), "{refusal}");
    }
}

#[test]
fn what_lies_between_members_is_nobodys() {
    hold("whole_struct", |_| ());
}

/// A policy that the shader does not carry out is found out: what is checked is what was asked for.
#[test]
fn a_policy_that_is_not_kept_fails() {
    let source = shape("leader");
    let (module, info) = common::parse(&source);
    let mut job = Job::new("main");
    job.seed = common::seed();
    let copied = vrcs_passes::rewrite(&module, &info, "main", &job.options).expect("a rewrite");
    job.options
        .targets
        .insert("seeds".to_owned(), Policy::Leader);
    let report = vrcs::check::check_rewritten(
        &common::gpu(),
        &source,
        &module,
        &info,
        &copied,
        &job,
        &mut |_| {},
    )
    .expect("a check");
    assert_eq!(report.verdict, Verdict::Failed, "{:?}", report.why);
}
