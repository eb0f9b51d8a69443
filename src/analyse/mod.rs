//! The analysis stage: from what a frame looked like to how coarse the next may be.
//!
//! | room | what | source |
//! |---|---|---|
//! | [`content`] | error of a quad, Eq. 2, 15, 16 | Yang et al., I3D 2019, §3 |
//! | [`luma`] | Eq. 25 | §5.1 |
//! | [`motion`] | b_H, b_Q, standalone, ladder: Eq. 20 to 24 | §4; Wicked Engine |
//! | [`hysteresis`] | ε and gains by norm | §5.4 |
//! | [`refit`] | k, b_H and b_Q by their definitions | Eq. 13, 17 to 19 |
//! | [`reproject`] | camera motion from depth and matrices | §5.2 |
//! | [`tiles`] | the stage by tiles of 16×16 pixels | GDC, passes 1 and 2 |
//! | [`decide`] | what a quad or a tile gets | Eq. 16 and 22; GDC pass 2; DOOM |
//! | [`smoothing`] | limits between neighbours | §5.4; GDC pass 3 |
//! | [`optics`] | a camera's motion on the GPU, a lens's blur | §5.2; DOOM, "Post Process Blurs" |
//! | [`own`] | the application's own rates, by combiners | GDC; Wicked Engine |
//! | [`half`] | rates of half the resolution | DOOM, "VRCS on Half Res?" |
//! | [`peers`] | what others decide by, as settings | research, table B |
//! | [`settings`] | every effect's parameters | |
//! | [`inputs`] | what goes in and what comes out | |
//! | [`exact`] | the oracle, in f64 | |
//! | [`integer`] | the deterministic path on the CPU: arithmetic; `pipeline.rs`, `past.rs` and `decide.rs` have its steps | |
//! | [`analyser`] | the stage of one view in one piece | |
//! | [`gpu`] | the deterministic path on the GPU, by [`Plan`](crate::plan::Plan) | |
//!
//! ```
//! use vrcs::analyse::{integer, Inputs, Colour, Settings};
//! let picture = vec![[90, 90, 90, 255]; 64];
//! let inputs = Inputs::of_colour([8, 8], Colour::Codes(&picture));
//! let found = integer::analyse(&inputs, &Settings::default()).expect("inputs that fit");
//! assert_eq!(found.sri, vrcs::sri::Sri::uniform(8, 8, vrcs::Rate::R2X2));
//! ```

mod after;
pub mod analyser;
pub mod content;
pub mod decide;
pub mod exact;
pub mod fixed;
pub mod gpu;
mod granularity;
pub mod half;
pub mod hysteresis;
pub mod inputs;
pub mod integer;
pub mod luma;
pub mod motion;
pub mod optics;
pub mod own;
pub mod params;
mod past;
pub mod peers;
mod pipeline;
pub mod reasons;
pub mod refit;
pub mod reproject;
mod resources;
pub mod settings;
pub mod smoothing;
pub mod tiles;
#[cfg(feature = "cli")]
pub(crate) mod written;

#[cfg(test)]
mod tests;

pub use analyser::{Analyser, AnalyserError};
pub use gpu::{Analysis, BindError};
pub use half::HalfResolution;
pub use inputs::{Colour, Frame, FrameError, Inputs, Output, WrongInput};
pub use optics::{Cameras, Lens};
pub use own::OwnRates;
pub use peers::Peer;
pub use reasons::Reason;
pub use settings::{Granularity, Settings};
