//! A window changes, and nothing is left behind.

use vrcs::analyse::Frame;

use crate::renderer::{Drawn, SIZE};

/// A device of its own, whose objects can be counted.
struct Counted {
    instance: wgpu::Instance,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Counted {
    fn new() -> Counted {
        let descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        let instance = wgpu::Instance::new(descriptor);
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()));
        let adapter = adapter.expect("a driver");
        let (device, queue) =
            pollster::block_on(adapter.request_device(&Default::default())).expect("a device");
        Counted {
            instance,
            device,
            queue,
        }
    }

    /// Draws a frame, waits for it, and counts what there is then.
    fn draw(&self, drawn: &Drawn, size: [u32; 2]) -> [usize; 8] {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut compute = encoder.begin_compute_pass(&Default::default());
        drawn.record(&self.queue, &mut compute, &Frame::of_size(size));
        drop(compute);
        self.queue.submit([encoder.finish()]);
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .expect("done");
        let report = self.instance.generate_report().expect("a native backend");
        let hub = report.hub_report();
        [
            hub.buffers.num_allocated,
            hub.bind_groups.num_allocated,
            hub.textures.num_allocated,
            hub.texture_views.num_allocated,
            hub.compute_pipelines.num_allocated,
            hub.pipeline_layouts.num_allocated,
            hub.shader_modules.num_allocated,
            hub.bind_group_layouts.num_allocated,
        ]
    }
}

#[test]
fn nothing_is_left_behind_by_changes_of_format_and_size() {
    let counted = Counted::new();
    let (device, queue) = (&counted.device, &counted.queue);
    let mut drawn = Drawn::new(device, queue, SIZE);
    let mut live = Vec::new();
    for turn in 0..12u32 {
        let size = [40 + turn % 2 * 30, 48];
        let format = match turn % 4 {
            0 | 1 => wgpu::TextureFormat::Rgba16Float,
            _ => wgpu::TextureFormat::Rgba8Unorm,
        };
        drawn.reformat(device, queue, format, size);
        live.push(counted.draw(&drawn, size));
    }
    assert_eq!(live[4..8], live[8..], "{live:?}");
}

#[test]
fn nothing_is_left_behind_by_a_hundred_changes_of_size() {
    let counted = Counted::new();
    let (device, queue) = (&counted.device, &counted.queue);
    let mut drawn = Drawn::new(device, queue, SIZE);
    let mut live = Vec::new();
    for turn in 0..100u32 {
        let size = [40 + turn % 7 * 16, 30 + turn % 5 * 16];
        drawn.resize(device, queue, size);
        live.push(counted.draw(&drawn, size));
    }
    // once the buffers have grown to the largest size, each turn leaves what the one before left
    assert_eq!(live[40], live[99], "{live:?}");
}
