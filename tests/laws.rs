//! The laws of the contract, bit for bit, for shaders of every shape that is rewritten: hundreds of shading-rate images each,
//! views that are a part of a larger picture among them, outputs poisoned beforehand.

mod common;

use vrcs::check::Job;
use vrcs_passes::options::{MaxRate, Mode, Sky};

fn hold(name: &str) {
    let source = common::shader(name);
    let mut job = Job::new("main");
    job.seed = common::seed();
    job.cases = 128;
    // the rarest, `off`, is every sixteenth case
    common::hold_every_law(&source, job, 6, 32);
}

macro_rules! laws {
    ($($name:ident)+) => {
        $(
            #[test]
            fn $name() {
                hold(stringify!($name));
            }
        )+

        #[test]
        fn every_shader_has_its_test() {
            let tested = [$(stringify!($name)),+];
            for entry in std::fs::read_dir(common::shader_path("").parent().expect("a folder")).expect("shaders") {
                let path = entry.expect("an entry").path();
                let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
                assert!(tested.contains(&name.as_str()), "{name} is not tested");
            }
        }
    };
}

laws! {
    accumulate
    asks_rate
    blocks
    branches
    buffer
    buffer_parts
    checkerboard
    clamped
    constant_parts
    early_returns
    flipped
    flips
    group_and_local
    group_buffer
    guarded
    half_size
    helpers
    lanes
    layers
    lone_groups
    morton
    odd_groups
    overrides
    parity
    plain
    planes
    private_place
    ragged_blocks
    rows_by_data
    sliced_loop
    split_screen
    strided
    targets
    through_pointers
    tile_bits
    tile_order
    torus
    transposed
    uniform_or_edge
    upper_layers
    wide_blocks
}

/// The laws for rates that are 4 wide or 4 high, where the copies are a loop. Offsets, strides, recomputed addresses,
/// guards, layers and re-homed groups are among the shaders.
#[test]
fn larger_rates() {
    let rates = [MaxRate::R4x4, MaxRate::R2x4, MaxRate::R4x2];
    let names = [
        "plain",
        "guarded",
        "buffer",
        "strided",
        "sliced_loop",
        "lone_groups",
        "morton",
        "layers",
        "transposed",
        "accumulate",
        "half_size",
        "parity",
        "ragged_blocks",
        "constant_parts",
    ];
    for (index, name) in names.into_iter().enumerate() {
        let mut job = Job::new("main");
        job.seed = common::seed();
        job.cases = 32;
        job.options.max_rate = rates[index % 3];
        common::assert_passed(&common::run(&common::shader(name), &job));
    }
}

#[test]
fn pictures_of_any_size() {
    for size in [
        [1, 1],
        [2, 3],
        [15, 17],
        [31, 33],
        [16, 16],
        [17, 1],
        [1, 40],
    ] {
        for name in ["plain", "guarded", "buffer"] {
            let mut job = Job::new("main");
            job.seed = common::seed();
            job.size = size;
            job.cases = 32;
            if name == "guarded" {
                // something has to be left inside the border
                job.settings.set.insert("border".to_owned(), vec![0.0]);
            }
            let report = common::run(&common::shader(name), &job);
            // a picture of a few pixels may be the same everywhere
            if size[0].min(size[1]) > 8 {
                common::assert_passed(&report);
            }
            assert_eq!(report.failure, None, "{name} {size:?}");
        }
    }
}

/// The laws in every mode that copies, with rotating primaries and random surfaces and sky among the cases, for shaders of every
/// kind of copy.
#[test]
fn every_mode() {
    let modes = [Mode::List, Mode::Classified];
    let names = [
        "plain",
        "guarded",
        "buffer",
        "strided",
        "lone_groups",
        "layers",
        "targets",
        "tile_order",
    ];
    for (index, name) in names.into_iter().enumerate() {
        for (mode, sky) in modes.into_iter().zip([Sky::Skip, Sky::Shade]) {
            let mut job = Job::new("main");
            job.seed = common::seed();
            job.cases = 16;
            job.options.mode = mode;
            job.options.sky = match index % 2 {
                0 => sky,
                _ => Sky::Skip,
            };
            job.options.max_rate = [MaxRate::R2x2, MaxRate::R4x4][index / 2 % 2];
            // a small tile has more boundaries
            job.options.tile = [[16, 16], [8, 4]][index / 4 % 2];
            common::assert_passed(&common::run(&common::shader(name), &job));
        }
    }
}

/// Sky is skipped or shaded, in tiled dispatch too.
#[test]
fn sky_is_a_choice_of_the_pass() {
    for sky in [Sky::Skip, Sky::Shade] {
        let mut job = Job::new("main");
        job.seed = common::seed();
        job.options.sky = sky;
        job.options.wave = 8;
        common::assert_passed(&common::run(&common::shader("guarded"), &job));
    }
}

/// A store outside its buffer may be dropped, or land in the last element, as the driver likes: what is there then is chance,
/// and the check holds every other place.
#[test]
fn stores_outside_a_buffer_are_nobodys() {
    let text = "
@group(0) @binding(0) var<storage, read_write> out: array<u32, 1500>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    out[id.y * 64u + id.x] = id.x * 7919u + id.y * 31u + 5u;
}
";
    let source = vrcs_passes::Source::new("unguarded.wgsl", text);
    for size in [[61, 47], [1, 1]] {
        let mut job = Job::new("main");
        job.seed = common::seed();
        job.size = size;
        let report = common::run(&source, &job);
        common::assert_passed(&report);
        let is_told = report.notes.iter().any(|note| note.contains("outside"));
        assert_eq!(is_told, size != [1, 1], "{:?}", report.notes);
    }
}

/// Two pictures of a fixed size in one buffer, of which no bound tells: rewritten by the author's word that they lie apart.
#[test]
fn pictures_that_lie_apart_by_the_authors_word() {
    let text = "
struct Frame { width: u32, height: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read_write> pictures: array<f32, 8192>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height { return; }
    let own = id.y * frame.width + id.x;
    var sum = 0.0;
    for (var k = 0u; k < 5u; k++) {
        sum += pictures[own + k * k];
    }
    pictures[4096u + own] = sum + f32(id.x);
}
";
    let source = vrcs_passes::Source::new("pictures.wgsl", text);
    let mut job = Job::new("main");
    job.seed = common::seed();
    let (module, info) = common::parse(&source);
    let without = vrcs_passes::rewrite(&module, &info, "main", &job.options);
    assert!(without.is_err(), "no word is given");
    job.options.apart.insert("pictures".to_owned());
    common::assert_passed(&common::run(&source, &job));
}
