//! Variable-rate compute shaders for wgpu.
//!
//! Most pixels of most frames look like their neighbours. This crate shades such pixels once and copies the result, in any
//! compute shader that stores per pixel, without a change in its source: [`vrcs_passes`] rewrites the shader, and this runtime
//! makes what the rewritten shader needs, in the caller's own renderer.
//!
//! - A [`View`] holds one picture's shading rates (a [shading-rate image](sri): one byte for each quad of 2×2 pixels) and the
//!   coordinate buffer that is [built](build) from them. In it, *primary* pixels are packed together, so that whole waves
//!   of *duplicates* find nothing to do and retire.
//! - [`coverage`] tells which pixels may share, from ids, depth and normals.
//! - A [`Pass`] is a rewritten shader as a pipeline. Any number of passes share a view.
//! - [`attach`] makes of the same rates the image that hardware variable-rate shading reads, for what is drawn.
//! - [`analyse`] tells from what a frame looked like how coarse the next may be.
//!
//! ```no_run
//! # fn f(device: &wgpu::Device, queue: &wgpu::Queue, encoder: &mut wgpu::CommandEncoder, group: &wgpu::BindGroup)
//! # -> Result<(), Box<dyn std::error::Error>> {
//! # let rates = vrcs::sri::Sri::uniform(1920, 1080, vrcs::Rate::R2X2);
//! // once
//! let source = vrcs_passes::Source::new("light.wgsl", std::fs::read_to_string("light.wgsl")?);
//! let light = vrcs::Pass::new(device, &source, &vrcs::PassOptions::default())?;
//! let view = vrcs::View::new(device, queue, [1920, 1080, 1], vrcs::build::BuildOptions::default())?;
//!
//! // each frame
//! view.write_sri(queue, &rates)?;
//! view.build(encoder)?;
//! let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
//! pass.set_bind_group(0, group, &[]);
//! light.dispatch(&mut pass, &view)?;
//! # Ok(())
//! # }
//! ```
//!
//! # Primaries and duplicates
//!
//! A rate of 2×2 says that the four pixels of a quad may look alike. One of them is the *primary*: its invocation runs, with the ids
//! that it would have had, and stores its result for all four. The others are its *duplicates*: their invocations do not run. A
//! [coordinate buffer](build) packs primaries together, so that the invocations which do not run fill whole waves, and a wave of
//! nothing retires at once. Where [coverage] says that two pixels of a quad lie on different surfaces, each surface has a
//! primary of its own.
//!
//! The contract: every pixel of the extent and of the shader's own domain gets, at the addresses that it would have written itself,
//! the values of its primary, and nothing else is written. At 1×1 everywhere that is the original, bit for bit.
//!
//! # Modes
//!
//! | mode | a group of invocations is | good for |
//! |---|---|---|
//! | tiled | a tile of 16×16; reads its count and its part of the payload | shaders with barriers; anything, since it needs no indirect dispatch |
//! | list | 64 entries of one list of the whole picture | heavy shaders: at most one wave of a picture is partly full |
//! | classified | a tile of one class: sky, whole, uniform, mixed | pictures that are mostly uniform |
//! | graded | what the author wrote: nothing is copied | rays: each pixel fires fewer, see [`vrcs_passes::graded`] |
//!
//! [`Mode::Auto`](vrcs_passes::options::Mode::Auto), the default of a [`Pass`], chooses and [says why](Pass::mode).
//!
//! # Choosing settings
//!
//! Start with [`analyse::Settings::default`] and what the renderer has: [`Scene`] declares it, and the [`Plan`] has no part for
//! what is not declared. Lower the threshold where detail is lost, before anything else; then declare ids or depth as
//! [coverage](coverage::Coverage), so that silhouettes stay sharp, and [deblock] what is left. Rotate primaries
//! ([`View::rotate`]) only under temporal anti-aliasing. A pass pays if it takes longer than the analysis and the build, which
//! passes share.
//!
//! # In a renderer
//!
//! The library takes the caller's device and records into the caller's encoder or compute pass. It never makes a device,
//! submits, polls, prints or exits. What it records lies in `tracing` spans, at the level of traces. The feature `cli` (on by
//! default) adds the `vrcs` program and what it is made of:
//! `check`, which proves a rewrite on a driver, and `demo`.

pub mod analyse;
#[cfg(feature = "cli")]
mod atomic;
pub mod attach;
#[cfg(feature = "cli")]
pub mod bench;
pub mod build;
#[cfg(feature = "cli")]
pub mod check;
pub mod classify;
#[cfg(feature = "cli")]
pub mod cli;
pub mod coverage;
pub mod deblock;
#[cfg(feature = "cli")]
pub mod demo;
pub mod dispatch;
mod kernel;
pub mod limits;
#[cfg(feature = "cli")]
pub mod metrics;
mod object;
#[cfg(feature = "cli")]
mod picture;
pub mod plan;
pub mod rate;
#[cfg(feature = "cli")]
pub mod scenes;
mod scope;
pub mod sri;
#[cfg(feature = "cli")]
pub mod tradeoff;
pub mod view;
#[cfg(feature = "cli")]
pub mod web;

pub use analyse::{Analyser, AnalyserError};
pub use dispatch::{Mismatch, Pass, PassError, PassOptions};
pub use limits::LimitError;
pub use object::ObjectOptions;
pub use plan::{Plan, Scene};
pub use rate::Rate;
pub use view::{View, ViewError};
pub use vrcs_passes::Source;
