//! Faults, planted in rewritten shaders, and caught: a check that could not fail would prove nothing.
//!
//! Each test changes the text of a rewritten shader in one place and expects the check to fail.

mod common;

use vrcs::check::{Job, Law, Route, Verdict, check_rewritten};
use vrcs_passes::{Options, Rewritten, Source, emit, input, rewrite};

/// Rewrites a shader, replaces `from` by `to` in the result, and checks that.
fn caught(shader: &str, from: &str, to: &str) -> Law {
    caught_with(shader, from, to, &[])
}

/// The same, with some inputs set.
fn caught_with(shader: &str, from: &str, to: &str, set: &[(&str, f64)]) -> Law {
    let source = common::shader(shader);
    let (module, info) = common::parse(&source);
    let rewritten = rewrite(&module, &info, "main", &Options::default()).expect("a rewrite");
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
    job.route = Route::Module;
    job.seed = common::seed();
    for &(name, value) in set {
        job.settings.set.insert(name.to_owned(), vec![value]);
    }
    let report = check_rewritten(
        &common::gpu(),
        &source,
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
    caught(
        "guarded",
        "fn vrcs_in_domain(pixel: vec3<u32>) -> bool {",
        "fn vrcs_in_domain(pixel: vec3<u32>) -> bool {\n    if true { return true; }",
    );
}

#[test]
fn a_group_whose_primary_lies_outside_the_domain_is_lost() {
    // an odd border leaves the first pixels of groups outside
    let border = [("border", 3.0)];
    caught_with("guarded", "= firstTrailingBit(_e8);", "= 16u;", &border);
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
    let from = "= vrcs_relative(_e8, ";
    caught_with("guarded", from, "= vrcs_relative(_e8, 0u * ", &border);
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
        "    if (_e4 != 0u) {",
        "    if (_e4 != 0u) { if ((_e4 & 2u) != 0u) { textureStore(picture, at + vec2<u32>(vrcs_delta(1u)), value); }",
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
