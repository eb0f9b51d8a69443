//! Shapes of shaders beyond the common one, each proved on a driver: what the options choose (policies, atomics,
//! one-dimensional dispatches), odd places to store, odd ways to find them.

mod common;

use vrcs::check::{Job, Law, Verdict};
use vrcs_passes::{
    Code, Options, Source,
    options::{Atomics, Linear, MaxRate, Mode, Policy},
};

/// One of the shapes.
fn shape(name: &str) -> Source {
    let path = common::shader_path("")
        .with_file_name("../shapes")
        .join(format!("{name}.wgsl"));
    let text = std::fs::read_to_string(&path).expect("a shader of the tests");
    Source::new(path.display().to_string(), text)
}

/// A shape with another text in the place of some.
fn changed(name: &str, from: &str, to: &str) -> Source {
    let path = format!("{}/tests/shapes/{name}.wgsl", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("a shader of the tests");
    assert!(text.contains(from), "{text}");
    Source::new(format!("{name}.wgsl"), text.replace(from, to))
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
fn additions_beyond_the_end_are_no_failure() {
    hold("atomics_beyond", |job| {
        job.options.atomics = Atomics::Weight
    });
    // for every pixel, before the rest
    hold("atomics_beyond", |job| {
        job.options.targets.insert("cells".to_owned(), Policy::Full);
    });
}

#[test]
fn texels_beyond_the_picture_are_no_failure() {
    // its sides are odd, so that the last column and row are what is stored to
    hold("reads_beyond", |job| job.size = [29, 21]);
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
        options.targets.insert(left_out.to_owned(), Policy::Copy);
        let refusal = vrcs_passes::rewrite(&module, &info, "main", &options).expect_err(left_out);
        assert!(refusal.findings.iter().any(|f| f.code == code), "{refusal}");
    }
}

/// What duplicates would lose is stored for every pixel, where nothing was said of it: tiles visit them all, and are what is chosen.
#[test]
fn what_copies_cannot_serve_is_stored_for_every_pixel() {
    for mode in [Mode::Tiled, Mode::Auto] {
        hold("unasked", |job| job.options.mode = mode);
    }
    let (module, info) = common::parse(&shape("unasked"));
    let with = |mode, named: &[(&str, Policy)]| {
        let named = named.iter();
        let options = Options {
            mode,
            targets: named
                .map(|&(name, policy)| (name.to_owned(), policy))
                .collect(),
            ..Options::default()
        };
        vrcs_passes::rewrite(&module, &info, "main", &options)
    };
    let rewritten = with(Mode::Auto, &[]).expect("a rewrite");
    let [entry] = rewritten.manifest.entries.as_slice() else {
        panic!("{:?}", rewritten.manifest);
    };
    assert_eq!(entry.mode, Mode::Tiled);
    let policies: Vec<_> = entry
        .targets
        .iter()
        .map(|t| (t.name.as_str(), t.policy))
        .collect();
    let full = ["coarse", "sound", "frames", "marks"].map(|name| (name, Policy::Full));
    assert_eq!(
        policies,
        [[("color", Policy::Copy)].as_slice(), &full].concat()
    );
    for (name, _) in full {
        let told = |(_, w): &(String, vrcs_passes::Finding)| {
            w.code == Code::StoredForEveryPixel && w.message.contains(&format!("`{name}`"))
        };
        assert!(
            rewritten.warnings.iter().any(told),
            "{:?}",
            rewritten.warnings
        );
        // the author's word stands
        let refusal = with(Mode::Tiled, &[(name, Policy::Copy)]).expect_err(name);
        assert!(
            refusal.to_string().contains(&format!("`{name}`")),
            "{refusal}"
        );
    }
    let asked = full.map(|(name, policy)| (name, policy));
    let asked = with(Mode::Tiled, &asked).expect("a rewrite");
    assert!(
        asked
            .warnings
            .iter()
            .all(|(_, w)| w.code != Code::StoredForEveryPixel)
    );
    // a list does not visit every pixel
    for mode in [Mode::List, Mode::Classified] {
        let refusal = with(mode, &[]).expect_err("a refusal");
        assert!(
            refusal.findings.iter().all(|f| f.stored.is_some()),
            "{refusal}"
        );
    }
}

/// An exchange at the invocation's own place is a read of what was there and a store.
#[test]
fn what_each_pixel_takes_and_clears() {
    hold("exchange", |_| ());
}

/// An exchange whose place may be another's has its reason for a refusal, each.
#[test]
fn an_exchange_at_anothers_place_is_refused() {
    let shader = |body: &str| {
        Source::new(
            "take.wgsl",
            format!(
                "@group(0) @binding(0) var<storage, read_write> a: array<atomic<u32>>;
                @group(0) @binding(1) var picture: texture_storage_2d<r32uint, write>;
                @compute @workgroup_size(8, 8)
                fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
                    let i = id.y * 64u + id.x;
                    var sum = 0u;
                    {body}
                    textureStore(picture, id.xy, vec4(sum));
                }}"
            ),
        )
    };
    let codes = |body: &str| {
        let (module, info) = common::parse(&shader(body));
        match vrcs_passes::rewrite(&module, &info, "main", &Options::default()) {
            Ok(_) => Vec::new(),
            Err(refusal) => refusal.findings.iter().map(|f| f.code).collect(),
        }
    };
    assert_eq!(codes("sum = atomicExchange(&a[i], 0u);"), []);
    for body in [
        // a window that overlaps with the neighbour's
        "sum = atomicExchange(&a[i], 0u) + atomicExchange(&a[i + 1u], 0u);",
        "for (var k = 0u; k < 3u; k++) { sum += atomicExchange(&a[i + k], 0u); }",
        // the neighbour may have added first
        "sum = atomicExchange(&a[i], 0u); atomicMax(&a[i + 64u * 64u], 1u);",
        "sum = atomicExchange(&a[id.x], 0u);",
        "sum = atomicExchange(&a[i], 0u); atomicStore(&a[i + 1u], 3u);",
    ] {
        assert!(codes(body).contains(&Code::Atomic), "{body}");
    }
}

/// A read whose value a constant drops is no read, and a store that a constant rules out is none.
#[test]
fn a_helper_that_a_constant_sends_one_way() {
    hold("dead_read", |_| ());
    hold("dead_read", |job| job.entry = "down".to_owned());
}

/// The same helper, sent either way by a uniform, reads what others write.
#[test]
fn a_helper_that_a_uniform_sends_either_way_is_refused() {
    let (module, info) = common::parse(&changed("dead_read", "blur(true", "blur(frame.width > 9u"));
    let refusal = vrcs_passes::rewrite(&module, &info, "main", &Options::default())
        .expect_err("it reads what it writes");
    assert!(
        refusal
            .findings
            .iter()
            .any(|f| f.code == Code::ReadsOthersOutput),
        "{refusal}"
    );
}

fn follows_rate(options: &mut Options) {
    options.scale_gradients = true;
    options.bias_level.insert("blurred".to_owned());
}

/// A shader that samples nothing by gradients, and no texture by level that is named, is rewritten as ever.
#[test]
fn detail_that_is_not_there_changes_nothing() {
    let (module, info) = common::parse(&shape("whole_struct"));
    let text = |scale_gradients| {
        let options = Options {
            scale_gradients,
            ..Options::default()
        };
        let made = vrcs_passes::rewrite(&module, &info, "main", &options).expect("a rewrite");
        vrcs_passes::emit::wgsl(&made.module, &made.info).expect("text")
    };
    assert_eq!(text(true), text(false));
}

/// Samples of a primary take in what its whole block would see, and nothing else changes.
#[test]
fn detail_follows_the_rate() {
    hold("gradients", |job| follows_rate(&mut job.options));
}

/// Held against the author's own text, that is the same bit for bit at 1x1, and not where pixels share.
#[test]
fn detail_is_the_authors_own_at_full_rate() {
    let source = shape("gradients");
    let (module, info) = common::parse(&source);
    let mut options = Options::default();
    follows_rate(&mut options);
    let following = vrcs_passes::rewrite(&module, &info, "main", &options).expect("a rewrite");
    let mut job = Job::new("main");
    job.seed = common::seed();
    let gpu = common::gpu();
    let report =
        vrcs::check::check_rewritten(&gpu, &source, &module, &info, &following, &job, &mut |_| {})
            .expect("a check");
    assert_eq!(report.verdict, Verdict::Failed, "{:?}", report.why);
    assert!(report.held.contains_key(&Law::Identity), "{report:?}");
    let failure = report.failure.expect("a failure");
    assert_ne!(failure.law, Law::Identity, "{failure:?}");
}

#[test]
fn detail_does_not_follow_where_every_pixel_is_shaded() {
    let (module, info) = common::parse(&shape("gradients"));
    let mut options = Options {
        mode: vrcs_passes::options::Mode::Graded,
        ..Options::default()
    };
    follows_rate(&mut options);
    let refusal = vrcs_passes::rewrite(&module, &info, "main", &options).expect_err("no detail");
    assert_eq!(refusal.findings[0].code, Code::UnfitOption, "{refusal}");
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
