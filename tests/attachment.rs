//! The hardware-VRS image: the GPU makes the bytes of its CPU twin, and no tile is coarser than any of its pixels.

mod common;

use fastrand::Rng;
use vrcs::{
    Rate,
    attach::{
        AdditionalRates, AttachOptions, AttachmentLayout, Encoding, Samples, Shading, Support,
        Tile, cpu::attach, gpu::Attacher,
    },
    check::{gpu::Gpu, rates::Pattern},
    sri::Sri,
};

const SIZES: [[u32; 2]; 12] = [
    [1, 1],
    [2, 3],
    [7, 9],
    [16, 16],
    [31, 33],
    [128, 32],
    [129, 33],
    [201, 1080],
    [1920, 1080],
    [8192, 5],
    [5, 2161],
    [515, 257],
];

fn options(tile: Tile) -> Vec<AttachOptions> {
    let with = |encoding, support, samples| AttachOptions {
        tile,
        encoding,
        support,
        samples,
    };
    let turing = Support::nv(16);
    let required = Support::vulkan([([2, 2], 0b101), ([2, 1], 0b101)]);
    vec![
        with(
            Encoding::D3d12,
            Support::d3d12(AdditionalRates::Yes),
            Samples::X1,
        ),
        with(
            Encoding::D3d12,
            Support::d3d12(AdditionalRates::No),
            Samples::X4,
        ),
        with(Encoding::Khr, required, Samples::X4),
        with(Encoding::Khr, turing.clone(), Samples::X2),
        with(Encoding::Nv, turing.clone(), Samples::X1),
        with(Encoding::NvSupersampled(Samples::X4), turing, Samples::X8),
    ]
}

/// Rates as the analysis gives them, now and then with bytes that are no code.
fn image(size: [u32; 2], case: u32, rng: &mut Rng) -> Sri {
    if case % 3 == 2 {
        return Sri::from_fn(size[0], size[1], |_, _| rng.u8(..));
    }
    if case % 3 == 1 {
        // coarse, so that tiles have something to lose
        let coarse = [0xA, 9, 6, 5];
        let base = coarse[rng.usize(..4)];
        let codes: [u8; 7] = Rate::ALL.map(Rate::code);
        return Sri::from_fn(size[0], size[1], |_, _| match rng.u32(..200) {
            0 => codes[rng.usize(..7)],
            _ => base,
        });
    }
    Pattern::of_case(rng.u32(0..24), Rate::R4X4).image(size[0], size[1], rng)
}

/// Runs the kernel over poison, and reads the buffer and the texture that it is copied to.
fn run(gpu: &Gpu, attacher: &Attacher, sri: &Sri, size: [u32; 2]) -> (Vec<u8>, Vec<u8>) {
    let layout = AttachmentLayout::new(size, attacher.options().tile);
    // what pads a row is 0, full rate: were it read, it would show
    let rates = gpu.buffer("rates", sri.bytes(), wgpu::BufferUsages::STORAGE);
    let buffer = gpu.buffer(
        "attachment",
        &vec![0xa5; layout.bytes() as usize],
        wgpu::BufferUsages::STORAGE,
    );
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("attachment"),
        size: wgpu::Extent3d {
            width: layout.width,
            height: layout.height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R8Uint,
        usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let copied = gpu.buffer(
        "copied",
        &vec![0; layout.bytes() as usize],
        wgpu::BufferUsages::STORAGE,
    );
    let mut bound = attacher
        .bind(&gpu.device, &rates, &buffer)
        .expect("storage buffers");
    attacher
        .set_size(&gpu.queue, &mut bound, size)
        .expect("buffers of that size");
    let mut encoder = gpu.encoder();
    attacher.record(
        &mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()),
        &bound,
    );
    layout.copy_to_texture(&mut encoder, &buffer, &texture);
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &copied,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(layout.pitch),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    let read = gpu
        .submit_and_read(encoder, &[&buffer, &copied])
        .expect("an attachment");
    (read[0].clone(), read[1].clone())
}

#[test]
fn the_gpu_makes_the_bytes_of_its_cpu_twin_and_they_copy_to_a_texture() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    for tile in Tile::ALL {
        for options in options(tile) {
            let attacher = Attacher::new(&gpu.device, options.clone()).expect("a device for it");
            for (case, size) in SIZES.into_iter().enumerate() {
                let sri = image(size, case as u32 + rng.u32(..3), &mut rng);
                let wanted = attach(&sri, size, &options);
                let (buffer, texture) = run(&gpu, &attacher, &sri, size);
                let layout = wanted.layout();
                for y in 0..layout.height {
                    let at = (y * layout.pitch) as usize;
                    let end = at + layout.width as usize;
                    assert_eq!(
                        buffer[at..end],
                        wanted.bytes()[at..end],
                        "{options:?} {size:?}, row {y}"
                    );
                    assert_eq!(
                        texture[at..end],
                        wanted.bytes()[at..end],
                        "the texture's row {y}"
                    );
                    let word = at + layout.width.next_multiple_of(4) as usize;
                    assert!(
                        buffer[end..word].iter().all(|&byte| byte == 0),
                        "a whole word"
                    );
                    let next = at + layout.pitch as usize;
                    assert!(
                        buffer[word..next].iter().all(|&byte| byte == 0xa5),
                        "padding"
                    );
                }
            }
        }
    }
}

#[test]
fn no_tile_is_coarser_than_any_of_its_pixels_and_none_is_finer_than_it_has_to_be() {
    let mut rng = Rng::with_seed(common::seed());
    for tile in Tile::ALL {
        let options = AttachOptions {
            tile,
            encoding: Encoding::Khr,
            support: Support::nv(16),
            samples: Samples::X1,
        };
        for case in 0..24 {
            let size = [rng.u32(1..200), rng.u32(1..200)];
            let sri = image(size, case, &mut rng);
            let attachment = attach(&sri, size, &options);
            let mut finest = vec![Rate::R4X4; (attachment.layout().bytes()) as usize];
            for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
                let asked = Rate::from_code_or_full(sri.code(x / 2, y / 2));
                let Shading::Coarse(rate) = attachment.shading_at(x, y) else {
                    panic!("neither culled nor supersampled");
                };
                assert!(
                    rate.is_within(asked),
                    "{size:?} {x} {y}: {rate}, asked {asked}"
                );
                let at = (y / tile.side() * attachment.layout().pitch + x / tile.side()) as usize;
                finest[at] = finest[at].meet(asked);
            }
            for (x, y) in (0..attachment.layout().height)
                .flat_map(|y| (0..attachment.layout().width).map(move |x| (x, y)))
            {
                let at = (y * attachment.layout().pitch + x) as usize;
                assert_eq!(attachment.texel(x, y), Some(finest[at].code()));
            }
        }
    }
}

#[test]
fn one_fine_quad_in_the_last_column_makes_its_partial_tile_fine_and_no_other() {
    let size = [131, 67];
    for tile in Tile::ALL {
        let options = &options(tile)[0];
        let sri = Sri::from_fn(size[0], size[1], |x, y| match (x, y) {
            (65, 33) => Rate::R1X2.code(),
            _ => Rate::R4X4.code(),
        });
        let attachment = attach(&sri, size, options);
        let last = (
            attachment.layout().width - 1,
            attachment.layout().height - 1,
        );
        for (x, y) in (0..=last.1).flat_map(|y| (0..=last.0).map(move |x| (x, y))) {
            let wanted = match (x, y) == last {
                true => Rate::R1X2,
                false => Rate::R4X4,
            };
            assert_eq!(
                attachment.texel(x, y),
                Some(wanted.code()),
                "{tile:?} {x} {y}"
            );
        }
        assert_eq!(attachment.texel(last.0 + 1, 0), None);
    }
}

// E24: an AND or a minimum of codes would give 2x4 or full rate
#[test]
fn a_tile_of_2x4_and_4x2_is_2x2() {
    let sri = Sri::from_fn(32, 32, |x, _| match x % 2 {
        0 => Rate::R2X4.code(),
        _ => Rate::R4X2.code(),
    });
    for tile in Tile::ALL {
        let attachment = attach(&sri, [32, 32], &options(tile)[0]);
        assert_eq!(attachment.texel(0, 0), Some(Rate::R2X2.code()));
    }
}
