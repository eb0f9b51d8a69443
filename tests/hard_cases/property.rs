//! Properties over spaces that are too large to walk through: proptest, from the tests' own seed.

use proptest::{
    strategy::Strategy,
    test_runner::{Config, RngAlgorithm, TestCaseResult, TestRng, TestRunner},
};

use crate::common;

/// Holds a property for so many values, times what `VRCS_CASES_TIMES` says; what failed is made small, and comes with the seed.
pub fn hold<S: Strategy>(
    cases: u32,
    values: &S,
    test: impl Fn(S::Value) -> TestCaseResult,
) -> Result<String, String> {
    let times: u32 = std::env::var("VRCS_CASES_TIMES")
        .ok()
        .and_then(|times| times.parse().ok())
        .unwrap_or(1);
    let seed = common::seed();
    let mut bytes = [0; 32];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    let config = Config {
        cases: cases * times,
        failure_persistence: None,
        ..Config::default()
    };
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &bytes);
    let mut runner = TestRunner::new_with_rng(config, rng);
    runner
        .run(values, test)
        .map(|()| format!("{cases} random ones"))
        .map_err(|error| format!("VRCS_SEED={seed}: {error}"))
}
