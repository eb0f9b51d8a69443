//! One analysis for both kinds of variable rate: the compute passes' shading-rate image, and the image that hardware
//! variable-rate shading reads while a renderer draws, for D3D12 and for Vulkan.
//!
//! wgpu does not expose hardware variable-rate shading; what is shown is the image, which goes to
//! `RSSetShadingRateImage` or to a `VkFragmentShadingRateAttachmentInfoKHR` through wgpu's `hal`. Prints the tiles.

#[path = "../support/mod.rs"]
mod support;

use support::{Gpu, Outcome};
use vrcs::{
    Analyser, Rate, Scene, View,
    analyse::{Frame, Settings},
    attach::{
        AdditionalRates, AttachOptions, AttachmentLayout, Encoding, Samples, Support, Tile,
        gpu::Attacher,
    },
    plan::Binding,
};
use wgpu::BindingResource::TextureView;

const SIZE: [u32; 2] = [256, 96];

fn main() -> Outcome {
    let gpu = Gpu::open()?;
    let device = &gpu.device;
    let picture = gpu.texture(SIZE, wgpu::TextureFormat::Rgba8Unorm);
    gpu.queue.write_texture(
        picture.as_image_copy(),
        &seen(),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(SIZE[0] * 4),
            rows_per_image: None,
        },
        picture.size(),
    );

    // the compute passes read the view's rates; what is drawn reads those without the extra half rate
    let view = View::of_size(device, &gpu.queue, SIZE)?;
    let drawn = View::of_size(device, &gpu.queue, SIZE)?;
    let scene = Scene {
        attachment: true,
        ..Scene::default()
    };
    let picture = support::whole(&picture);
    let analyser = Analyser::new(
        device,
        &view,
        &scene,
        &Settings::default(),
        &[
            (Binding::Colour, TextureView(&picture)),
            (Binding::Attachment, drawn.sri().as_entire_binding()),
        ],
    )?;

    for (name, encoding, support) in [
        (
            "D3D12",
            Encoding::D3d12,
            Support::d3d12(AdditionalRates::No),
        ),
        // what a device lists with `vkGetPhysicalDeviceFragmentShadingRatesKHR`: its rates and their samples
        (
            "Vulkan",
            Encoding::Khr,
            Support::vulkan([([2, 2], 1), ([2, 1], 1), ([1, 1], 1)]),
        ),
    ] {
        let options = AttachOptions {
            tile: Tile::T16,
            encoding,
            support,
            samples: Samples::X1,
        };
        let attacher = Attacher::new(device, options)?;
        let image = attacher.buffer(device, SIZE);
        let mut bound = attacher.bind(device, drawn.sri(), &image)?;
        attacher.set_size(&gpu.queue, &mut bound, SIZE)?;

        let mut encoder = gpu.encoder();
        let mut pass = encoder.begin_compute_pass(&Default::default());
        analyser.record(&gpu.queue, &mut pass, &view, &Frame::of_size(SIZE))?;
        attacher.record(&mut pass, &bound);
        drop(pass);
        // in a renderer: `layout.copy_to_texture(&mut encoder, &image, &attachment)`
        gpu.submit(encoder);

        let layout = AttachmentLayout::new(SIZE, Tile::T16);
        let texels = gpu.read(&image)?;
        println!("{name}, {} x {} tiles of 16:", layout.width, layout.height);
        let mut kinds = Vec::new();
        for row in texels.chunks(layout.pitch as usize) {
            let row = &row[..layout.width as usize];
            kinds.extend_from_slice(row);
            let words: Vec<String> = row.iter().map(|texel| format!("{texel:x}")).collect();
            println!("  {}", words.join(" "));
        }
        // smooth on the left, noise on the right
        let coarse = encoding.encode(Rate::R2X2, Samples::X1);
        if kinds[0] != coarse || kinds[kinds.len() - 1] != 0 {
            return Err(format!("{name}: the left should be 2x2 and the right 1x1").into());
        }
    }
    Ok(())
}

/// What the last frame looked like: a ramp on the left, noise on the right.
fn seen() -> Vec<u8> {
    let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
    pixels
        .flat_map(|(x, y)| {
            let noise = (x.wrapping_mul(2_654_435_761) ^ y.wrapping_mul(2_246_822_519)) >> 13;
            let grey = match x < SIZE[0] / 2 {
                true => 100 + x / 8,
                false => noise & 255,
            };
            [grey as u8, grey as u8, grey as u8, 255]
        })
        .collect()
}
