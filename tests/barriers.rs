//! Shaders whose invocations work together: the laws of the contract hold for them bit for bit, and the work for a pixel is
//! saved where its pixel is a duplicate.

mod common;

use vrcs::{
    Pass, PassError, PassOptions, Rate, View, ViewError,
    build::BuildOptions,
    check::{Job, Report},
};
use vrcs_passes::{Code, Entries, Options, Source, explain::explain, options::MaxRate, rewrite};

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
    cases.map_or(16, |cases| cases.parse().expect("VRCS_CASES is a number"))
}

fn hold(name: &str) -> Report {
    let source = shader(name);
    let mut job = Job::new("main");
    job.seed = common::seed();
    job.cases = cases();
    common::hold_every_law(&source, job, 0, 8)
}

/// Whether a shader that lavapipe takes minutes to compile is left to the other driver: its compiler makes a coroutine of what has
/// barriers, and splits it anew at each.
fn is_left_to_another_driver(name: &str) -> bool {
    let info = common::gpu().info;
    let is_slow = info.name.contains("llvmpipe");
    if is_slow {
        println!("skipped: {name} on {}: it compiles for minutes", info.name);
    }
    is_slow
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

macro_rules! laws_but_on_lavapipe {
    ($($name:ident)+) => {
        $(
            #[test]
            fn $name() {
                if !is_left_to_another_driver(stringify!($name)) {
                    hold(stringify!($name));
                }
            }
        )+
    };
}

laws! {
    batches_until
    bilateral
    blur_apron
    blur_separable
    column_sum
    dof_tile
    fft_row
    gtao_edges
    handed_on
    helper_barriers
    light_batches
    light_list
    list_ranges
    live_values
    masked_region
    nested_cascades
    nested_loops
    occlusion
    other_barriers
    override_lengths
    override_size
    override_tile
    own_stack
    ping_pong
    prefix_sum
    private_seed
    private_taps
    reflections
    shadow_mask
    sides_12_2
    sides_15_9
    sides_5_4
    sides_6_10
    switched_barriers
    tiled_deferred
    uniform_guard
    uniform_load
    whole_group_leaves
    wide_blur
}

laws_but_on_lavapipe! {
    batches_continue
    bilateral_two
    deferred_bounds
    helper_reduce
    histogram
    matrix_product
    one_arm
    taa_tile
}

/// The same for rates that are 4 wide or 4 high, where the tile has room for them: on tiles of 64 by 1 they are 2 wide at most.
#[test]
fn larger_rates() {
    for name in ["wide_blur", "sides_12_2", "sides_6_10", "light_batches"] {
        let mut job = Job::new("main");
        job.seed = common::seed();
        job.cases = cases().min(12);
        job.options.max_rate = MaxRate::R4x4;
        // tiles of a few pixels are never promoted
        job.options.wave = 4;
        common::assert_passed(&common::run(&shader(name), &job));
    }
}

/// What the author sums up in registers stays there: invocations that are not under way together cannot disturb one another's workgroup
/// memory, so nothing of it has to be handed on.
#[test]
fn what_a_barrier_keeps_apart_is_not_exchanged() {
    for name in ["batches_until", "one_arm", "light_batches"] {
        let (module, info) = common::parse(&shader(name));
        let rewritten = rewrite(&module, &info, Entries::PerPixel, &Options::default())
            .unwrap_or_else(|refusal| panic!("{name}: {refusal:?}"));
        let warnings: Vec<_> = rewritten.warnings.iter().map(|(_, w)| &w.message).collect();
        assert!(warnings.is_empty(), "{name}: {warnings:?}");
    }
    // the test can fail: a value that only its invocation knows
    let (module, info) = common::parse(&shader("handed_on"));
    let rewritten =
        rewrite(&module, &info, Entries::PerPixel, &Options::default()).expect("a rewrite");
    assert!(!rewritten.warnings.is_empty());
}

/// How a shader was taken apart is told: its regions, what is handed on, the memory that this takes; and of a region that is masked, the line.
#[test]
fn how_a_shader_was_taken_apart_is_told() {
    let told = |name: &str| {
        let source = shader(name);
        let (module, info) = common::parse(&source);
        explain(&module, &info, &source, Some("main"), &Options::default()).swap_remove(0)
    };
    let group = |name: &str| told(name).group.expect("a group");
    let batches = group("light_batches");
    assert_eq!((batches.masked, batches.added_memory), (0, 0));
    assert!(batches.per_pixel > 0 && batches.per_pixel < batches.regions);
    assert_eq!(batches.exchanged, <[&str; 0]>::default());
    let handed = group("handed_on");
    assert_eq!(handed.exchanged, ["mine", "odd", "seen"]);
    // a word of each of 64 invocations, three times
    assert_eq!(handed.added_memory, 3 * 64 * 4);
    let masked = told("masked_region");
    assert_eq!(masked.group.as_ref().map(|group| group.masked), Some(1));
    let warning = masked
        .findings
        .iter()
        .find(|found| found.code == Code::MaskedRegion.to_string());
    let place = &warning.expect("a warning").places[0];
    let text = shader("masked_region").text().to_owned();
    let line = text.lines().position(|line| line.contains("textureStore"));
    assert_eq!(Some(place.line), line.map(|line| line + 1));
}

/// What a shader takes of workgroup memory, exchanges included, is held against the device's, and refused with the sizes.
#[test]
fn more_workgroup_memory_than_the_device_has_is_refused_with_the_sizes() {
    let (module, info) = common::parse(&shader("handed_on"));
    let with = |most: u32| {
        let options = Options {
            max_workgroup_memory: most,
            ..Options::default()
        };
        rewrite(&module, &info, Entries::PerPixel, &options)
    };
    let rewritten = with(16_384).expect("room for it");
    let group = rewritten.manifest.entries[0]
        .group
        .clone()
        .expect("a group");
    let sum = group.author_memory + group.added_memory;
    with(sum).expect("exactly as much as it needs");
    let refusal = with(sum - 1).expect_err("too little").to_string();
    for size in [sum, sum - 1, group.author_memory, group.added_memory] {
        assert!(refusal.contains(&size.to_string()), "{size}: {refusal}");
    }
}

/// The sides of a workgroup that overrides decide: the tile follows them.
#[test]
fn override_sizes() {
    for [width, height] in [[16, 16], [8, 4], [32, 1], [64, 1]] {
        for name in ["override_size", "override_lengths"] {
            let mut job = Job::new("main");
            job.seed = common::seed();
            job.cases = cases().min(8);
            job.settings.set = [("WIDTH", width), ("HEIGHT", height)]
                .map(|(name, side)| (name.to_owned(), vec![f64::from(side)]))
                .into();
            common::assert_passed(&common::run(&shader(name), &job));
        }
    }
}

/// A workgroup that has to be a tile, and is larger than one can be by the values of its overrides, is refused.
#[test]
fn a_workgroup_larger_than_a_tile_is_refused() {
    let gpu = common::gpu();
    let make = |width: f64, height: f64| {
        let options = PassOptions {
            constants: &[("WIDTH", width), ("HEIGHT", height)],
            ..PassOptions::default()
        };
        Pass::new(&gpu.device, &shader("override_size"), &options)
    };
    let pass = make(32.0, 8.0).expect("256 invocations");
    let options = pass.build_options(BuildOptions::default());
    assert_eq!((options.tile, options.largest), ([32, 8], Rate::R2X2));
    match make(32.0, 9.0) {
        Err(PassError::GroupTooLarge { size, area, most }) => {
            assert_eq!((size, area, most), ([32, 9, 1], 288, 256));
        }
        other => panic!("{other:?}"),
    }
    // sides that no group of 2x2 divides
    let pass = make(15.0, 2.0).expect("30 invocations");
    let options = pass.build_options(BuildOptions::default());
    assert_eq!((options.tile, options.largest), ([15, 2], Rate::R1X2));
    View::new(&gpu.device, &gpu.queue, [61, 47, 1], options).expect("a view for it");
    let too_coarse = BuildOptions {
        tile: [15, 2],
        ..BuildOptions::default()
    };
    let refused = View::new(&gpu.device, &gpu.queue, [61, 47, 1], too_coarse);
    assert!(matches!(refused, Err(ViewError::Options(_))));
}
