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
//! ```text
//! rates of four quads        who is shaded            what each pixel shows
//!   2x2   2x1                A . B .                  A A B B
//!                            . . C .                  A A C C
//!   1x1   2x2                D E F .                  D E F F
//!                            G H . .                  G H F F
//! ```
//!
//! # The contract
//!
//! Every pixel of the extent and of the shader's own domain gets, *at the addresses that it would have written itself*, the values of
//! its primary; and nothing else is written. Some of what follows:
//!
//! - at 1×1 everywhere it is the original, bit for bit;
//! - a store must go to an address that is computed from the invocation's ids, uniforms and read-only memory, since a duplicate's address
//!   is computed and its value is not: another shader is refused, with the line and what to do;
//! - what a primary reads is read at the *primary's* place: half a pixel off, for which the [deblocker](deblock) is there;
//! - a picture that a pass reads at its neighbours must be another than the one that it writes (a ping-pong pair).
//!
//! `vrcs check light.wgsl` holds this against your shader on your driver; `vrcs explain light.wgsl` tells how each store was understood.
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
//! [`Mode::Auto`](vrcs_passes::options::Mode::Auto), the default of a [`Pass`], chooses tiled or list and [says why](Pass::mode).
//!
//! # What a pass and a view have to agree on
//!
//! A pass is made for a mode, a tile and a largest rate; a view builds for some. [`View::of_size`] builds what a pass of default options
//! needs. For anything else, ask the pass: [`Pass::build_options`] adds to your wishes what it needs, and [`Pass::check`], which every
//! dispatch makes, too, says what does not fit.
//!
//! ```no_run
//! # fn f(device: &wgpu::Device, queue: &wgpu::Queue, light: &vrcs::Pass, shadow: &vrcs::Pass) -> Result<(), Box<dyn std::error::Error>> {
//! use vrcs::{View, build::BuildOptions};
//!
//! let wishes = BuildOptions { effective: true, ..BuildOptions::default() }; // effective rates, for a deblocker
//! let built = shadow.build_options(light.build_options(wishes)); // one view for both
//! let view = View::new(device, queue, [1920, 1080, 1], built)?;
//! light.check(&view)?;
//! shadow.check(&view)?; // an error if their tiles differ: then it takes two views
//! # Ok(())
//! # }
//! ```
//!
//! # Choosing settings
//!
//! 1. Start with [`analyse::Settings::default`] and what the renderer has: [`Scene`] declares it, and the [`Plan`] has no part for
//!    what is not declared. `vrcs plan` prints one.
//! 2. Look: `vrcs analyse frame.png --overlay rates.png` shows a frame's rates and [reasons](analyse::reasons) without a line of code.
//! 3. Detail is lost: lower the [threshold](analyse::settings::Content::threshold) before anything else; 0.15 is the paper's, for a 4K
//!    display at arm's length, and large pixels want less (0.06 at 720p).
//! 4. Silhouettes crawl: declare ids or depth as [coverage](coverage::Coverage), so that a quad across an edge has a primary on each side.
//! 5. Blocks show on smooth surfaces: [deblock] them.
//! 6. Rates flicker: [stability](analyse::settings::Stability). Under temporal anti-aliasing, and only there, [rotate](View::rotate) primaries.
//! 7. It does not pay: a pass has to take longer than the analysis and the build, which all passes of a view share, divided by the share
//!    of pixels that are not shaded. Give light passes their original pipeline.
//!
//! # Several views
//!
//! *The two eyes of a headset*, in two layers or textures: [`View::another`] and [`Analyser::another`] make the second by the pipelines of
//! the first; each analyses its own layer ([`Analyser::of_view`]).
//!
//! *A split screen in one texture*: a view for each player, with the player's part as its extent and its place as its
//! [origin](View::set_origin). The analysis, the coverage and the deblocker look there, and pixels at its border do not look across it.
//! A shader adds the origin to its address itself, as it has to without this crate, since a dispatch starts at 0; such a store is rewritten
//! as it stands:
//!
//! ```no_run
//! # use vrcs::{Analyser, Pass, Scene, View, analyse::{Frame, Settings}, plan::Binding};
//! # fn f(device: &wgpu::Device, queue: &wgpu::Queue, light: &Pass, last: &wgpu::TextureView, compute: &mut wgpu::ComputePass,
//! #      players: &[wgpu::BindGroup; 2]) -> Result<(), Box<dyn std::error::Error>> {
//! // once: two halves of a picture of 1920x1080
//! let left = View::of_size(device, queue, [960, 1080])?;
//! let mut right = left.another(queue, [960, 1080, 1], "right")?;
//! right.set_origin([960, 0])?;
//! let scene = Scene { origin: true, ..Scene::default() };
//! let seen = [(Binding::Colour, wgpu::BindingResource::TextureView(last))];
//! let of_left = Analyser::new(device, &left, &scene, &Settings::default(), &seen)?;
//! let of_right = of_left.another(&right, &seen)?;
//!
//! // each frame; in WGSL: textureStore(picture, player.origin + id.xy, light)
//! for ((view, analyser), player) in [(&left, &of_left), (&right, &of_right)].into_iter().zip(players) {
//!     analyser.record(queue, compute, view, &Frame::of_view(view))?;
//!     view.build_in(compute)?;
//!     compute.set_bind_group(0, player, &[]);
//!     light.dispatch(compute, view)?;
//! }
//! # Ok(())
//! # }
//! ```
//!
//! *Several devices*: what is made with one belongs to it. What meets something of another says so ([`Mismatch::Device`]), also where
//! the two are of two instances, which wgpu itself does not tell apart.
//!
//! # When the window or the format changes
//!
//! [`View::set_extent`], then bind again what holds pictures or the view's buffers: [`View::cover`], [`Analyser::bind`],
//! [`Deblocker::bind`](deblock::Deblocker::bind), and bind groups of your own with [`Bindings`](dispatch::bindings::Bindings) if
//! [`View::generation`] is another. What was forgotten is an error at the next frame (`Uncovered`, `Stale`), but for those of your own. A
//! picture of another *format* is another shader (WGSL names the format), so another [`Pass`], and another [`Analyser`] where the form of its
//! colour changes; the view stays.
//!
//! # In a renderer
//!
//! The library takes the caller's device and records into the caller's encoder or compute pass. It never makes a device,
//! submits, polls, prints or exits, and what a user gets wrong is an error, not a panic. After the first frames it allocates nothing: what is
//! left is wgpu's own list of commands. Everything on the GPU has a label ([`ObjectOptions`]), each stage a debug group. What
//! it records lies in `tracing` spans, at the level of traces. wgpu's default limits and no feature are enough; what needs more ([`limits`])
//! says so before anything is made. The feature `cli` (on by default) adds the `vrcs` program and what it is made of:
//! `check`, which proves a rewrite on a driver, and `demo`; with it come wgpu's drivers, which the runtime alone
//! (`default-features = false`) leaves to your own dependency on wgpu.

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
mod flat;
mod home;
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
mod slots;
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
