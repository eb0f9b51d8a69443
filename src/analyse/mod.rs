//! The analysis stage: from what a frame looked like to the shading rates of the next.

pub mod content;
pub mod luma;
