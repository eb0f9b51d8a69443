//! An existing compute pass of a renderer made variable-rate: `plain.rs` and `variable.rs` are before and after.
//!
//! Draws the same frames both ways, and writes `out/existing_plain.png` and `out/existing_variable.png`.

mod plain;
mod renderer;
#[path = "../support/mod.rs"]
mod support;
mod variable;

use renderer::{Outcome, Renderer};

const SIZE: [u32; 2] = [640, 360];
const FRAMES: u32 = 4;

fn main() -> Outcome {
    let renderer = Renderer::new(SIZE)?;
    plain::light(&renderer, FRAMES)?;
    let plain = renderer.read()?;
    variable::light(&renderer, FRAMES)?;
    let variable = renderer.read()?;

    let decibels = support::psnr(&plain, &variable);
    println!("PSNR       {decibels:.1} dB against full rate");
    support::save("existing_plain", SIZE, &plain)?;
    support::save("existing_variable", SIZE, &variable)?;
    if plain == variable {
        return Err("nothing was shaded coarsely".into());
    }
    if decibels < 35.0 {
        return Err("coarse shading shows: that is more than the threshold allows".into());
    }
    Ok(())
}
