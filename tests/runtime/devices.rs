//! Several devices: what belongs to one is not used with another, even where wgpu gives both the same numbers.

use vrcs::{
    Mismatch, View,
    analyse::{Frame, FrameError},
    classify::{self, Classifier, ClassifyError},
    deblock::{self, DeblockError, Deblocker, Inputs, Packing, Picture, PictureInput},
};

use crate::renderer::{Drawn, SIZE, picture, texture_of};

fn open(instance: &wgpu::Instance) -> (wgpu::Device, wgpu::Queue) {
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()));
    let adapter = adapter.expect("a driver");
    pollster::block_on(adapter.request_device(&Default::default())).expect("a device")
}

fn instance() -> wgpu::Instance {
    wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle())
}

/// A renderer on each of two devices draws; what of one is given to the other is refused.
fn hold_apart(one: (wgpu::Device, wgpu::Queue), other: (wgpu::Device, wgpu::Queue)) {
    let [first, second] = [&one, &other].map(|(device, queue)| Drawn::new(device, queue, SIZE));
    let frame = Frame::of_size(SIZE);
    for (drawn, (device, queue)) in [(&first, &one), (&second, &other)] {
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut compute = encoder.begin_compute_pass(&Default::default());
        drawn.record(queue, &mut compute, &frame);
        drop(compute);
        queue.submit([encoder.finish()]);
    }
    let mut encoder = other.0.create_command_encoder(&Default::default());
    let mut compute = encoder.begin_compute_pass(&Default::default());
    assert_eq!(
        first.pass.dispatch(&mut compute, &second.view),
        Err(Mismatch::Device)
    );
    assert_eq!(
        first.pass.bindings(&second.view).err(),
        Some(Mismatch::Device)
    );
    let analysed = first
        .analyser
        .record(&other.1, &mut compute, &second.view, &frame);
    assert_eq!(analysed, Err(FrameError::Stale));

    let options = deblock::Options::new(Picture::Buffer(Packing::Rgba8Unorm));
    let deblocker = Deblocker::new(&one.0, None, options).expect("a deblocker");
    let buffer = |device: &wgpu::Device| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 64 * 48 * 4,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        })
    };
    let [theirs, rates] = [&other.0, &other.0].map(buffer);
    let inputs = Inputs {
        picture: PictureInput::Buffer(&theirs, 64),
        rates: &rates,
        depth: None,
        surfaces: None,
        luma: None,
    };
    let error = deblocker
        .bind(&other.0, &inputs)
        .expect_err("another device");
    assert_eq!(error, DeblockError::Device);
    let classifier = Classifier::new(&one.0, classify::Options::circle_of_confusion(0.4, 0.2));
    let (_, texture) = texture_of(&other.0, &picture(SIZE));
    let error = classifier
        .expect("a classifier")
        .bind(&other.0, &texture)
        .expect_err("another device");
    assert_eq!(error, ClassifyError::Device);
}

#[test]
fn two_devices_of_one_instance_are_held_apart() {
    let instance = instance();
    hold_apart(open(&instance), open(&instance));
}

#[test]
fn two_devices_of_two_instances_are_held_apart() {
    let (one, other) = (open(&instance()), open(&instance()));
    assert_eq!(
        one.0, other.0,
        "wgpu gives them one number: if no more, `home` is not needed"
    );
    hold_apart(one, other);
}

#[test]
fn copies_of_a_devices_handle_are_one_device() {
    let (device, queue) = open(&instance());
    let drawn = Drawn::new(&device.clone(), &queue, SIZE);
    let view = View::of_size(&device, &queue, SIZE).expect("a view");
    assert_eq!(drawn.pass.check(&view), Ok(()));
}

#[test]
fn a_device_ends_with_what_was_made_on_it() {
    use std::sync::mpsc::{RecvTimeoutError, TryRecvError, channel};
    // the device drops its callback when it ends
    let (alive, told) = channel::<()>();
    let (device, queue) = open(&instance());
    device.set_device_lost_callback(move |_, _| {
        let _ = &alive;
    });
    let drawn = Drawn::new(&device, &queue, SIZE);
    drop((device, queue));
    assert_eq!(
        told.try_recv(),
        Err(TryRecvError::Empty),
        "a view still lives there"
    );
    drop(drawn);
    let ended = told.recv_timeout(std::time::Duration::from_secs(5));
    assert_eq!(ended, Err(RecvTimeoutError::Disconnected));
}
