//! tmp
#![allow(missing_docs)]
pub mod build;
#[cfg(feature = "cli")]
pub mod check;
pub mod dispatch;
mod kernel;
pub mod rate;
pub mod sri;
pub mod view;
pub use rate::Rate;
