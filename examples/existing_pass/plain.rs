//! A renderer's lighting pass, as it was. `variable.rs` is the same at variable rate; the README shows the difference.

use crate::renderer::{Outcome, Renderer};

pub fn light(renderer: &Renderer, frames: u32) -> Outcome {
    let size = renderer.size;
    let pipeline = renderer.compute_pipeline(include_str!("light.wgsl"));

    for frame in 0..frames {
        let mut encoder = renderer.begin_frame(frame);
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &renderer.group, &[]);
        pass.dispatch_workgroups(size[0].div_ceil(8), size[1].div_ceil(8), 1);
        drop(pass);
        renderer.end_frame(encoder);
    }
    Ok(())
}
