//! What becomes of a generated shader, and whether that is right.

use std::panic::{AssertUnwindSafe, catch_unwind};

use fastrand::Rng;
use vrcs::check::{Job, Law, Verdict, check_rewritten, gpu::Gpu};
use vrcs_passes::{
    Code, Color, Options, Rewritten, Source, emit, input,
    options::{FullTiles, MaxRate},
    rewrite,
};

use super::grammar::{Expect, Shader};

/// What became of a shader.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// Every law held.
    Held,
    /// Every law held, but a store was never reached, or an output was the same everywhere.
    HeldWhereSeen(String),
    /// It was refused, as it must be.
    Refused(Code),
    /// The check could not tell.
    Inconclusive(String),
    /// The driver cannot run it.
    NotRunnable(String),
    /// A defect.
    Bad(Bad),
}

/// A defect.
#[derive(Clone, Debug)]
pub struct Bad {
    pub kind: Kind,
    /// In words.
    pub what: String,
}

/// Kinds of defects; a shader that is being shrunk keeps its kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The generator's own: the shader is not valid.
    NotValid,
    Panicked,
    RefusedWrongly(Vec<Code>),
    NotRefused,
    NotWarned,
    NoText,
    Broken(Law),
}

impl Bad {
    /// Its kind, and the first line of what it says, without names and numbers.
    pub fn sort(&self) -> String {
        let line = self.what.lines().next().unwrap_or_default();
        let mut quoted = line.split('`').enumerate();
        let unnamed: Vec<&str> = quoted
            .by_ref()
            .filter(|(index, _)| index % 2 == 0)
            .map(|(_, part)| part)
            .collect();
        format!("{:?}: {}", self.kind, without_numbers(&unnamed.join("…")))
    }
}

impl Outcome {
    /// What it is counted as.
    pub fn label(&self) -> String {
        match self {
            Outcome::Held => "held".to_owned(),
            Outcome::HeldWhereSeen(why) => format!("held, but {why}"),
            Outcome::Refused(code) => format!("refused rightly: {code}"),
            Outcome::Inconclusive(why) => format!("inconclusive: {why}"),
            Outcome::NotRunnable(why) => format!("not runnable: {why}"),
            Outcome::Bad(bad) => format!("bad: {:?}", bad.kind),
        }
    }

    /// The kind of a defect.
    pub fn kind(&self) -> Option<Kind> {
        match self {
            Outcome::Bad(bad) => Some(bad.kind.clone()),
            _ => None,
        }
    }
}

/// How a shader is checked: options and picture come from its seed.
pub fn job(shader: &Shader, seed: u64) -> Job {
    let mut rng = Rng::with_seed(seed ^ 0x0b5);
    let mut job = Job::new("main");
    job.seed = seed;
    job.size = shader.size;
    job.cases = 16;
    job.options = Options {
        max_rate: [
            MaxRate::R2x2,
            MaxRate::R2x2,
            MaxRate::R4x4,
            MaxRate::R2x4,
            MaxRate::R4x2,
        ][rng.usize(0..5)],
        tile: [[16, 16], [16, 16], [16, 16], [8, 8], [32, 8], [16, 8]][rng.usize(0..6)],
        full_tiles: [FullTiles::Promote, FullTiles::Keep][rng.usize(0..2)],
        ..shader.options.clone()
    };
    job
}

fn caught<T>(work: impl FnOnce() -> T) -> Result<T, Bad> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|payload| Bad {
        kind: Kind::Panicked,
        what: match payload.downcast_ref::<String>() {
            Some(text) => text.clone(),
            None => format!("{:?}", payload.downcast_ref::<&str>()),
        },
    })
}

/// Rewrites a shader; a code if it was refused rightly.
pub fn rewritten(
    shader: &Shader,
    options: &Options,
) -> Result<Result<(naga::Module, naga::valid::ModuleInfo, Rewritten), Code>, Bad> {
    let bad = |kind, what: String| Err(Bad { kind, what });
    let source = Source::new("generated.wgsl", shader.text.clone());
    let (module, info) = match caught(|| input::wgsl(&source))? {
        Ok(parsed) => parsed,
        Err(invalid) => return bad(Kind::NotValid, invalid.rendered),
    };
    match caught(|| rewrite(&module, &info, "main", options))? {
        Ok(rewritten) if !matches!(shader.expect, Expect::Refused(_)) => {
            let is_told = |code: &Code| rewritten.warnings.iter().any(|(_, w)| w.code == *code);
            if let Some(left_out) = shader.warnings.iter().find(|code| !is_told(code)) {
                return bad(Kind::NotWarned, left_out.to_string());
            }
            match caught(|| emit::wgsl(&rewritten.module, &rewritten.info))? {
                Ok(_) => Ok(Ok((module, info, rewritten))),
                Err(error) => bad(Kind::NoText, error.to_string()),
            }
        }
        Ok(_) => bad(Kind::NotRefused, format!("{:?}", shader.expect)),
        Err(refusal) => {
            let codes: Vec<Code> = refusal.findings.iter().map(|f| f.code).collect();
            match &shader.expect {
                Expect::Refused(code) | Expect::Either(code) if codes.contains(code) => {
                    Ok(Err(*code))
                }
                _ => bad(
                    Kind::RefusedWrongly(codes),
                    refusal.render(&source, Color::Never),
                ),
            }
        }
    }
}

/// Rewrites a shader, and checks it.
pub fn judge(gpu: &Gpu, shader: &Shader, seed: u64) -> Outcome {
    let job = job(shader, seed);
    let (module, info, rewritten) = match rewritten(shader, &job.options) {
        Ok(Ok(rewritten)) => rewritten,
        Ok(Err(code)) => return Outcome::Refused(code),
        Err(bad) => return Outcome::Bad(bad),
    };
    let source = Source::new("generated.wgsl", shader.text.clone());
    let report =
        caught(|| check_rewritten(gpu, &source, &module, &info, &rewritten, &job, &mut |_| {}));
    let report = match report {
        Ok(Ok(report)) => report,
        Ok(Err(error)) => return Outcome::NotRunnable(error.to_string()),
        Err(bad) => return Outcome::Bad(bad),
    };
    let why = report.why.clone().unwrap_or_default();
    match report.verdict {
        Verdict::Passed => Outcome::Held,
        Verdict::Failed => {
            let failure = report.failure.expect("a failure");
            Outcome::Bad(Bad {
                kind: Kind::Broken(failure.law),
                what: format!(
                    "{:?}",
                    vrcs::check::Failure {
                        picture: Vec::new(),
                        ..failure
                    }
                ),
            })
        }
        Verdict::Inconclusive => {
            let is_unseen = why.contains("never reached") || why.contains("same everywhere");
            match is_unseen && report.held.contains_key(&Law::Contract) {
                true if why.contains("never") => {
                    Outcome::HeldWhereSeen("a store was never reached".to_owned())
                }
                true => Outcome::HeldWhereSeen("a target is the same everywhere".to_owned()),
                false => Outcome::Inconclusive(without_numbers(&why)),
            }
        }
        Verdict::NotRunnable => Outcome::NotRunnable(without_numbers(&why)),
    }
}

/// A sentence without the numbers in it, so that like ones are counted together.
fn without_numbers(text: &str) -> String {
    let text: String = text
        .chars()
        .map(|c| if c.is_ascii_digit() { '#' } else { c })
        .collect();
    text.chars().take(110).collect()
}
