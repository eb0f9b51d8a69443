//! Hazards whose test needs the rig of another test, and those that do not apply. The table names the test; it is looked for, so that the
//! page cannot name one that is gone.

use std::{fmt::Write, path::PathBuf};

/// A hazard that is tested in another file.
struct Elsewhere {
    id: &'static str,
    what: &'static str,
    file: &'static str,
    test: &'static str,
}

const ELSEWHERE: &[Elsewhere] = &[
    Elsewhere {
        id: "E15",
        what: "the norm's gain on a ramp, the window's, and ε from both",
        file: "src/analyse/hysteresis.rs",
        test: "e15_gains_of_a_window_are_those_of_its_own_sixteen_pixels",
    },
    Elsewhere {
        id: "E18",
        what: "every combination of effects on this driver, byte for byte as its integer twin",
        file: "tests/analyse/main.rs",
        test: "the_gpu_makes_the_bytes_of_its_integer_twin",
    },
    Elsewhere {
        id: "E27",
        what: "0 to 256 primaries in a tile, drawn in every mode",
        file: "tests/modes/maps.rs",
        test: "any_number_of_primaries_in_a_tile",
    },
    Elsewhere {
        id: "E29",
        what: "more than 65,535 workgroups in a list: all are drawn",
        file: "tests/modes/maps.rs",
        test: "a_list_of_more_workgroups_than_a_dimension_has",
    },
    Elsewhere {
        id: "E29",
        what: "frame after frame with the same buffers: counters start anew, and stale entries do no harm",
        file: "tests/modes/maps.rs",
        test: "frame_after_frame_with_the_same_buffers",
    },
    Elsewhere {
        id: "E30",
        what: "fifty runs of the deblocker are one run, bit for bit",
        file: "tests/deblock/twin.rs",
        test: "fifty_runs_are_one_run",
    },
    Elsewhere {
        id: "E31",
        what: "a silhouette at 1e4 does not leak over its edge; infinity and NaN are not spread",
        file: "tests/deblock/edges.rs",
        test: "a_bright_silhouette_does_not_leak",
    },
    Elsewhere {
        id: "E31",
        what: "what is not finite is not spread at all, and is reported",
        file: "tests/deblock/edges.rs",
        test: "what_is_not_finite_does_not_spread_and_is_reported",
    },
    Elsewhere {
        id: "E35",
        what: "a floor that recedes steeply is one surface to coverage and deblocker",
        file: "tests/deblock/edges.rs",
        test: "a_floor_that_recedes_steeply_is_one_surface",
    },
    Elsewhere {
        id: "E40",
        what: "the kernels' combiners are the library's, over every pair of bytes",
        file: "tests/rates.rs",
        test: "kernels_have_the_algebra_of_the_library",
    },
    Elsewhere {
        id: "E41",
        what: "rays on this driver, over frames, within six standard errors",
        file: "tests/modes/given.rs",
        test: "rays_are_never_none_and_right_on_average",
    },
    Elsewhere {
        id: "E43",
        what: "gradients and levels scaled by the rate where that is asked for, held against the author's own: ×1 at 1x1",
        file: "tests/shapes.rs",
        test: "detail_follows_the_rate",
    },
    Elsewhere {
        id: "E42",
        what: "rotation on this driver, at extents that cut blocks",
        file: "tests/builder.rs",
        test: "a_primary_is_of_its_own_group_for_every_coverage_rate_and_phase",
    },
];

/// The page's part; the tests that are gone, if there are any.
pub fn page() -> Result<String, String> {
    let mut page = "\n## Elsewhere\n\nWith the rig of another test; that each is still there is checked.\n\n| hazard | what is shown | test |\n|---|---|---|\n".to_owned();
    for case in ELSEWHERE {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(case.file);
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        if !text.contains(&format!("fn {}()", case.test)) {
            return Err(format!("{} has no test {}", case.file, case.test));
        }
        let _ = writeln!(
            page,
            "| {}: {} | `{}` | `{}` |",
            case.id, case.what, case.file, case.test
        );
    }
    Ok(page)
}
