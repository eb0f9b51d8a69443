//! The runtime in somebody's renderer: what a user can get wrong is told by an error, before wgpu panics over it; what they can set
//! reaches the shader; and a steady frame costs what wgpu itself costs.

#[path = "../common/mod.rs"]
mod common;

mod after;
mod allocations;
mod devices;
mod immediates;
mod layouts;
mod limits;
mod pictures;
mod renderer;
mod resize;
mod split;
mod states;
mod views;
