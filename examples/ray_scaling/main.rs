//! Graded mode: every pixel runs, and fires the fewer rays the more pixels share its work (slides, "Non-binary use of VRCS!").
//!
//! The left half of the picture is at 2×2, the right at full rate. Counts the rays, holds them against what they should be, and
//! writes `out/rays.png`.

#[path = "../support/mod.rs"]
mod support;

use support::{Gpu, Outcome, whole};
use vrcs::{
    Pass, PassOptions, Rate, Source, View,
    build::{BuildOptions, Modes},
    sri::Sri,
};
use vrcs_passes::{Options, options::Mode};
use wgpu::BindingResource::TextureView;

const SIZE: [u32; 2] = [480, 270];
/// As in the shader.
const RAYS: f64 = 10.0;
const FRAMES: u32 = 8;

fn main() -> Outcome {
    let gpu = Gpu::open()?;
    let source = Source::new("rays.wgsl", include_str!("rays.wgsl"));
    let options = PassOptions {
        rewrite: Options {
            mode: Mode::Graded,
            ..Options::default()
        },
        ..PassOptions::default()
    };
    let rays = Pass::new(&gpu.device, &source, &options)?;
    let built = BuildOptions {
        modes: Modes::NONE.with(Mode::Graded),
        ..BuildOptions::default()
    };
    let view = View::new(&gpu.device, &gpu.queue, [SIZE[0], SIZE[1], 1], built)?;
    let half = SIZE[0] / 4;
    let rates = Sri::from_fn(SIZE[0], SIZE[1], |x, _| match x < half {
        true => Rate::R2X2.code(),
        false => Rate::R1X1.code(),
    });
    view.write_sri(&gpu.queue, &rates)?;

    let picture = gpu.texture(SIZE, wgpu::TextureFormat::Rgba8Unorm);
    let frame = gpu.uniform(16);
    let fired = gpu.storage(u64::from(SIZE[0] * SIZE[1]) * 4);
    let group = gpu.group(
        rays.bind_group_layout(0).ok_or("no bind group")?,
        &[
            (0, frame.as_entire_binding()),
            (1, TextureView(&whole(&picture))),
            (2, fired.as_entire_binding()),
        ],
    );
    // of the left half and of the right
    let mut sums = [0u64; 2];
    for number in 0..FRAMES {
        let words = [SIZE[0], SIZE[1], number, 0];
        gpu.queue
            .write_buffer(&frame, 0, bytemuck::cast_slice(&words));
        let mut encoder = gpu.encoder();
        let mut pass = encoder.begin_compute_pass(&Default::default());
        view.build_in(&mut pass)?;
        pass.set_bind_group(0, &group, &[]);
        rays.dispatch(&mut pass, &view)?;
        drop(pass);
        gpu.submit(encoder);
        let counts = gpu.read(&fired)?;
        for (index, count) in bytemuck::cast_slice::<u8, u32>(&counts).iter().enumerate() {
            let side = usize::from(index as u32 % SIZE[0] >= 2 * half);
            sums[side] += u64::from(*count);
        }
    }
    support::save("rays", SIZE, &gpu.read_texture(&picture)?)?;
    let pixels = f64::from(SIZE[0] * SIZE[1] / 2 * FRAMES);
    let [shared, alone] = sums.map(|sum| sum as f64 / pixels);
    println!("rays       {shared:.3} a pixel at 2x2, {alone:.3} at full rate");
    // a pixel's number is one of two neighbours, so at most half from the mean on average: five standard errors
    let bound = 5.0 * 0.5 / pixels.sqrt();
    match (shared - RAYS / 4.0).abs() < bound && alone == RAYS {
        true => Ok(()),
        false => Err("each pixel should fire 10 / (1 + copies) rays on average".into()),
    }
}
