//! Kernels that only move what a stage has to move, in several shapes: the fastest of them is the floor.

use wgpu::BindingResource::TextureView;

use super::{
    Lab,
    machinery::{Colours, Machinery},
    stage::{self, Content, group, texture, whole},
};
use crate::{analyse::params::luma_pitch, check::gpu::Gpu, sri::SriLayout};

const TEXT: &str = include_str!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/shaders/bench/floors.wgsl"
));

/// A floor's pipeline, and its bind groups.
pub(super) struct Floor {
    pub(super) name: &'static str,
    pipeline: wgpu::ComputePipeline,
    groups: Vec<wgpu::BindGroup>,
    shape: [u32; 2],
}

impl Floor {
    /// Makes a floor from the resources of each rotated copy, for workgroups across and down.
    fn new(
        gpu: &Gpu,
        entry: &'static str,
        shape: [u32; 2],
        given: &[Vec<(u32, wgpu::BindingResource)>],
    ) -> Floor {
        let stage::Original { pipeline, layout } = stage::unchecked(gpu, TEXT, entry);
        Floor {
            name: entry,
            groups: given
                .iter()
                .map(|resources| group(gpu, &layout, resources))
                .collect(),
            pipeline,
            shape,
        }
    }

    pub(super) fn record(&self, pass: &mut wgpu::ComputePass, round: usize) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.groups[round % self.groups.len()], &[]);
        pass.dispatch_workgroups(self.shape[0], self.shape[1], 1);
    }
}

/// The floors of all stages.
pub(super) struct Floors {
    pub(super) read: Vec<Floor>,
    pub(super) empty: Floor,
    pub(super) luma: Floor,
    pub(super) build: Vec<Floor>,
    pub(super) copy: Vec<Floor>,
}

impl Floors {
    pub(super) fn new(lab: &Lab, machinery: &Machinery, colours: &Colours) -> Floors {
        let gpu = lab.gpu;
        let [width, height] = machinery.size;
        let sri = SriLayout::new(width, height);
        let uniform = |words: u32| {
            let frame = [width, height, words, sri.pitch / 4];
            let usage = wgpu::BufferUsages::UNIFORM;
            gpu.buffer("floor", bytemuck::cast_slice(&frame), usage)
        };
        let sri_words = sri.bytes() / 4;
        // the primaries' words in both lists, spread over the words of rates
        let primaries = machinery.primaries * f64::from(width) * f64::from(height);
        let per_word = (2.0 * primaries / sri_words as f64).round() as u32;
        let frame = uniform(per_word.next_multiple_of(4));
        let out = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("floor"),
            size: (sri_words * u64::from(per_word.next_multiple_of(4).max(4)) * 4).max(16),
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let format = wgpu::TextureFormat::Rgba8Unorm;
        let target = whole(&texture(gpu, machinery.size, format, Content::Picture, 900));
        let both = colours.colours.iter().zip(&colours.motions);
        let read: Vec<_> = both
            .map(|(colour, motion)| {
                vec![
                    (0, frame.as_entire_binding()),
                    (1, TextureView(colour)),
                    (2, TextureView(motion)),
                    (3, out.as_entire_binding()),
                ]
            })
            .collect();
        let rates = |index: usize| {
            let view = &machinery.views[index % machinery.views.len()];
            (4, view.sri().as_entire_binding())
        };
        let luma_frame = uniform(luma_pitch(width) / 4);
        let luma: Vec<_> = machinery
            .lumas
            .iter()
            .map(|luma| {
                vec![
                    (0, luma_frame.as_entire_binding()),
                    (3, out.as_entire_binding()),
                    (4, luma.as_entire_binding()),
                ]
            })
            .collect();
        let copied: Vec<_> = colours
            .colours
            .iter()
            .enumerate()
            .map(|(index, colour)| {
                vec![
                    (0, frame.as_entire_binding()),
                    (1, TextureView(colour)),
                    rates(index),
                    (5, TextureView(&target)),
                ]
            })
            .collect();
        let touched: Vec<_> = machinery
            .pictures
            .iter()
            .enumerate()
            .map(|(index, picture)| {
                vec![
                    (0, frame.as_entire_binding()),
                    rates(index),
                    (6, TextureView(picture)),
                ]
            })
            .collect();
        let moved = |binding| {
            (0..machinery.views.len())
                .map(|index| {
                    vec![
                        (0, frame.as_entire_binding()),
                        rates(index),
                        (binding, out.as_entire_binding()),
                    ]
                })
                .collect::<Vec<_>>()
        };
        let nothing = [vec![(3, out.as_entire_binding())]];
        let tiles = |x: u32, y: u32| [width.div_ceil(x), height.div_ceil(y)];
        let words = sri_words.div_ceil(64) as u32;
        let lines = [words.min(1024), words.div_ceil(1024)];
        let rows = (sri_words as u32).div_ceil(256);
        Floors {
            read: vec![
                Floor::new(gpu, "read_once", tiles(16, 16), &read),
                Floor::new(gpu, "read_grid", tiles(64, 32), &read),
                Floor::new(gpu, "read_lines", tiles(128, 32), &read),
                Floor::new(gpu, "read_squares", tiles(32, 32), &read),
            ],
            empty: Floor::new(gpu, "empty", tiles(128, 32), &nothing),
            luma: Floor::new(gpu, "read_luma", [rows, 1], &luma),
            build: vec![
                Floor::new(gpu, "build_words", lines, &moved(3)),
                Floor::new(gpu, "build_wide", lines, &moved(7)),
            ],
            copy: vec![
                Floor::new(gpu, "copy_pixels", tiles(16, 16), &copied),
                Floor::new(gpu, "touch_pixels", tiles(16, 16), &touched),
                Floor::new(gpu, "touch_quads", tiles(32, 32), &touched),
            ],
        }
    }
}
