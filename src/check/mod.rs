//! Checks a rewritten shader against the original, on a real driver.
//!
//! *Does*: makes up every resource that the shader binds; runs the original, and an instrumented build of it that
//! [logs](vrcs_passes::instrument) which invocation stores where; runs the rewritten shader over uniform, random and adversarial
//! shading rates; and holds the laws of the contract bit for bit:
//!
//! - **identity**: all rates 1×1 give the original;
//! - **off**: variable-rate shading switched off gives the original;
//! - **replication**: one rate everywhere gives the original at the primaries, repeated for their duplicates;
//! - **locality**: where rates are mixed, a group is what it is under its rate alone;
//! - **contract**: whatever the rates, each pixel of the domain holds its primary's values at its own places, and nothing else has
//!   changed;
//! - **partition**: each place is written exactly as often as the primary runs the store;
//! - **builder**: the GPU builds the same coordinate buffer as its CPU twin.
//!
//! *Guarantees*: what is expected comes from what the original was seen to do, never from the rewriter. A check
//! that could not have failed is *inconclusive*, never passed: an original that differs from itself, that stores where
//! another invocation stores, or that was never seen to reach one of its stores; an output that is the same
//! everywhere.

mod atomics;
mod builds;
pub mod compare;
pub mod coordinates;
mod exact;
mod given;
pub mod gpu;
pub mod inputs;
mod learn;
pub mod nan;
mod picture;
pub mod rates;
pub mod reference;
pub mod retired;
pub mod run;
mod session;
mod verdict;

use std::{collections::BTreeMap, fmt};

use serde::{Deserialize, Serialize};
use vrcs_passes::Options;

pub use session::{CheckError, check, check_rewritten};

use crate::Rate;

/// What to check.
#[derive(Clone, Debug)]
pub struct Job {
    /// The entry point.
    pub entry: String,
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// How many shading-rate images to try.
    pub cases: u32,
    /// Where all chance comes from.
    pub seed: u64,
    /// How the shader is rewritten.
    pub options: Options,
    /// What the user says of the inputs.
    pub settings: inputs::Settings,
    /// How the rewritten shader is handed to the driver.
    pub route: Route,
}

/// How the rewritten shader is handed to the driver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Route {
    /// As WGSL text, which is what `vrcs rewrite` writes; as the module where there is no text.
    #[default]
    Text,
    /// As naga's module, which is what the runtime hands over.
    Module,
}

impl Job {
    /// A job with the defaults of the program.
    pub fn new(entry: &str) -> Job {
        Job {
            entry: entry.to_owned(),
            size: [61, 47],
            cases: 64,
            seed: 1,
            options: Options::default(),
            settings: inputs::Settings::default(),
            route: Route::default(),
        }
    }

    /// The largest rate that the rewritten shader copies.
    pub fn largest(&self) -> Rate {
        self.options.max_rate.into()
    }
}

/// A law of the contract.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs, reason = "the module's documentation tells them")]
pub enum Law {
    Identity,
    Off,
    Replication,
    Locality,
    Contract,
    Partition,
    Builder,
}

impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Law::Identity => "identity",
            Law::Off => "off",
            Law::Replication => "replication",
            Law::Locality => "locality",
            Law::Contract => "contract",
            Law::Partition => "partition",
            Law::Builder => "builder",
        })
    }
}

/// How a check came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Every law held, in every case.
    Passed,
    /// A law did not hold.
    Failed,
    /// The check could not tell.
    Inconclusive,
    /// The driver cannot run the shader, or nothing can be made up for it.
    NotRunnable,
}

/// What came of a check.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The entry point.
    pub entry: String,
    /// The driver.
    pub adapter: String,
    /// How it came out.
    pub verdict: Verdict,
    /// In one sentence, unless it passed.
    pub why: Option<String>,
    /// How often each law was held.
    pub held: BTreeMap<Law, u32>,
    /// The first difference.
    pub failure: Option<Failure>,
    /// What the reader should know besides.
    pub notes: Vec<String>,
    /// The names of the resources that the shader stores to.
    pub targets: Vec<String>,
}

/// A difference, for the reader.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// The law that did not hold.
    pub law: Law,
    /// The number of the case.
    pub case: u32,
    /// Its shading rates.
    pub pattern: String,
    /// The logical extent.
    pub extent: [u32; 2],
    /// The resource.
    pub target: String,
    /// The place in it: a texel, or a byte.
    pub place: String,
    /// The pixel whose place it is.
    pub pixel: Option<[u32; 3]>,
    /// Its tile.
    pub tile: Option<[u32; 2]>,
    /// The pixel that is shaded for it.
    pub primary: Option<[u32; 3]>,
    /// The value that was to be there.
    pub expected: String,
    /// The value that is there.
    pub got: String,
    /// A picture, as PNG: each pixel of the extent green where it is right, red where it is wrong, grey where nothing is
    /// due; one pixel is a square of four.
    #[serde(skip)]
    pub picture: Vec<u8>,
}
