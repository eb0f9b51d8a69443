//! What comes after shading: a deblocker and a classifier that are given what they cannot use.

use vrcs::{
    ObjectOptions, Rate, View,
    build::BuildOptions,
    check::gpu::Gpu,
    classify::{self, Class, Classifier, ClassifyError, Rule},
    deblock::{self, Bound, DeblockError, Deblocker, Inputs, Packing, Picture, PictureInput},
    sri::Sri,
};

use crate::{
    common,
    renderer::{SIZE, picture, texture_of},
};

/// A renderer whose picture is deblocked.
struct Deblocked {
    view: View,
    deblocker: Deblocker,
    bound: Bound,
}

fn effective() -> BuildOptions {
    BuildOptions {
        effective: true,
        ..BuildOptions::default()
    }
}

fn packed(device: &wgpu::Device, [width, height]: [u32; 2]) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture"),
        size: u64::from(width) * u64::from(height) * 4,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    })
}

impl Deblocked {
    fn new(gpu: &Gpu) -> Deblocked {
        let view = View::new(&gpu.device, &gpu.queue, [64, 48, 1], effective()).expect("a view");
        let options = deblock::Options::new(Picture::Buffer(Packing::Rgba8Unorm));
        let deblocker = Deblocker::new(&gpu.device, None, options).expect("a deblocker");
        let bound = Deblocked::bound(gpu, &deblocker, &view);
        Deblocked {
            view,
            deblocker,
            bound,
        }
    }

    fn bound(gpu: &Gpu, deblocker: &Deblocker, view: &View) -> Bound {
        let [width, height, _] = view.extent();
        let picture = packed(&gpu.device, [width, height]);
        let inputs = Inputs::of_view(view, PictureInput::Buffer(&picture, width));
        let inputs = inputs.expect("effective rates");
        deblocker.bind(&gpu.device, &inputs).expect("bound")
    }

    fn record(&self, gpu: &Gpu) -> Result<(), DeblockError> {
        let mut encoder = gpu.encoder();
        let mut compute = encoder.begin_compute_pass(&Default::default());
        let recorded =
            self.deblocker
                .record_view(&gpu.queue, &mut compute, &self.bound, &self.view);
        drop(compute);
        gpu.queue.submit([encoder.finish()]);
        gpu.check().expect("nothing of it came to the device");
        recorded
    }
}

#[test]
fn a_deblocker_that_was_not_bound_again_after_a_resize_refuses_the_old_rates() {
    let gpu = common::gpu();
    let mut drawn = Deblocked::new(&gpu);
    assert_eq!(drawn.record(&gpu), Ok(()));
    drawn
        .view
        .set_extent(&gpu.queue, [60, 40, 1])
        .expect("smaller");
    assert_eq!(drawn.record(&gpu), Ok(()), "a corner of the same buffers");
    drawn
        .view
        .set_extent(&gpu.queue, [200, 150, 1])
        .expect("larger");
    let error = drawn.record(&gpu).expect_err("the view has other buffers");
    assert_eq!(error, DeblockError::Stale);
    assert!(error.to_string().contains("`Deblocker::bind` again"));
    drawn.bound = Deblocked::bound(&gpu, &drawn.deblocker, &drawn.view);
    assert_eq!(drawn.record(&gpu), Ok(()));
}

/// A picture of noise, shaded coarsely everywhere by a frame's order, and what a deblocker makes of it.
fn filtered(
    gpu: &Gpu,
    drawn: &Deblocked,
    record: impl FnOnce(&mut wgpu::CommandEncoder, &mut Bound),
) -> Vec<u8> {
    let noise: Vec<u8> = (0..64 * 48 * 4u32)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 11) as u8)
        .collect();
    let picture = gpu.buffer("picture", &noise, wgpu::BufferUsages::STORAGE);
    let inputs = Inputs::of_view(&drawn.view, PictureInput::Buffer(&picture, 64)).expect("rates");
    let bound = drawn.deblocker.bind(&gpu.device, &inputs);
    let mut bound = bound.expect("a binding");
    let rates = Sri::uniform(64, 48, Rate::R2X2);
    drawn.view.write_sri(&gpu.queue, &rates).expect("its size");
    let mut encoder = gpu.encoder();
    drawn.view.build(&mut encoder).expect("no coverage");
    record(&mut encoder, &mut bound);
    let read = gpu.submit_and_read(encoder, &[&picture]).expect("read");
    let read = read.into_iter().next().expect("a picture");
    assert_eq!(read.len(), noise.len());
    match drawn.view.is_enabled() {
        true => assert_ne!(read, noise, "something is filtered"),
        false => assert_eq!(read, noise, "nothing is filtered"),
    }
    read
}

#[test]
fn a_deblocker_follows_its_views_extent_and_order_and_rests_while_it_is_off() {
    let gpu = common::gpu();
    let mut drawn = Deblocked::new(&gpu);
    let mut pictures = Vec::new();
    for (frame, order) in [(None, 0), (Some(0), 1), (Some(1), 2), (Some(5), 2)] {
        if let Some(frame) = frame {
            drawn.view.rotate(frame);
        }
        let deblocker = &drawn.deblocker;
        let by_view = filtered(&gpu, &drawn, |encoder, bound| {
            let mut compute = encoder.begin_compute_pass(&Default::default());
            deblocker
                .record_view(&gpu.queue, &mut compute, bound, &drawn.view)
                .expect("bound to it");
        });
        let told = filtered(&gpu, &drawn, |encoder, bound| {
            deblocker
                .set_frame(&gpu.queue, bound, SIZE, order)
                .expect("its size");
            deblocker.record(encoder, bound).expect("a frame");
        });
        assert_eq!(by_view, told, "{frame:?}");
        pictures.push(by_view);
    }
    assert_ne!(pictures[1], pictures[2], "the order matters");
    assert_eq!(pictures[2], pictures[3], "frames 1 and 5 have one order");
    drawn.view.set_enabled(&gpu.queue, false);
    filtered(&gpu, &drawn, |encoder, bound| {
        let mut compute = encoder.begin_compute_pass(&Default::default());
        drawn
            .deblocker
            .record_view(&gpu.queue, &mut compute, bound, &drawn.view)
            .expect("bound to it");
    });
}

#[test]
fn a_deblocker_is_told_what_is_missing_before_anything_is_recorded() {
    let gpu = common::gpu();
    let plain = View::of_size(&gpu.device, &gpu.queue, SIZE).expect("a view");
    let picture = packed(&gpu.device, SIZE);
    let error = Inputs::of_view(&plain, PictureInput::Buffer(&picture, 64)).expect_err("no rates");
    assert_eq!(error, DeblockError::NoEffectiveRates);
    assert!(error.to_string().contains("effective: true"), "{error}");

    let drawn = Deblocked::new(&gpu);
    let mut encoder = gpu.encoder();
    let error = drawn.deblocker.record(&mut encoder, &drawn.bound);
    assert_eq!(error, Err(DeblockError::NoFrame));

    let unusable = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 64 * 48 * 4,
        usage: wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let inputs = Inputs {
        picture: PictureInput::Buffer(&unusable, 64),
        ..Inputs::of_view(&drawn.view, PictureInput::Buffer(&picture, 64)).expect("rates")
    };
    let error = drawn
        .deblocker
        .bind(&gpu.device, &inputs)
        .expect_err("no storage");
    assert!(
        matches!(&error, DeblockError::Refused(why) if why.contains("STORAGE")),
        "{error}"
    );
    let small = packed(&gpu.device, [64, 47]);
    let inputs = Inputs::of_view(&drawn.view, PictureInput::Buffer(&small, 64)).expect("rates");
    let bound = drawn
        .deblocker
        .bind(&gpu.device, &inputs)
        .expect("it may be of another extent");
    let mut compute = encoder.begin_compute_pass(&Default::default());
    let error = drawn
        .deblocker
        .record_view(&gpu.queue, &mut compute, &bound, &drawn.view)
        .expect_err("a row is missing");
    assert!(error.to_string().contains("64x47 given"), "{error}");
    drop(compute);
    gpu.queue.submit([encoder.finish()]);
    gpu.check().expect("nothing of it came to the device");
}

#[test]
fn a_classifier_is_told_what_is_missing_before_anything_is_recorded() {
    let gpu = common::gpu();
    let options = classify::Options::circle_of_confusion(0.4, 0.2);
    let classifier = Classifier::new(&gpu.device, options).expect("a classifier");
    let integers = wgpu::TextureDescriptor {
        format: wgpu::TextureFormat::R32Uint,
        ..picture(SIZE)
    };
    let (_, integers) = texture_of(&gpu.device, &integers);
    let error = classifier
        .bind(&gpu.device, &integers)
        .expect_err("no floats");
    assert!(matches!(error, ClassifyError::Refused(_)), "{error:?}");

    let (_, texture) = texture_of(&gpu.device, &picture(SIZE));
    let mut lists = classifier.bind(&gpu.device, &texture).expect("lists");
    let mut encoder = gpu.encoder();
    let unset = classifier.record(&mut encoder, &lists);
    assert_eq!(unset, Err(ClassifyError::NoExtent));
    let mut compute = encoder.begin_compute_pass(&Default::default());
    let unset = lists.dispatch(&mut compute, 0, 1);
    assert_eq!(unset, Err(ClassifyError::NoExtent));
    let error = classifier
        .set_extent(&gpu.queue, &mut lists, [0, 5])
        .expect_err("no pixels");
    assert!(error.to_string().contains("no pixels"), "{error}");
    classifier
        .set_extent(&gpu.queue, &mut lists, SIZE)
        .expect("its size");
    let error = lists
        .dispatch(&mut compute, 3, 1)
        .expect_err("there are three");
    assert!(
        error.to_string().contains("there are 3, from 0 on"),
        "{error}"
    );
    let error = lists
        .dispatch(&mut compute, 0, 9)
        .expect_err("no such group");
    assert!(error.to_string().contains("bind group 9"), "{error}");
    let error = classifier.class("fast").expect_err("no such class");
    assert!(error.to_string().contains("\"cheap\""), "{error}");

    let one = vec![Class::new("all", Rule::Rest)];
    let other = Classifier::new(&gpu.device, classify::Options::new("texel.r", one));
    let error = other.expect("a classifier").record_in(&mut compute, &lists);
    assert_eq!(error, Err(ClassifyError::OtherLists));
    drop(compute);
    gpu.queue.submit([encoder.finish()]);
    gpu.check().expect("nothing of it came to the device");
}

#[test]
fn deblocker_and_classifier_are_made_with_a_name_and_a_cache() {
    let gpu = common::gpu();
    let objects = ObjectOptions::labelled("left eye");
    let options = deblock::Options::new(Picture::Buffer(Packing::Rgba8Unorm));
    Deblocker::with(&gpu.device, None, options, &objects).expect("a deblocker");
    let options = classify::Options::circle_of_confusion(0.4, 0.2);
    Classifier::with(&gpu.device, options, &objects).expect("a classifier");
}
