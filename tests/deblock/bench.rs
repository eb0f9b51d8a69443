//! Runs a deblocker on a scene, on the GPU.

use std::{cell::RefCell, rc::Rc};

use vrcs::{
    check::gpu::{Gpu, adapters},
    deblock::{Counters, Deblocker, Inputs, Luma, Options, Picture, PictureInput, luma_pitch},
};
use wgpu::TextureFormat;

use crate::{
    case::{Case, packing_of},
    common,
};

/// What the GPU made of a case.
pub struct Got {
    pub colors: Vec<[f32; 4]>,
    /// The picture's words as they lie in memory.
    pub words: Vec<u32>,
    pub counters: Counters,
    pub luma: Vec<u8>,
}

pub struct Bench {
    pub gpu: Gpu,
    pub adapter: wgpu::Adapter,
    /// Pipelines that were made, by what for: making one takes longer than running it.
    pub made: RefCell<Vec<(Options, bool, Rc<Deblocker>)>>,
}

impl Bench {
    pub fn new() -> Bench {
        let gpu = common::gpu();
        let adapter = adapters()
            .into_iter()
            .find(|adapter| adapter.get_info().name == gpu.info.name)
            .expect("the adapter of the device");
        Bench {
            gpu,
            adapter,
            made: RefCell::default(),
        }
    }

    pub fn texture(
        &self,
        format: TextureFormat,
        [width, height]: [u32; 2],
        texel: u32,
        bytes: &[u8],
    ) -> wgpu::Texture {
        let storage = match format {
            TextureFormat::R32Float | TextureFormat::R8Uint => wgpu::TextureUsages::empty(),
            _ => wgpu::TextureUsages::STORAGE_BINDING,
        };
        let size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        };
        let texture = self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("test"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: storage
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_DST
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        self.gpu.queue.write_texture(
            texture.as_image_copy(),
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * texel),
                rows_per_image: None,
            },
            size,
        );
        texture
    }

    pub fn deblocker(
        &self,
        case: &Case,
        picture: Picture,
        luma: Option<Luma>,
        with_adapter: bool,
    ) -> Rc<Deblocker> {
        let options = Options {
            luma,
            ..case.options(picture)
        };
        let mut made = self.made.borrow_mut();
        let known = made
            .iter()
            .find(|(known, adapter, _)| *known == options && *adapter == with_adapter);
        if let Some((_, _, deblocker)) = known {
            return deblocker.clone();
        }
        let deblocker = Deblocker::new(
            &self.gpu.device,
            with_adapter.then_some(&self.adapter),
            options,
        );
        let deblocker = Rc::new(deblocker.unwrap_or_else(|error| panic!("{error}")));
        made.push((options, with_adapter, deblocker.clone()));
        deblocker
    }

    pub fn run(&self, case: &Case, picture: Picture) -> Got {
        self.run_with(&self.deblocker(case, picture, None, true), case)
    }

    pub fn run_with(&self, deblocker: &Deblocker, case: &Case) -> Got {
        let picture = deblocker.options().picture;
        let packing = packing_of(picture);
        let [width, height] = case.extent;
        // a picture is larger than the extent: what lies beyond is poison, and has to survive
        let room = [width + 3, height + 2];
        let poison = packing.pack([0.125, 0.25, 0.5, 1.0]);
        let mut words = Vec::new();
        for y in 0..room[1] {
            for x in 0..room[0] {
                words.extend(match x < width && y < height {
                    true => packing.pack(case.colors[(y * width + x) as usize]),
                    false => poison.clone(),
                });
            }
        }
        let bytes: &[u8] = bytemuck::cast_slice(&words);
        let texel = packing.words() * 4;
        let rates = self
            .gpu
            .buffer("rates", case.rates.bytes(), wgpu::BufferUsages::STORAGE);
        let pitch = luma_pitch(width);
        let luma = self.gpu.buffer(
            "luma",
            &vec![0xa5; (pitch * height) as usize],
            wgpu::BufferUsages::STORAGE,
        );
        let view =
            |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let depth = case.depth.as_ref().map(|(_, values)| {
            view(&self.texture(
                TextureFormat::R32Float,
                case.extent,
                4,
                bytemuck::cast_slice(values),
            ))
        });
        let surfaces = case.surfaces.as_ref().map(|values| {
            let bytes: Vec<u8> = values.iter().map(|&v| v as u8).collect();
            view(&self.texture(TextureFormat::R8Uint, case.extent, 1, &bytes))
        });
        let format = match picture {
            Picture::Texture(format) => Some(format),
            Picture::R32Uint(_) => Some(TextureFormat::R32Uint),
            Picture::Buffer(_) => None,
        };
        let texture = format.map(|format| self.texture(format, room, texel, bytes));
        let texture_view = texture.as_ref().map(view);
        let buffer = self
            .gpu
            .buffer("picture", bytes, wgpu::BufferUsages::STORAGE);
        let inputs = Inputs {
            picture: match &texture_view {
                Some(view) => PictureInput::Texture(view),
                None => PictureInput::Buffer(&buffer, room[0]),
            },
            rates: &rates,
            depth: depth.as_ref(),
            surfaces: surfaces.as_ref(),
            luma: deblocker.options().luma.is_some().then_some(&luma),
        };
        let mut bound = deblocker
            .bind(&self.gpu.device, &inputs)
            .unwrap_or_else(|e| panic!("{e}"));
        deblocker
            .set_frame(&self.gpu.queue, &mut bound, case.extent, case.order)
            .unwrap_or_else(|e| panic!("{e}"));
        let mut encoder = self.gpu.encoder();
        deblocker.record(&mut encoder, &bound).expect("a frame");
        let row = (room[0] * texel).next_multiple_of(256);
        let read = self.gpu.buffer(
            "read",
            &vec![0; (row * room[1]) as usize],
            wgpu::BufferUsages::empty(),
        );
        if let Some(texture) = &texture {
            encoder.copy_texture_to_buffer(
                texture.as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: &read,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(row),
                        rows_per_image: None,
                    },
                },
                texture.size(),
            );
        }
        let result = texture.as_ref().map_or(&buffer, |_| &read);
        let nothing = self.gpu.buffer(
            "no counters",
            bytemuck::bytes_of(&Counters::default()),
            wgpu::BufferUsages::empty(),
        );
        assert_eq!(bound.counters().is_some(), case.is_counted);
        let counted = bound.counters().unwrap_or(&nothing);
        let got = self
            .gpu
            .submit_and_read(encoder, &[result, counted, &luma])
            .unwrap_or_else(|error| panic!("{error}"));
        let all: Vec<u32> = bytemuck::pod_collect_to_vec(&got[0]);
        let stride = match texture {
            Some(_) => row / 4,
            None => room[0] * packing.words(),
        };
        let mut words = Vec::new();
        for y in 0..room[1] {
            for x in 0..room[0] {
                let at = (y * stride + x * packing.words()) as usize;
                let pixel = &all[at..at + packing.words() as usize];
                match x < width && y < height {
                    true => words.extend_from_slice(pixel),
                    false => assert_eq!(pixel, poison, "wrote beyond the extent at {x},{y}"),
                }
            }
        }
        Got {
            colors: words
                .chunks_exact(packing.words() as usize)
                .map(|pixel| packing.unpack(pixel).unwrap())
                .collect(),
            words,
            counters: bytemuck::pod_read_unaligned(&got[1]),
            luma: (0..height as usize)
                .flat_map(|y| got[2][y * pitch as usize..][..width as usize].to_vec())
                .collect(),
        }
    }
}
