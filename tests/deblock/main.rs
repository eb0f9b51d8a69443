//! The deblocker: where its taps lie, what it leaves alone, what it does not let through, and that it equals its twin.

mod bench;
mod case;
#[path = "../common/mod.rs"]
mod common;
mod edges;
mod inputs;
mod luma;
mod taps;
mod twin;
