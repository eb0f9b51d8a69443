//! Checks each entry point in a process of its own: a driver may take it with it.
//!
//! Where it does, a second process runs the original alone. If that dies, too, the driver cannot run the shader; if it does not,
//! the rewrite is at fault.

use std::{collections::BTreeMap, process::Command};

use naga::valid::GlobalUse;
use vrcs::{
    check::{
        Job, Verdict,
        gpu::Gpu,
        inputs::{self, Maker, Seeds, Settings},
        run::{Build, Code, Program},
    },
    dispatch::reflect,
};
use vrcs_passes::{Options, input::Shader};

use super::{common, table::Row};

/// Names the entry point that a child checks.
pub const NAME: &str = "VRCS_CORPUS_CHILD";
/// Says that a child runs the original alone.
const ORIGINAL: &str = "VRCS_CORPUS_ORIGINAL";
const SIZE: [u32; 2] = [29, 21];
/// What stands before a child's verdict.
const MARK: &str = "verdict: ";

/// What becomes of an entry point in a child.
pub fn outcome(name: &str, seed: u64) -> String {
    if let Some(verdict) = child(name, seed, &[]) {
        return verdict;
    }
    match child(name, seed, &[(ORIGINAL, "1")]) {
        None => "not runnable: the driver dies of the original alone".to_owned(),
        Some(_) => "FAILED: the driver dies, and not of the original alone".to_owned(),
    }
}

/// The verdict of a child; `None` if it died before.
fn child(name: &str, seed: u64, env: &[(&str, &str)]) -> Option<String> {
    let test = std::env::current_exe().expect("this test");
    let output = Command::new(test)
        .args(["what_is_rewritten_keeps_the_laws", "--exact", "--nocapture"])
        .env(NAME, name)
        .env("VRCS_SEED", seed.to_string())
        .envs(env.iter().copied())
        .output()
        .expect("a child");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let verdict = said.lines().find_map(|line| line.strip_prefix(MARK));
    verdict.map(str::to_owned)
}

/// Checks an entry point, and says what came of it.
pub fn check(row: &Row, shader: &Shader, seed: u64) {
    let gpu = common::gpu();
    if std::env::var_os(ORIGINAL).is_some() {
        run_original(&gpu, shader, &row.entry, seed);
        println!("{MARK}the original ran");
        return;
    }
    let mut job = Job::new(&row.entry);
    job.seed = seed;
    job.size = SIZE;
    job.cases = 16;
    job.options = match &row.choice {
        Some(choice) => choice.options.clone(),
        None => Options::default(),
    };
    let outcome = match vrcs::check::check(
        &gpu,
        &shader.source,
        &shader.module,
        &shader.info,
        &job,
        &mut |_| {},
    ) {
        Ok(report) if report.verdict == Verdict::Failed => {
            let failure = report.failure.map(|failure| vrcs::check::Failure {
                picture: Vec::new(),
                ..failure
            });
            format!("FAILED: {failure:?}")
        }
        Ok(report) => format!("{:?}: {}", report.verdict, report.why.unwrap_or_default()),
        Err(error) => format!("not checked: {error}"),
    };
    println!("{MARK}{}", outcome.replace('\n', " "));
}

/// Runs an entry point as its author wrote it, with the inputs of a check.
fn run_original(gpu: &Gpu, shader: &Shader, entry: &str, seed: u64) {
    let (module, info) = (&shader.module, &shader.info);
    let is_entry = |e: &naga::EntryPoint| e.stage == naga::ShaderStage::Compute && e.name == entry;
    let index = module.entry_points.iter().position(is_entry);
    let index = index.expect("the entry point");
    let settings = Settings {
        set: BTreeMap::new(),
        files: BTreeMap::new(),
    };
    let uses = info.get_entry_point(index);
    let written = |global: naga::Handle<naga::GlobalVariable>| {
        uses[global].intersects(GlobalUse::WRITE | GlobalUse::ATOMIC)
    };
    let resources = reflect::resources(module, info, index).expect("resources");
    let maker = Maker::new(gpu, module, &settings, SIZE, 1);
    let seeds = Seeds {
        uniforms: seed,
        data: seed.wrapping_mul(31),
        breadth: 0,
        reach: 0,
    };
    let made = maker.make(&resources, &written, seeds).expect("inputs");
    let immediates = maker.immediates(seed, 0);
    let program = Program::new(
        gpu,
        Build {
            label: "original",
            module,
            info,
            entry: index,
            code: Code::Module,
            constants: &inputs::constants(module, &settings),
            immediate_size: immediates.len() as u32,
        },
    )
    .expect("a pipeline");
    program
        .run(gpu, &made, &[], &immediates, [2, 2, 1], &[])
        .expect("a run");
}
