//! Several views of one renderer.

use vrcs::{
    Analyser, Rate, View,
    analyse::{Frame, FrameError},
    plan::{Binding, ColourForm},
};

use crate::{
    common,
    renderer::{SIZE, picture},
};

#[test]
fn two_eyes_share_pipelines_and_nothing_else() {
    let gpu = common::gpu();
    let layers = wgpu::TextureDescriptor {
        size: wgpu::Extent3d {
            depth_or_array_layers: 2,
            ..picture(SIZE).size
        },
        usage: picture(SIZE).usage | wgpu::TextureUsages::COPY_DST,
        ..picture(SIZE)
    };
    let both = gpu.device.create_texture(&layers);
    // the left eye saw one grey, the right one noise
    let noise: Vec<u8> = (0..SIZE[0] * SIZE[1] * 4)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8)
        .collect();
    for (layer, pixels) in [vec![128; noise.len()], noise].iter().enumerate() {
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d {
                    z: layer as u32,
                    ..Default::default()
                },
                ..both.as_image_copy()
            },
            pixels,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(SIZE[0] * 4),
                rows_per_image: None,
            },
            picture(SIZE).size,
        );
    }
    let eye = |layer| {
        both.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: layer,
            array_layer_count: Some(1),
            ..Default::default()
        })
    };
    let left = View::of_size(&gpu.device, &gpu.queue, SIZE).expect("a view");
    let right = left
        .another(&gpu.queue, [64, 48, 1], "right eye")
        .expect("another");
    let codes = ColourForm::Codes;
    let of_left = Analyser::of_view(&gpu.device, &left, &eye(0), codes).expect("left");
    let seen = eye(1);
    let resources = [(Binding::Colour, wgpu::BindingResource::TextureView(&seen))];
    let of_right = of_left.another(&right, &resources).expect("right");
    let mut encoder = gpu.encoder();
    let mut compute = encoder.begin_compute_pass(&Default::default());
    for (analyser, view) in [(&of_left, &left), (&of_right, &right)] {
        analyser
            .record(&gpu.queue, &mut compute, view, &Frame::of_size(SIZE))
            .expect("a frame");
        view.build_in(&mut compute).expect("no coverage");
    }
    let crossed = of_left.record(&gpu.queue, &mut compute, &right, &Frame::of_size(SIZE));
    assert_eq!(crossed, Err(FrameError::Stale), "the other eye's rates");
    drop(compute);
    let read = gpu
        .submit_and_read(encoder, &[left.sri(), right.sri()])
        .expect("read");
    let share = |bytes: &[u8], rate: Rate| {
        let rows = bytes.chunks(256).take(24);
        let quads: Vec<u8> = rows.flat_map(|row| row[..32].to_vec()).collect();
        quads.iter().filter(|&&code| code == rate.code()).count() as f64 / quads.len() as f64
    };
    assert_eq!(share(&read[0], Rate::R2X2), 1.0, "grey is coarse");
    assert!(share(&read[1], Rate::R2X2) < 1.0, "noise is finer");
}
