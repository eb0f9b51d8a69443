//! A renderer's lighting pass, at variable rate. `plain.rs` is the same as it was; the README shows the difference.

use crate::renderer::{Outcome, Renderer};
use vrcs::{Analyser, Pass, PassOptions, Source, View, analyse::Frame};

pub fn light(renderer: &Renderer, frames: u32) -> Outcome {
    let size = renderer.size;
    let (device, queue, layout) = (&renderer.device, &renderer.queue, &renderer.layout);
    let source = Source::new("light.wgsl", include_str!("light.wgsl"));
    let lighting = Pass::new(device, &source, &PassOptions::with_layouts(&[Some(layout)]))?;
    let view = View::of_size(device, queue, size)?;
    let analyser = Analyser::of_colour(device, &view, &renderer.picture)?;

    for frame in 0..frames {
        let mut encoder = renderer.begin_frame(frame);
        let mut pass = encoder.begin_compute_pass(&Default::default());
        analyser.record(queue, &mut pass, &view, &Frame::numbered(size, frame))?;
        view.build_in(&mut pass)?;
        pass.set_bind_group(0, &renderer.group, &[]);
        lighting.dispatch(&mut pass, &view)?;
        drop(pass);
        renderer.end_frame(encoder);
    }
    renderer.report(&view)
}
