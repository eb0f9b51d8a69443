//! One rate for each square area of several quads, as hardware attachments have: what a coarser granularity costs.
//!
//! *Does*: gives each area the finest of its quads' rates, axis by axis, in place. (One estimate for an area, over its own pixels, is
//! [`Settings::granularity`](crate::analyse::Settings::granularity).) *Guarantees*: no quad becomes coarser.

use bytemuck::{Pod, Zeroable};

use crate::{
    kernel::{self, shader},
    limits::LimitError,
    sri::{Sri, SriLayout},
};

#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Params {
    size: [u32; 2],
    pitch: u32,
    side: u32,
}

/// The kernel, bound to a shading-rate image.
#[derive(Debug)]
pub struct Granularity {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    groups: [u32; 2],
}

impl Granularity {
    /// For areas of `pixels` (4, 8 or 16) across, on the rates of a picture of `size`.
    ///
    /// # Errors
    /// If the device has too little for the kernel.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        rates: &wgpu::Buffer,
        size: [u32; 2],
        pixels: u32,
    ) -> Result<Granularity, LimitError> {
        let module = kernel::shader_module(device, shader!("granularity.wgsl"), &[])?;
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("granularity"),
            layout: None,
            module: &module,
            entry_point: Some("share"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let layout = SriLayout::new(size[0], size[1]);
        let params = Params {
            size: [layout.width, layout.height],
            pitch: layout.pitch / 4,
            side: pixels / 2,
        };
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("granularity"),
            size: size_of::<Params>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&buffer, 0, bytemuck::bytes_of(&params));
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("granularity"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: buffer.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: rates.as_entire_binding(),
                },
            ],
        });
        Ok(Granularity {
            pipeline,
            group,
            groups: [layout.width, layout.height].map(|quads| quads.div_ceil(64)),
        })
    }

    /// Records the kernel.
    pub fn record(&self, pass: &mut wgpu::ComputePass) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(self.groups[0], self.groups[1], 1);
    }
}

/// The CPU twin.
pub fn share(sri: &Sri, size: [u32; 2], pixels: u32) -> Sri {
    let side = pixels / 2;
    let layout = sri.layout();
    Sri::from_fn(size[0], size[1], |x, y| {
        let (left, top) = (x / side * side, y / side * side);
        let mut logs = [2; 2];
        for y in top..(top + side).min(layout.height) {
            for x in left..(left + side).min(layout.width) {
                let code = sri.code(x, y);
                logs = [logs[0].min(code >> 2 & 3), logs[1].min(code & 3)];
            }
        }
        logs[0] << 2 | logs[1]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rate;

    #[test]
    fn areas_of_one_rate_stay_and_others_take_the_finest_of_each_axis() {
        let size = [20, 20];
        let plain = Sri::uniform(20, 20, Rate::R4X2);
        assert_eq!(share(&plain, size, 8), plain);
        let mixed = Sri::from_fn(20, 20, |x, y| match (x, y) {
            (1, 1) => Rate::R2X1.code(),
            (2, 0) => Rate::R1X2.code(),
            _ => Rate::R2X2.code(),
        });
        let found = share(&mixed, size, 8);
        assert_eq!(found.code(0, 0), Rate::R1X1.code());
        assert_eq!(found.code(3, 3), Rate::R1X1.code());
        assert_eq!(found.code(4, 0), Rate::R2X2.code());
        assert_eq!(share(&mixed, size, 4).code(2, 1), Rate::R1X2.code());
    }
}
