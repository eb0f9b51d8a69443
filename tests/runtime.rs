//! The runtime in somebody's renderer: what a user can get wrong is told by an error, before wgpu panics over it; what they can set
//! reaches the shader; and a steady frame costs what wgpu itself costs.

mod common;

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use vrcs::{
    Analyser, AnalyserError, Mismatch, Pass, PassError, PassOptions, Rate, Scene, Source, View,
    ViewError,
    analyse::{Analysis, BindError, Frame, FrameError, Settings},
    build::BuildOptions,
    check::gpu::Gpu,
    coverage::{Coverage, Textures},
    plan::{Binding, ColourForm, Plan},
    sri::Sri,
};
use vrcs_passes::{Options, options::Mode};

const SIZE: [u32; 2] = [64, 48];

// ---- a renderer

fn shader() -> Source {
    Source::new(
        "fill.wgsl",
        "@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
         @group(0) @binding(1) var<uniform> level: vec4<f32>;
         @compute @workgroup_size(8, 8)
         fn main(@builtin(global_invocation_id) id: vec3<u32>) {
             if any(id.xy >= textureDimensions(picture)) { return; }
             textureStore(picture, id.xy, vec4(level.x, vec2<f32>(id.xy % 2u), 1.0));
         }",
    )
}

fn texture_of(
    device: &wgpu::Device,
    descriptor: &wgpu::TextureDescriptor,
) -> (wgpu::Texture, wgpu::TextureView) {
    let texture = device.create_texture(descriptor);
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2),
        array_layer_count: Some(1),
        ..Default::default()
    });
    (texture, view)
}

fn picture(size: [u32; 2]) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d {
            width: size[0],
            height: size[1],
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    }
}

fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    picture: &wgpu::TextureView,
    level: wgpu::BindingResource,
) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(picture),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: level,
            },
        ],
    })
}

fn options(mode: Mode) -> PassOptions<'static> {
    PassOptions {
        rewrite: Options {
            mode,
            ..Options::default()
        },
        ..PassOptions::default()
    }
}

/// A device with certain limits and no features.
fn device_with(limits: wgpu::Limits) -> (wgpu::Device, wgpu::Queue) {
    let adapter = vrcs::check::gpu::adapters().swap_remove(0);
    let descriptor = wgpu::DeviceDescriptor {
        required_limits: limits,
        ..Default::default()
    };
    pollster::block_on(adapter.request_device(&descriptor)).expect("a device")
}

// ---- immediates

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

// ---- the previous picture

#[test]
fn a_picture_that_cannot_be_analysed_is_told_why_and_what_to_do() {
    let gpu = common::gpu();
    let view = View::of_size(&gpu.device, &gpu.queue, SIZE).expect("a view");
    let of = |descriptor: &wgpu::TextureDescriptor| {
        let (texture, _) = texture_of(&gpu.device, descriptor);
        Analyser::of_colour(&gpu.device, &view, &texture)
    };
    let sampled = wgpu::TextureUsages::TEXTURE_BINDING;
    let plain = wgpu::TextureDescriptor {
        usage: sampled,
        ..picture(SIZE)
    };
    of(&plain).expect("a picture as it should be");

    let srgb = wgpu::TextureDescriptor {
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        ..plain.clone()
    };
    let error = of(&srgb).expect_err("its codes cannot be read");
    assert!(matches!(error, AnalyserError::Srgb { .. }), "{error:?}");
    let words = error.to_string();
    assert!(words.contains("view_formats: &[Rgba8Unorm]"), "{words}");
    let twin = wgpu::TextureDescriptor {
        view_formats: &[wgpu::TextureFormat::Rgba8Unorm],
        ..srgb.clone()
    };
    of(&twin).expect("its codes can be read");
    let (_, decoded) = texture_of(&gpu.device, &srgb);
    Analyser::of_view(&gpu.device, &view, &decoded, ColourForm::Linear).expect("what is decoded");

    let array = wgpu::TextureDescriptor {
        size: wgpu::Extent3d {
            depth_or_array_layers: 2,
            ..plain.size
        },
        ..plain.clone()
    };
    let error = of(&array).expect_err("which layer?");
    assert!(
        matches!(error, AnalyserError::Layers { layers: 2, .. }),
        "{error:?}"
    );
    let (_, layer) = texture_of(&gpu.device, &array);
    Analyser::of_view(&gpu.device, &view, &layer, ColourForm::Codes).expect("one layer");

    let samples = wgpu::TextureDescriptor {
        sample_count: 4,
        usage: sampled | wgpu::TextureUsages::RENDER_ATTACHMENT,
        ..plain.clone()
    };
    let error = of(&samples).expect_err("four samples");
    assert!(
        matches!(
            error,
            AnalyserError::Bind(BindError::Samples { samples: 4, .. })
        ),
        "{error:?}"
    );
    let hidden = wgpu::TextureDescriptor {
        usage: wgpu::TextureUsages::COPY_SRC,
        ..plain.clone()
    };
    let error = of(&hidden).expect_err("no shader may read it");
    assert!(
        matches!(&error, AnalyserError::Bind(BindError::Usage { usage, .. }) if *usage == "TEXTURE_BINDING")
            || matches!(&error, AnalyserError::Bind(BindError::Refused(_))),
        "{error:?}"
    );
    let small = wgpu::TextureDescriptor {
        usage: sampled,
        ..picture([63, 48])
    };
    let error = of(&small).expect_err("smaller than the view");
    assert!(matches!(error, AnalyserError::Size { .. }), "{error:?}");
    let depth = wgpu::TextureDescriptor {
        format: wgpu::TextureFormat::R32Float,
        ..plain.clone()
    };
    let error = of(&depth).expect_err("no colour");
    assert!(matches!(error, AnalyserError::Picture(_)), "{error:?}");
    gpu.check().expect("nothing of it came to wgpu");
}

#[test]
fn resources_of_another_kind_are_refused_when_they_are_bound() {
    let gpu = common::gpu();
    let view = View::of_size(&gpu.device, &gpu.queue, SIZE).expect("a view");
    let scene = Scene::default();
    let settings = Settings::default();
    let of = |resource| {
        let resources = [(Binding::Colour, resource)];
        Analyser::new(&gpu.device, &view, &scene, &settings, &resources).expect_err("no colour")
    };
    let error = of(view.sri().as_entire_binding());
    assert!(
        matches!(
            error,
            AnalyserError::Bind(BindError::Kind {
                wanted: "texture",
                ..
            })
        ),
        "{error:?}"
    );
    let integers = wgpu::TextureDescriptor {
        format: wgpu::TextureFormat::R32Uint,
        ..picture(SIZE)
    };
    let (_, integers) = texture_of(&gpu.device, &integers);
    let error = of(wgpu::BindingResource::TextureView(&integers));
    assert!(
        matches!(error, AnalyserError::Bind(BindError::Refused(_))),
        "{error:?}"
    );
    gpu.check().expect("nothing of it came to the device");
}

// ---- layouts

#[test]
fn a_layout_that_does_not_serve_the_shader_is_told_by_group_binding_and_name() {
    let gpu = common::gpu();
    let storage = |format| wgpu::BindingType::StorageTexture {
        access: wgpu::StorageTextureAccess::WriteOnly,
        format,
        view_dimension: wgpu::TextureViewDimension::D2,
    };
    let uniform = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let made = |entries: &[wgpu::BindGroupLayoutEntry]| {
        let descriptor = wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries,
        };
        let layout = gpu.device.create_bind_group_layout(&descriptor);
        Pass::new(
            &gpu.device,
            &shader(),
            &PassOptions::with_layouts(&[Some(&layout)]),
        )
    };
    let right = entry(0, storage(wgpu::TextureFormat::Rgba8Unorm));
    made(&[right, entry(1, uniform)]).expect("a layout for it");

    let format = entry(0, storage(wgpu::TextureFormat::Rgba16Float));
    let error = made(&[format, entry(1, uniform)]).expect_err("another format");
    let PassError::Layout {
        group: 0,
        binding: 0,
        ref name,
        ..
    } = error
    else {
        panic!("{error:?}");
    };
    assert_eq!(name, "picture");
    assert!(error.to_string().contains("Rgba8Unorm"), "{error}");

    let error = made(&[right]).expect_err("no uniform");
    assert!(
        matches!(&error, PassError::Layout { group: 0, binding: 1, name, .. } if name == "level"),
        "{error:?}"
    );
    let invisible = wgpu::BindGroupLayoutEntry {
        visibility: wgpu::ShaderStages::FRAGMENT,
        ..entry(1, uniform)
    };
    let error = made(&[right, invisible]).expect_err("not visible");
    assert!(
        error.to_string().contains("not visible to compute shaders"),
        "{error}"
    );

    let none = Pass::new(&gpu.device, &shader(), &PassOptions::with_layouts(&[None]));
    let error = none.expect_err("the group is left out");
    assert!(
        matches!(
            error,
            PassError::Layout {
                group: 0,
                binding: 0,
                ..
            }
        ),
        "{error:?}"
    );
    gpu.check().expect("nothing of it came to the device");
}

// ---- states

#[test]
fn a_view_is_not_built_until_its_coverage_is_known_for_its_extent() {
    let gpu = common::gpu();
    let declared = BuildOptions {
        coverage: Coverage {
            surfaces: true,
            ..Coverage::default()
        },
        ..BuildOptions::default()
    };
    let mut view = View::new(&gpu.device, &gpu.queue, [64, 48, 1], declared).expect("a view");
    let build = |view: &View| view.build(&mut gpu.encoder());
    assert_eq!(build(&view), Err(ViewError::Uncovered));

    let numbers = wgpu::TextureDescriptor {
        format: wgpu::TextureFormat::R32Uint,
        ..picture(SIZE)
    };
    let (_, surfaces) = texture_of(&gpu.device, &numbers);
    let given = Textures {
        surfaces: Some(&surfaces),
        ..Textures::default()
    };
    view.cover(&gpu.queue, &given).expect("its size");
    assert_eq!(build(&view), Ok(()));
    view.set_extent(&gpu.queue, [64, 48, 1]).expect("as it was");
    assert_eq!(build(&view), Ok(()), "nothing changed");
    view.set_extent(&gpu.queue, [60, 40, 1]).expect("smaller");
    assert_eq!(build(&view), Err(ViewError::Uncovered), "another extent");
    view.cover(&gpu.queue, &given).expect("a corner of it");
    assert_eq!(build(&view), Ok(()));

    view.set_extent(&gpu.queue, [65, 48, 1]).expect("larger");
    let error = view.cover(&gpu.queue, &given).expect_err("too small");
    assert!(
        matches!(
            error,
            ViewError::SmallTexture {
                name: "surfaces",
                ..
            }
        ),
        "{error:?}"
    );
    let (_, colours) = texture_of(&gpu.device, &picture([65, 48]));
    let wrong = Textures {
        surfaces: Some(&colours),
        ..Textures::default()
    };
    let error = view.cover(&gpu.queue, &wrong).expect_err("no numbers");
    assert!(matches!(error, ViewError::Refused(_)), "{error:?}");
    gpu.check().expect("nothing of it came to the device");
}

#[test]
fn a_pass_is_not_dispatched_over_a_view_that_was_made_for_something_else() {
    let gpu = common::gpu();
    let pass = Pass::new(&gpu.device, &shader(), &options(Mode::Graded));
    let error = pass.expect_err("the shader grades nothing");
    assert!(matches!(error, PassError::Refused { .. }), "{error:?}");
    let pass = Pass::new(&gpu.device, &shader(), &options(Mode::Classified)).expect("a pass");
    let view = View::of_size(&gpu.device, &gpu.queue, SIZE).expect("a view");
    let mut encoder = gpu.encoder();
    let mut compute = encoder.begin_compute_pass(&Default::default());
    let mismatch = Mismatch::Mode {
        pass: Mode::Classified,
    };
    assert_eq!(pass.dispatch(&mut compute, &view), Err(mismatch.clone()));
    assert_eq!(pass.bindings(&view).err(), Some(mismatch));

    drop(compute);
    gpu.queue.submit([encoder.finish()]);
    gpu.check().expect("nothing was recorded");
}

// ---- resize

/// Draws a frame by analysis, build and dispatch.
struct Drawn {
    view: View,
    analyser: Analyser,
    pass: Pass,
    group: wgpu::BindGroup,
}

fn level(gpu_device: &wgpu::Device) -> wgpu::Buffer {
    gpu_device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 16,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

impl Drawn {
    fn new(device: &wgpu::Device, queue: &wgpu::Queue, size: [u32; 2]) -> Drawn {
        let (texture, target) = texture_of(device, &picture(size));
        let pass = Pass::new(device, &shader(), &options(Mode::List)).expect("a pass");
        let view = View::of_size(device, queue, size).expect("a view");
        let analyser = Analyser::of_colour(device, &view, &texture).expect("an analyser");
        let level = level(device);
        let layout = pass.bind_group_layout(0).expect("a group");
        let group = group(device, layout, &target, level.as_entire_binding());
        Drawn {
            view,
            analyser,
            pass,
            group,
        }
    }

    /// What a renderer does when its window changes.
    fn resize(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, size: [u32; 2]) {
        let (_, target) = texture_of(device, &picture(size));
        let extent = [size[0], size[1], 1];
        self.view.set_extent(queue, extent).expect("an extent");
        let resources = [(Binding::Colour, wgpu::BindingResource::TextureView(&target))];
        self.analyser.bind(&self.view, &resources).expect("bound");
        let level = level(device);
        let layout = self.pass.bind_group_layout(0).expect("a group");
        self.group = group(device, layout, &target, level.as_entire_binding());
    }

    fn record(&self, queue: &wgpu::Queue, compute: &mut wgpu::ComputePass, frame: &Frame) {
        self.analyser
            .record(queue, compute, &self.view, frame)
            .expect("a frame");
        self.view.build_in(compute).expect("no coverage");
        compute.set_bind_group(0, &self.group, &[]);
        self.pass
            .dispatch(compute, &self.view)
            .expect("a view for it");
    }
}

#[test]
fn an_analyser_that_was_not_bound_again_refuses_to_write_the_old_buffers() {
    let gpu = common::gpu();
    let mut drawn = Drawn::new(&gpu.device, &gpu.queue, SIZE);
    let mut encoder = gpu.encoder();
    let mut compute = encoder.begin_compute_pass(&Default::default());
    let mut record = |drawn: &Drawn, frame: &Frame| {
        drawn
            .analyser
            .record(&gpu.queue, &mut compute, &drawn.view, frame)
    };
    assert_eq!(record(&drawn, &Frame::of_size(SIZE)), Ok(()));
    let error = record(&drawn, &Frame::of_size([64, 47])).expect_err("another size");
    assert!(matches!(error, FrameError::View { .. }), "{error:?}");
    let scaled = Frame {
        resolution_scale: 0.0,
        ..Frame::of_size(SIZE)
    };
    assert_eq!(record(&drawn, &scaled), Err(FrameError::Scale(0.0)));
    let larger = Frame {
        previous_size: [65, 48],
        ..Frame::of_size(SIZE)
    };
    let error = record(&drawn, &larger).expect_err("the picture is smaller");
    assert!(
        matches!(error, FrameError::Texture { what: "colour", .. }),
        "{error:?}"
    );

    let before = drawn.view.generation();
    drawn
        .view
        .set_extent(&gpu.queue, [200, 200, 1])
        .expect("larger");
    assert_ne!(drawn.view.generation(), before);
    assert_eq!(
        record(&drawn, &Frame::of_size([200, 200])),
        Err(FrameError::Stale)
    );
    drawn.resize(&gpu.device, &gpu.queue, [200, 200]);
    assert_eq!(record(&drawn, &Frame::of_size([200, 200])), Ok(()));
}

#[test]
fn nothing_is_left_behind_by_a_hundred_changes_of_size() {
    let descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    let instance = wgpu::Instance::new(descriptor);
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()));
    let adapter = adapter.expect("a driver");
    let (device, queue) =
        pollster::block_on(adapter.request_device(&Default::default())).expect("a device");
    let mut drawn = Drawn::new(&device, &queue, SIZE);
    let mut live = Vec::new();
    for turn in 0..100u32 {
        let size = [40 + turn % 7 * 16, 30 + turn % 5 * 16];
        drawn.resize(&device, &queue, size);
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut compute = encoder.begin_compute_pass(&Default::default());
        drawn.record(&queue, &mut compute, &Frame::of_size(size));
        drop(compute);
        queue.submit([encoder.finish()]);
        device
            .poll(wgpu::PollType::wait_indefinitely())
            .expect("done");
        let report = instance.generate_report().expect("a native backend");
        let hub = report.hub_report();
        live.push([
            hub.buffers.num_allocated,
            hub.bind_groups.num_allocated,
            hub.textures.num_allocated,
            hub.texture_views.num_allocated,
            hub.compute_pipelines.num_allocated,
            hub.bind_group_layouts.num_allocated,
        ]);
    }
    // once the buffers have grown to the largest size, each turn leaves what the one before left
    assert_eq!(live[40], live[99], "{live:?}");
}

// ---- limits

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

// ---- dynamic offsets, several views

#[test]
fn dynamic_offsets_are_the_callers() {
    let gpu = common::gpu();
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let layout = gpu
        .device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &[
                entry(
                    0,
                    wgpu::BindingType::StorageTexture {
                        access: wgpu::StorageTextureAccess::WriteOnly,
                        format: wgpu::TextureFormat::Rgba8Unorm,
                        view_dimension: wgpu::TextureViewDimension::D2,
                    },
                ),
                entry(
                    1,
                    wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: true,
                        min_binding_size: None,
                    },
                ),
            ],
        });
    let layouts = [Some(&layout)];
    let pass = Pass::new(&gpu.device, &shader(), &PassOptions::with_layouts(&layouts));
    let pass = pass.expect("a pass");
    let view = View::of_size(&gpu.device, &gpu.queue, SIZE).expect("a view");
    let mut levels = vec![0f32; 128];
    levels[64] = 1.0;
    let uniform = wgpu::BufferUsages::UNIFORM;
    let levels = gpu.buffer("levels", bytemuck::cast_slice(&levels), uniform);
    let (texture, target) = texture_of(&gpu.device, &picture(SIZE));
    let level = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
        buffer: &levels,
        offset: 0,
        size: wgpu::BufferSize::new(16),
    });
    let group = group(&gpu.device, &layout, &target, level);
    for (offset, wanted) in [(0, 0), (256, 255)] {
        let mut encoder = gpu.encoder();
        let mut compute = encoder.begin_compute_pass(&Default::default());
        view.build_in(&mut compute).expect("no coverage");
        compute.set_bind_group(0, &group, &[offset]);
        pass.dispatch(&mut compute, &view).expect("a view for it");
        drop(compute);
        let pixels = gpu.read_rgba8(encoder, &texture).expect("read");
        assert!(pixels.chunks(4).all(|pixel| pixel[0] == wanted), "{offset}");
    }
}

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

// ---- allocations

/// Counts this thread's allocations.
struct Counting;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: the system's allocator, and a number beside it
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = COUNT.try_with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's, as above
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's, as above
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(what: impl FnOnce()) -> u64 {
    let before = COUNT.with(Cell::get);
    what();
    COUNT.with(Cell::get) - before
}

#[test]
fn a_steady_frame_allocates_at_most_one_block_more_than_its_commands_by_hand() {
    let gpu = common::gpu();
    let mut drawn = Drawn::new(&gpu.device, &gpu.queue, SIZE);
    let frame = Frame::of_size(SIZE);
    let mut counts = Vec::new();
    for number in 0..8 {
        let mut encoder = gpu.encoder();
        let mut compute = encoder.begin_compute_pass(&Default::default());
        counts.push(allocations(|| {
            drawn.view.rotate(number);
            drawn.record(&gpu.queue, &mut compute, &frame);
        }));
        drop(compute);
        gpu.queue.submit([encoder.finish()]);
    }
    // the same commands by hand: three stages, four dispatches
    let module = gpu
        .device
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl("@compute @workgroup_size(1) fn main() {}".into()),
        });
    let pipeline = gpu
        .device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
    let arguments = gpu.buffer("arguments", &[0; 12], wgpu::BufferUsages::INDIRECT);
    let mut encoder = gpu.encoder();
    let mut compute = encoder.begin_compute_pass(&Default::default());
    let bare = allocations(|| {
        for (stage, dispatches) in [
            ("vrcs analyse", 1),
            ("vrcs build", 2),
            ("fill.wgsl main", 1),
        ] {
            compute.push_debug_group(stage);
            for _ in 0..dispatches {
                compute.set_pipeline(&pipeline);
                compute.set_bind_group(0, &drawn.group, &[0]);
                compute.set_bind_group(1, &drawn.group, &[]);
                compute.dispatch_workgroups_indirect(&arguments, 0);
            }
            compute.pop_debug_group();
        }
    });
    drop(compute);
    println!("frames: {counts:?}; by hand: {bare}");
    let steady = counts.split_off(2);
    assert!(
        steady.iter().all(|&count| count <= bare + 1),
        "{steady:?} against {bare}"
    );
}
