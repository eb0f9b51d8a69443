//! The laws of the contract, for shaders that nobody wrote: a [grammar](grammar) makes them from seeds, over the shapes that
//! people write, and each is rewritten and checked on a driver.
//!
//! A shader that fails is [shrunk](shrink) and printed with its number. `VRCS_GENERATED=10000` makes a long run of it,
//! `VRCS_SEED` starts elsewhere, `VRCS_THREADS` says how many are checked at a time, and `VRCS_SHADER` with the number of
//! a shader checks that one alone, and prints it. `VRCS_GENERATED_SECONDS` ends a run early, and `VRCS_SHRUNK=0` shrinks nothing.
//! `README.md` tells of the long runs.

#[path = "../common/mod.rs"]
mod common;
mod control;
mod extras;
mod found;
mod grammar;
mod ids;
mod judge;
mod refused;
mod shrink;
mod targets;
mod values;

use std::{
    collections::{BTreeMap, HashSet},
    sync::{
        Mutex,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use judge::{Outcome, judge};

/// How often a shrinker asks, and how many failures are shrunk unless `VRCS_SHRUNK` says otherwise.
const TRIES: u32 = 600;
const SHRUNK: u64 = 4;

fn from_env(name: &str) -> Option<u64> {
    let value = std::env::var(name).ok()?;
    Some(
        value
            .parse()
            .unwrap_or_else(|_| panic!("{name} is a number")),
    )
}

/// What came of many shaders.
#[derive(Default)]
struct Tally {
    /// How often each came, and the first shader that it came of.
    outcomes: BTreeMap<String, (u64, u64)>,
    shapes: BTreeMap<&'static str, u32>,
    failures: Vec<(u64, String)>,
}

/// The gate's shaders are always the same; `VRCS_SEED` gives others. Of fresh ones, five in 3741 met what the check's own reference does
/// not know (see `README.md`), and a gate must not fail by chance.
fn seed() -> u64 {
    match std::env::var_os("VRCS_SEED") {
        Some(_) => common::seed(),
        None => GATE_SEED,
    }
}

const GATE_SEED: u64 = 324_696_106;

#[test]
fn the_laws_hold_for_shaders_that_nobody_wrote() {
    let slow = common::gpu().info.name.contains("SwiftShader");
    let alone = from_env("VRCS_SHADER");
    let (first, count) = match alone {
        Some(number) => (number, 1),
        None => {
            let usual = if slow { 24 } else { 80 };
            (
                seed() * 1_000_003,
                from_env("VRCS_GENERATED").unwrap_or(usual),
            )
        }
    };
    let threads = from_env("VRCS_THREADS").unwrap_or(2);
    let shrunk = from_env("VRCS_SHRUNK").unwrap_or(SHRUNK);
    let limit = from_env("VRCS_GENERATED_SECONDS").map(Duration::from_secs);
    let start = Instant::now();
    let next = AtomicU64::new(0);
    let tally = Mutex::new(Tally::default());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let gpu = common::gpu();
                loop {
                    if limit.is_some_and(|limit| start.elapsed() > limit) {
                        return;
                    }
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= count {
                        return;
                    }
                    let seed = first + number;
                    let shader = grammar::shader(seed);
                    if alone.is_some() {
                        println!("{}{:?}", shader.text, judge::job(&shader, seed).options);
                    }
                    let outcome = judge(&gpu, &shader, seed);
                    let mut tally = tally.lock().expect("a tally");
                    if number % 500 == 499 {
                        eprintln!("{} of {count}", number + 1);
                    }
                    let entry = tally.outcomes.entry(outcome.label());
                    entry.or_insert((0, seed)).0 += 1;
                    if let Outcome::Held | Outcome::HeldWhereSeen(_) = outcome {
                        for shape in &shader.shapes {
                            *tally.shapes.entry(shape).or_default() += 1;
                        }
                    }
                    if let Outcome::Bad(_) = &outcome {
                        let is_first = (tally.failures.len() as u64) < shrunk;
                        tally.failures.push((seed, format!("{outcome:?}")));
                        drop(tally);
                        if is_first {
                            eprintln!("{}", told(&gpu, &shader, seed, &outcome));
                        }
                    }
                }
            });
        }
    });
    let tally = tally.into_inner().expect("a tally");
    let count: u64 = tally.outcomes.values().map(|(times, _)| times).sum();
    println!("{count} shaders from seed {first} on:");
    for (outcome, (times, example)) in &tally.outcomes {
        println!("{times:6}  {outcome} ({example})");
    }
    println!("shapes that held:");
    for (shape, times) in &tally.shapes {
        println!("{times:6}  {shape}");
    }
    assert!(tally.failures.is_empty(), "{:#?}", tally.failures);
    if alone.is_some() {
        return;
    }
    let of = |start: &str| -> u64 {
        let matching = tally.outcomes.iter().filter(|(o, _)| o.starts_with(start));
        matching.map(|(_, (times, _))| times).sum()
    };
    // a check that cannot tell proves nothing, so few may be such
    assert!(
        of("inconclusive") * 20 <= count,
        "too many are inconclusive"
    );
    assert!(of("not runnable") * 4 <= count, "too many cannot be run");
    assert!(of("held") * 2 > count, "too few were held");
}

/// A failure for the reader: what failed, the seed, and the shader, shrunk.
fn told(
    gpu: &vrcs::check::gpu::Gpu,
    shader: &grammar::Shader,
    seed: u64,
    outcome: &Outcome,
) -> String {
    let kind = outcome.kind();
    let small = shrink::shrink(&shader.text, TRIES, &mut |text| {
        let smaller = grammar::Shader {
            text: text.to_owned(),
            ..shader.clone()
        };
        judge(gpu, &smaller, seed).kind() == kind
    });
    format!(
        "---- seed {seed}, {:?}: {outcome:?}\n{:?}\n{small}---- made of\n{}----",
        shader.size,
        judge::job(shader, seed).options,
        shader.text
    )
}

/// Thousands of shaders without a driver: each is valid, and rewritten or refused as it must be, to a valid text.
#[test]
fn shaders_that_nobody_wrote_are_rewritten() {
    let first = common::seed() * 1_000_003;
    let count = from_env("VRCS_GENERATED").unwrap_or(1500);
    let mut shapes = HashSet::new();
    // one shrunk shader for each sort of failure, and how often it came
    let mut failures: BTreeMap<String, (u32, String)> = BTreeMap::new();
    for seed in first..first + count {
        let shader = grammar::shader(seed);
        shapes.extend(shader.shapes.iter().copied());
        let options = judge::job(&shader, seed).options;
        let Err(bad) = judge::rewritten(&shader, &options) else {
            continue;
        };
        let failure = failures.entry(bad.sort()).or_default();
        failure.0 += 1;
        if failure.0 > 1 {
            continue;
        }
        let small = shrink::shrink(&shader.text, 2000, &mut |text| {
            let smaller = grammar::Shader {
                text: text.to_owned(),
                ..shader.clone()
            };
            judge::rewritten(&smaller, &options).is_err_and(|other| other.sort() == bad.sort())
        });
        failure.1 = format!("seed {seed}: {}\n{small}", bad.what);
    }
    for (sort, (times, first)) in &failures {
        println!("---- {times} times: {sort}\n{first}");
    }
    assert!(failures.is_empty(), "{} sorts of failures", failures.len());
    // the grammar reaches all its shapes
    assert!(shapes.len() >= 60, "{}: {shapes:?}", shapes.len());
}
