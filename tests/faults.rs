//! Faults, planted in rewritten shaders, and caught: a check that could not fail would prove nothing.
//!
//! Each test changes the text of a rewritten shader in one place and expects the check to fail.

mod common;

use vrcs::check::{Job, Law, Route, Verdict, check_rewritten};
use vrcs_passes::{
    Options, Rewritten, Source, emit, input,
    options::{Atomics, Mode, Policy},
    rewrite,
};

/// Rewrites a shader, replaces `from` by `to` in the result, and checks that.
fn caught(shader: &str, from: &str, to: &str) -> Law {
    caught_with(shader, from, to, &[])
}

/// The same, with some inputs set.
fn caught_with(shader: &str, from: &str, to: &str, set: &[(&str, f64)]) -> Law {
    caught_in(
        &common::shader(shader),
        &Options::default(),
        (from, to),
        set,
    )
}

/// The same, of any shader with any options.
fn caught_in(
    source: &Source,
    options: &Options,
    (from, to): (&str, &str),
    set: &[(&str, f64)],
) -> Law {
    let (module, info) = common::parse(source);
    let rewritten = rewrite(&module, &info, "main", options).expect("a rewrite");
    let text = emit::wgsl(&rewritten.module, &rewritten.info).expect("text");
    assert!(
        text.contains(from),
        "there is no `{from}` to break in\n{text}"
    );
    let broken = text.replacen(from, to, 1);
    let (broken_module, broken_info) = input::wgsl(&Source::new("broken", broken))
        .unwrap_or_else(|invalid| panic!("{}", invalid.rendered));
    let broken = Rewritten {
        module: broken_module,
        info: broken_info,
        ..rewritten
    };
    let mut job = Job::new("main");
    job.options = options.clone();
    job.route = Route::Module;
    // the first difference ends it, so that only a fault that is seldom seen takes so many
    job.cases = 512;
    job.seed = common::seed();
    for &(name, value) in set {
        job.settings.set.insert(name.to_owned(), vec![value]);
    }
    let report = check_rewritten(
        &common::gpu(),
        source,
        &module,
        &info,
        &broken,
        &job,
        &mut |_| {},
    )
    .expect("a check");
    assert_eq!(report.verdict, Verdict::Failed, "{:?}", report.why);
    let failure = report.failure.expect("a difference");
    assert!(!failure.picture.is_empty());
    failure.law
}

#[test]
fn a_block_goes_on_into_the_next_row() {
    caught_with(
        "ragged_blocks",
        ">= captured_d)",
        ">= (captured_d + 4u))",
        &[("picture.width", 61.0), ("picture.height", 47.0)],
    );
}

#[test]
fn a_wrong_mask_bit() {
    caught("plain", "& 2u) != 0u", "& 4u) != 0u");
}

#[test]
fn the_diagonal_copy_is_missing() {
    caught("plain", "& 32u) != 0u", "& 64u) != 0u");
}

#[test]
fn entries_are_read_one_further_on() {
    caught("plain", "+ lane_1)];", "+ lane_1) + 1u];");
}

#[test]
fn one_invocation_too_many_in_each_tile() {
    caught("plain", "(lane_1 >= _e18)", "(lane_1 > _e18)");
}

#[test]
fn one_invocation_too_few_in_each_tile() {
    caught("plain", "(lane_1 >= _e18)", "((lane_1 + 1u) >= _e18)");
}

#[test]
fn duplicates_are_not_confined_to_the_extent() {
    caught("plain", "return ((mask & columns) & rows);", "return mask;");
}

#[test]
fn the_last_column_of_the_extent_is_lost() {
    caught("plain", "((1u << room.x) - 1u)", "((1u << room.x) - 2u)");
}

#[test]
fn full_tiles_are_not_confined_to_the_extent() {
    caught("plain", "return all((pixel < ", "return all((pixel <= ");
}

#[test]
fn duplicates_outside_the_domain_are_written() {
    // a border that chance makes may end where groups do, or beyond the picture; an odd one goes through groups
    caught_with(
        "guarded",
        "fn vrcs_in_domain(pixel: vec3<u32>) -> bool {",
        "fn vrcs_in_domain(pixel: vec3<u32>) -> bool {\n    if true { return true; }",
        &[("border", 3.0)],
    );
}

#[test]
fn a_block_that_the_domain_ends_in_is_taken_for_whole() {
    // the pictures of the check have odd sides: an even border ends inside a group
    caught_with("guarded", "(far.x >= ", "(near.x >= ", &[("border", 2.0)]);
}

#[test]
fn a_block_that_the_domain_begins_in_is_taken_for_whole() {
    caught_with("guarded", "(near.y < ", "(far.y < ", &[("border", 3.0)]);
}

#[test]
fn a_block_that_the_extent_ends_in_is_taken_for_whole() {
    let from = "(pixel_3.xy | vec2(3u))";
    for to in [
        "vec2<u32>(pixel_3.x, pixel_3.y | 3u)",
        "vec2<u32>(pixel_3.x | 3u, pixel_3.y)",
    ] {
        caught("plain", from, to);
    }
}

#[test]
fn a_quad_that_the_extent_ends_in_is_taken_for_whole() {
    let from = "(pixel_4.xy | vec2(1u))";
    for to in [
        "vec2<u32>(pixel_4.x, pixel_4.y | 1u)",
        "vec2<u32>(pixel_4.x | 1u, pixel_4.y)",
    ] {
        in_mode(Mode::List, from, to);
    }
}

#[test]
fn a_group_whose_primary_lies_outside_the_domain_is_lost() {
    // an odd border leaves the first pixels of groups outside
    let border = [("border", 3.0)];
    caught_with("guarded", "= firstTrailingBit(_e9);", "= 16u;", &border);
}

#[test]
fn the_domain_is_not_asked_of_a_pixel_that_is_alone() {
    // the author's guard is gone, since the prologue asks
    let border = [("border", 3.0)];
    let options = Options {
        mode: Mode::List,
        ..Options::default()
    };
    let each = "members = mask;\n    left = mask;";
    let but_one = "members = mask;\n    left = select(mask, 0u, countOneBits(mask) == 1u);";
    let whole = "let _e2 = vrcs_in_domain(pixel_2);";
    for (options, from, to) in [
        (&Options::default(), whole, "let _e2 = true;"),
        (&options, each, but_one),
    ] {
        caught_in(&common::shader("guarded"), options, (from, to), &border);
    }
}

#[test]
fn distances_have_the_wrong_sign() {
    caught(
        "plain",
        "return (vec2<i32>(_e1.xy) - vec2<i32>(_e5.xy));",
        "return (vec2<i32>(_e5.xy) - vec2<i32>(_e1.xy));",
    );
}

#[test]
fn rows_and_columns_of_duplicates_are_exchanged() {
    caught(
        "morton",
        "vec2<u32>((k & 3u), (k >> 2u))",
        "vec2<u32>((k >> 2u), (k & 3u))",
    );
}

#[test]
fn masks_are_not_turned_to_their_primary() {
    // a primary that is not its group's first pixel comes about by re-homing
    let border = [("border", 3.0)];
    let from = "= vrcs_relative(_e9, ";
    caught_with("guarded", from, "= vrcs_relative(_e9, 0u * ", &border);
}

#[test]
fn a_store_has_no_copy() {
    let law = caught(
        "early_returns",
        "\n        vrcs_copy_picture(",
        "\n        // vrcs_copy_picture(",
    );
    assert_ne!(law, Law::Identity);
}

#[test]
fn a_store_is_copied_twice() {
    // the picture is right, but each place is written more often than its primary stores
    let law = caught(
        "plain",
        "    if ((_e4 & 2u) != 0u) {",
        "    if ((_e4 & 2u) != 0u) { textureStore(picture, at + vec2<u32>(vrcs_delta(1u)), value);",
    );
    assert_eq!(law, Law::Partition);
}

#[test]
fn the_local_id_is_that_of_another_group_size() {
    caught(
        "group_and_local",
        "% vec3<u32>(8u, 4u, 1u)",
        "% vec3<u32>(4u, 8u, 1u)",
    );
}

#[test]
fn the_number_of_workgroups_is_that_of_the_tiles() {
    caught(
        "lone_groups",
        "= vrcs_params.groups;",
        "= (vrcs_params.groups + vec3(15u)) / 16u;",
    );
}

#[test]
fn the_switch_is_ignored() {
    let law = caught("plain", "vrcs_params.flags;", "vrcs_params.flags | 1u;");
    assert_eq!(law, Law::Off);
}

#[test]
fn a_captured_loop_counter_is_lost() {
    caught(
        "sliced_loop",
        "vrcs_copy_texels(_e",
        "vrcs_copy_texels(0u * _e",
    );
}

#[test]
fn what_a_caller_keeps_is_lost() {
    caught("sliced_loop", "vrcs_kept = _e", "vrcs_kept = 0u * _e");
}

#[test]
fn a_stride_is_too_long() {
    caught("buffer", "= i32(captured_a", "= 1 + i32(captured_a");
}

#[test]
fn layers_are_mixed_up() {
    caught(
        "layers",
        "vrcs_copy_volume(_e",
        "vrcs_copy_volume(vec3(0, 0, 1) + _e",
    );
}

#[test]
fn the_arithmetic_is_changed() {
    let law = caught(
        "morton",
        "= textureLoad(input",
        "= 1.0000001 * textureLoad(input",
    );
    assert_eq!(law, Law::Identity);
}

fn in_mode(mode: Mode, from: &str, to: &str) {
    let options = Options {
        mode,
        ..Options::default()
    };
    caught_in(&common::shader("plain"), &options, (from, to), &[]);
}

#[test]
fn a_list_is_one_entry_too_long() {
    in_mode(Mode::List, "if (number_2 >= _e32)", "if (number_2 > _e32)");
}

#[test]
fn a_lists_pixels_are_transposed() {
    in_mode(
        Mode::List,
        "vec3<u32>((first_1 & 16383u), ((first_1 >> 14u) & 16383u), z_2)",
        "vec3<u32>(((first_1 >> 14u) & 16383u), (first_1 & 16383u), z_2)",
    );
}

#[test]
fn a_lists_duplicates_are_taken_for_one_another() {
    // across for down
    in_mode(
        Mode::List,
        "(((duplicates & 1u) << 1u) | ((duplicates & 6u) << 3u))",
        "(((duplicates & 1u) << 4u) | (duplicates & 2u) | ((duplicates & 4u) << 3u))",
    );
}

#[test]
fn a_lists_quads_are_taken_for_the_first_of_their_block() {
    // where the extent ends in a quad, its members are asked one by one, over the block
    in_mode(
        Mode::List,
        "vrcs_relative((copies | 1u), home_2)",
        "(copies | 1u)",
    );
}

#[test]
fn a_list_has_rows_of_another_length() {
    // small workgroups, so that small pictures have more than one row of them
    let options = Options {
        mode: Mode::List,
        tile: [8, 8],
        ..Options::default()
    };
    let change = ("(group_1.y * VRCS_ROW)", "(group_1.y * 31u)");
    caught_in(&common::shader("plain"), &options, change, &[]);
}

#[test]
fn a_class_of_tiles_has_its_rates_transposed() {
    in_mode(
        Mode::Classified,
        "let rate_6 = vec2<u32>((code >> 2u), (code & 3u));",
        "let rate_6 = vec2<u32>((code & 3u), (code >> 2u));",
    );
}

#[test]
fn a_class_of_tiles_starts_where_others_do() {
    let from = "(number_5 - ends.z)";
    in_mode(Mode::Classified, from, "number_5");
}

#[test]
fn a_class_of_tiles_is_shaded_in_one_row() {
    in_mode(Mode::Classified, "(number_2 >> firstTrailingBit(by))", "0u");
}

/// Counts how many pixels fall into each of 16 bins.
const HISTOGRAM: &str = "
@group(0) @binding(0) var picture: texture_storage_2d<rgba32float, write>;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> bins: array<atomic<u32>, 16>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let color = textureLoad(input, id.xy, 0);
    atomicAdd(&bins[u32(color.x * 15.0) & 15u], 3u);
    textureStore(picture, id.xy, color + vec4(f32(id.x)));
}";

#[test]
fn an_atomic_counts_primaries() {
    let options = Options {
        atomics: Atomics::Weight,
        ..Options::default()
    };
    let source = Source::new("histogram.wgsl", HISTOGRAM);
    let fault = ("(value * countOneBits(_e4))", "(0u * countOneBits(_e4))");
    caught_in(&source, &options, fault, &[]);
}

/// Two targets, one of which every pixel writes for itself.
const NORMALS: &str = "
@group(0) @binding(0) var color: texture_storage_2d<rgba32float, write>;
@group(0) @binding(1) var normals: texture_storage_2d<rgba32float, write>;
@group(0) @binding(2) var input: texture_2d<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let texel = textureLoad(input, id.xy, 0);
    textureStore(normals, id.xy, vec4(texel.xyz * 2.0 - 1.0, f32(id.y)));
    textureStore(color, id.xy, texel + vec4(f32(id.x)));
}";

fn full(from: &str, to: &str) {
    let mut options = Options::default();
    options.targets.insert("normals".to_owned(), Policy::Full);
    let source = Source::new("normals.wgsl", NORMALS);
    caught_in(&source, &options, (from, to), &[]);
}

#[test]
fn what_every_pixel_writes_is_left_out() {
    full(
        "fn main_full(id: vec3<u32>) {",
        "fn main_full(id: vec3<u32>) {\n    if id.y % 2u == 1u { return; }",
    );
}

#[test]
fn what_every_pixel_writes_is_another_pixels() {
    full(
        "= textureLoad(input, id.xy, 0i);",
        "= textureLoad(input, id.xy / 2u, 0i);",
    );
}

/// A picture whose pixels are numbered row by row.
const LINE: &str = "
struct Frame { width: u32, height: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read_write> pixels: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width * frame.height {
        return;
    }
    pixels[id.x] = f32((id.x % frame.width) * 3u + id.x / frame.width);
}";

fn line(from: &str, to: &str) {
    let options = Options {
        linear: Some("frame.width".parse().expect("a width")),
        ..Options::default()
    };
    let source = Source::new("line.wgsl", LINE);
    caught_in(&source, &options, (from, to), &[]);
}

#[test]
fn pixels_are_numbered_by_a_longer_row() {
    line("(_e5.y * _e8)", "(_e5.y * (_e8 + 1u))");
}

#[test]
fn copies_go_to_a_longer_row() {
    line(
        "let _e5 = i32(captured_a);",
        "let _e5 = i32(captured_a) + 1;",
    );
}

/// A sum over pairs of a tile, through workgroup memory.
const PAIRS: &str = "
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var output: texture_storage_2d<rgba32float, write>;
var<workgroup> tile: array<vec4<f32>, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) own: u32) {
    tile[own] = textureLoad(input, id.xy, 0);
    workgroupBarrier();
    let sum = tile[own] + tile[63u - own];
    textureStore(output, id.xy, sum + vec4(f32(id.x)));
}";

fn together(from: &str, to: &str) {
    let source = Source::new("pairs.wgsl", PAIRS);
    caught_in(&source, &Options::default(), (from, to), &[]);
}

#[test]
fn what_a_group_does_together_is_done_for_the_pixels_that_are_shaded() {
    together(
        "main_inner(vrcs_id, vrcs_lane_index,",
        "main_inner(_e8, vrcs_lane_index,",
    );
}

#[test]
fn the_place_of_the_shaded_pixel_in_its_group_is_the_lanes() {
    together(
        "(_e8.y % 8u)) * 8u) + (_e8.x % 8u))",
        "(vrcs_local.y % 8u)) * 8u) + (vrcs_local.x % 8u))",
    );
}

#[test]
fn lanes_without_a_pixel_shade_one() {
    together("    if _e26 {", "    if true || _e26 {");
}

#[test]
fn the_other_colour_of_a_checkerboard_is_stored_too() {
    caught(
        "checkerboard",
        "fn vrcs_in_domain(pixel: vec3<u32>) -> bool {",
        "fn vrcs_in_domain(pixel: vec3<u32>) -> bool {\n    if true { return true; }",
    );
}

#[test]
fn the_rows_of_a_plane_are_forgotten() {
    caught("planes", "vrcs_copy_planes(_e", "vrcs_copy_planes(0u * _e");
}
