//! Layouts of the caller's that do not serve the shader; dynamic offsets.

use vrcs::{Pass, PassError, PassOptions, View};

use crate::{
    common,
    renderer::{SIZE, group, picture, shader, texture_of},
};

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
