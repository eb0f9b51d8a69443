//! Checks each entry point in a process of its own: a driver may take it with it.
//!
//! Where it does, a second process runs the original alone. If that dies, too, the driver cannot run the shader; if it does not,
//! the rewrite is at fault. A child that runs for minutes is ended: some shaders are more than a software driver can compile or run.

use std::{
    collections::BTreeMap,
    io::Read,
    process::{Command, Stdio},
    time::{Duration, Instant},
};

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

/// How long a child may run: in the gate, which picks a few by chance, only as long as most take.
fn limit() -> Duration {
    match std::env::var_os("VRCS_CORPUS") {
        Some(_) => Duration::from_secs(240),
        None => Duration::from_secs(30),
    }
}

/// What a child said, or why it said nothing.
enum Said {
    Verdict(String),
    Died,
    RanOut,
}

/// What becomes of an entry point in a child.
pub fn outcome(name: &str, seed: u64) -> String {
    let ran_out = || format!("not finished within {} s", limit().as_secs());
    match child(name, seed, &[]) {
        Said::Verdict(verdict) => return verdict,
        Said::RanOut => return ran_out(),
        Said::Died => {}
    }
    match child(name, seed, &[(ORIGINAL, "1")]) {
        Said::Died => "not runnable: the driver dies of the original alone".to_owned(),
        Said::RanOut => ran_out(),
        Said::Verdict(_) => "FAILED: the driver dies, and not of the original alone".to_owned(),
    }
}

fn child(name: &str, seed: u64, env: &[(&str, &str)]) -> Said {
    let test = std::env::current_exe().expect("this test");
    let mut child = Command::new(test)
        .args(["what_is_rewritten_keeps_the_laws", "--exact", "--nocapture"])
        .env(NAME, name)
        .env("VRCS_SEED", seed.to_string())
        .envs(env.iter().copied())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("a child");
    let mut pipe = child.stdout.take().expect("a pipe");
    let reader = std::thread::spawn(move || {
        let mut said = Vec::new();
        pipe.read_to_end(&mut said).expect("what the child says");
        said
    });
    let start = Instant::now();
    let has_ended = loop {
        if child.try_wait().expect("a child").is_some() {
            break true;
        }
        if start.elapsed() > limit() {
            break false;
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    if !has_ended {
        child.kill().expect("a child to end");
        child.wait().expect("its end");
    }
    let said = reader.join().expect("a reader");
    let said = String::from_utf8_lossy(&said);
    let verdict = said.lines().find_map(|line| line.strip_prefix(MARK));
    match (verdict, has_ended) {
        (Some(verdict), _) => Said::Verdict(verdict.to_owned()),
        (None, true) => Said::Died,
        (None, false) => Said::RanOut,
    }
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
