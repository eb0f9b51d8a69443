//! What a device has too little of is told by its name, before wgpu panics over it.

use vrcs::{
    Pass, Rate, Scene, View, ViewError,
    analyse::{Analysis, Frame, Settings},
    build::BuildOptions,
    plan::Plan,
};
use vrcs_passes::options::Mode;

use crate::renderer::{Drawn, SIZE, device_with, options, shader};

#[test]
fn everything_is_made_with_the_limits_of_old_devices() {
    let limits = wgpu::Limits::downlevel_defaults();
    let (device, queue) = device_with(limits);
    let drawn = Drawn::new(&device, &queue, SIZE);
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut compute = encoder.begin_compute_pass(&Default::default());
    drawn.record(&queue, &mut compute, &Frame::of_size(SIZE));
    drop(compute);
    queue.submit([encoder.finish()]);
}

#[test]
fn a_device_with_too_little_is_told_what_it_lacks() {
    let (device, queue) = device_with(wgpu::Limits {
        max_compute_invocations_per_workgroup: 128,
        ..wgpu::Limits::default()
    });
    let limit = "of `max_compute_invocations_per_workgroup`, and the device has 128";
    let error = View::new(
        &device,
        &queue,
        [64, 48, 1],
        BuildOptions {
            largest: Rate::R4X4,
            ..BuildOptions::default()
        },
    )
    .expect_err("256 at once");
    assert!(error.to_string().contains(limit), "{error}");
    let error = Pass::new(&device, &shader(), &options(Mode::Tiled)).expect_err("tiles of 256");
    assert!(error.to_string().contains(limit), "{error}");
    let plan = Plan::new(&Scene::default(), &Settings::default()).expect("a plan");
    Analysis::new(&device, &plan).expect("the analysis has 128 invocations at most");

    let (device, queue) = device_with(wgpu::Limits {
        max_storage_buffers_per_shader_stage: 2,
        ..wgpu::Limits::default()
    });
    let error = View::of_size(&device, &queue, SIZE).expect_err("four buffers");
    let limit = "`max_storage_buffers_per_shader_stage`, and the device has 2";
    assert!(error.to_string().contains(limit), "{error}");
    let (device, queue) = device_with(wgpu::Limits {
        max_storage_buffer_binding_size: 1 << 16,
        ..wgpu::Limits::default()
    });
    let error = View::of_size(&device, &queue, [1920, 1080]).expect_err("8 MB");
    assert!(matches!(error, ViewError::TooLarge { .. }), "{error:?}");
    let error = View::of_size(&device, &queue, [1 << 20, 1 << 20]).expect_err("no such picture");
    assert!(matches!(error, ViewError::TooLarge { .. }), "{error:?}");
}
