//! Immediates reach the shader, and a device that has none says so.

use vrcs::{Pass, Rate, Source, View, build::BuildOptions, check::gpu::Gpu, sri::Sri};
use vrcs_passes::options::Mode;

use crate::{
    common,
    renderer::{device_with, options, shader},
};

#[test]
fn a_shader_without_immediates_needs_none() {
    let gpu = common::gpu();
    let pass = Pass::new(&gpu.device, &shader(), &options(Mode::Tiled)).expect("a pass");
    assert_eq!(pass.immediate_size(), 0);
}

#[test]
fn immediates_reach_the_shader_in_every_mode_and_its_indirect_dispatch() {
    // arguments of indirect dispatches are validated by a pipeline with immediates of its own
    let gpu = Gpu::open_validating(None).expect("a driver");
    let source = Source::new(
        "immediate.wgsl",
        "struct Now { frame: u32, add: vec2<u32> }
         var<immediate> now: Now;
         @group(0) @binding(0) var<storage, read_write> picture: array<u32>;
         @compute @workgroup_size(8, 8)
         fn main(@builtin(global_invocation_id) id: vec3<u32>) {
             if id.x >= 64u || id.y >= 48u { return; }
             picture[id.y * 64u + id.x] = now.frame * 1000u + now.add.y;
         }",
    );
    for mode in [Mode::Tiled, Mode::List, Mode::Classified] {
        let pass = Pass::new(&gpu.device, &source, &options(mode)).expect("a pass");
        assert_eq!(pass.immediate_size(), 16, "by the shader's own struct");
        let built = pass.build_options(BuildOptions::default());
        let view = View::new(&gpu.device, &gpu.queue, [64, 48, 1], built).expect("a view");
        let rates = Sri::uniform(64, 48, Rate::R2X2);
        view.write_sri(&gpu.queue, &rates).expect("its size");
        let storage = wgpu::BufferUsages::STORAGE;
        let pixels = gpu.buffer("picture", &[0; 64 * 48 * 4], storage);
        let bound = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: pass.bind_group_layout(0).expect("a group"),
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: pixels.as_entire_binding(),
            }],
        });
        let mut encoder = gpu.encoder();
        let mut compute = encoder.begin_compute_pass(&Default::default());
        view.build_in(&mut compute).expect("no coverage");
        compute.set_bind_group(0, &bound, &[]);
        for frame in [3u32, 7] {
            let words: [u32; 4] = [frame, 0, 0, 5];
            pass.dispatch_with(&mut compute, &view, |compute| {
                compute.set_immediates(0, bytemuck::cast_slice(&words));
            })
            .expect("a view for it");
        }
        drop(compute);
        let read = gpu.submit_and_read(encoder, &[&pixels]).expect("read");
        let read: Vec<u32> = bytemuck::pod_collect_to_vec(&read[0]);
        assert!(read.iter().all(|&pixel| pixel == 7005), "{mode:?}");
    }
}

#[test]
fn a_device_without_immediates_is_told_before_there_is_a_pipeline() {
    let (device, _) = device_with(wgpu::Limits::default());
    let source = Source::new(
        "immediate.wgsl",
        "var<immediate> now: vec4<u32>;
         @group(0) @binding(0) var<storage, read_write> picture: array<u32>;
         @compute @workgroup_size(8, 8)
         fn main(@builtin(global_invocation_id) id: vec3<u32>) { picture[id.y * 64u + id.x] = now.x; }",
    );
    let error = Pass::new(&device, &source, &options(Mode::Tiled)).expect_err("no immediates");
    assert!(
        error
            .to_string()
            .contains("needs 16 of `max_immediate_size`, and the device has 0")
            && error.to_string().contains("Features::IMMEDIATES"),
        "{error}"
    );
}
