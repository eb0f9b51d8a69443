//! tmp
#![allow(missing_docs)]
pub mod analyse;
pub mod build;
#[cfg(feature = "cli")]
pub mod check;
#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "cli")]
pub mod demo;
pub mod dispatch;
mod kernel;
pub mod rate;
pub mod sri;
pub mod view;
pub use rate::Rate;
