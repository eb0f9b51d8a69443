//! The added bindings wherever they lie: a group of their own, numbers in a group of the shader's, a place that the user gives;
//! in layouts that are read off the shader and in the user's own; rewritten at run time and before. Every one of them draws the
//! same picture, and with shading rates off the original's.

mod common;

use vrcs::{
    Pass, PassError, PassOptions, Rate, View, build::BuildOptions, check::gpu::Gpu,
    dispatch::bindings::layout_entries, sri::Sri,
};
use vrcs_passes::{
    Entries, Options, Source, emit, input,
    options::{Mode, Place},
};

/// Not a multiple of a tile.
const SIZE: [u32; 2] = [37, 21];
const POISON: u32 = 0xDEAD_BEEF;

/// A shader with its picture in group 0, and a uniform in each further group.
fn shader(groups: u32) -> Source {
    let mut text =
        "@group(0) @binding(0) var<storage, read_write> picture: array<u32>;\n".to_owned();
    let mut sum = String::new();
    for group in 1..groups {
        let name = ["", "one", "two", "three"][group as usize];
        text += &format!("@group({group}) @binding(3) var<uniform> {name}: vec4<u32>;\n");
        sum += &format!(" + {name}.x");
    }
    text += &format!(
        "@compute @workgroup_size(8, 8)
         fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
             if id.x >= {}u || id.y >= {}u {{ return; }}
             picture[id.y * {}u + id.x] = id.x * 1000u + id.y * 7u{sum};
         }}",
        SIZE[0], SIZE[1], SIZE[0]
    );
    Source::new("placed.wgsl", text)
}

fn tiled(place: Option<Place>) -> Options {
    Options {
        mode: Mode::Tiled,
        place,
        ..Options::default()
    }
}

/// What the original draws, each pixel in the place of `of(pixel)`. The uniforms are 0.
fn expected(of: impl Fn(u32, u32) -> [u32; 2]) -> Vec<u32> {
    let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
    pixels
        .map(|(x, y)| {
            let [x, y] = of(x, y);
            x * 1000 + y * 7
        })
        .collect()
}

/// Draws at 2×2, or with rates off, with the layouts that the pass has or these.
fn draw(
    gpu: &Gpu,
    pass: &Pass,
    layouts: &[Option<wgpu::BindGroupLayout>],
    enabled: bool,
) -> Vec<u32> {
    let extent = [SIZE[0], SIZE[1], 1];
    let mut view =
        View::new(&gpu.device, &gpu.queue, extent, BuildOptions::default()).expect("a view");
    view.set_enabled(&gpu.queue, enabled);
    view.write_sri(&gpu.queue, &Sri::uniform(SIZE[0], SIZE[1], Rate::R2X2))
        .expect("rates");
    let poison = vec![POISON; (SIZE[0] * SIZE[1]) as usize];
    let picture = gpu.buffer(
        "picture",
        bytemuck::cast_slice(&poison),
        wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
    );
    let zeros = gpu.buffer("zeros", &[0; 16], wgpu::BufferUsages::UNIFORM);
    let added = pass.bindings(&view).expect("a view for it");
    let mut encoder = gpu.encoder();
    view.build(&mut encoder).expect("no coverage");
    {
        let mut compute = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        for group in 0..4 {
            let given = layouts.get(group as usize).and_then(Option::as_ref);
            let Some(layout) = given.or(pass.bind_group_layout(group)) else {
                continue;
            };
            let own = wgpu::BindGroupEntry {
                binding: if group == 0 { 0 } else { 3 },
                resource: match group {
                    0 => picture.as_entire_binding(),
                    _ => zeros.as_entire_binding(),
                },
            };
            let mut entries = vec![own];
            if pass.shared_group() == Some(group) {
                entries.extend(added.entries());
            }
            let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout,
                entries: &entries,
            });
            compute.set_bind_group(group, &bind_group, &[]);
        }
        pass.dispatch(&mut compute, &view).expect("a view for it");
    }
    let bytes = gpu
        .submit_and_read(encoder, &[&picture])
        .expect("a picture");
    bytemuck::pod_collect_to_vec(&bytes[0])
}

fn assert_draws(gpu: &Gpu, pass: &Pass, layouts: &[Option<wgpu::BindGroupLayout>]) {
    assert_eq!(
        draw(gpu, pass, layouts, false),
        expected(|x, y| [x, y]),
        "with rates off"
    );
    assert_eq!(
        draw(gpu, pass, layouts, true),
        expected(|x, y| [x & !1, y & !1]),
        "at 2x2"
    );
}

fn made(gpu: &Gpu, groups: u32, rewrite: Options) -> Pass {
    let options = PassOptions {
        rewrite,
        ..PassOptions::default()
    };
    Pass::new(&gpu.device, &shader(groups), &options).expect("a pass")
}

#[test]
fn a_free_group_is_ours_alone() {
    let gpu = common::gpu();
    let pass = made(&gpu, 2, tiled(None));
    assert_eq!(pass.shared_group(), None);
    assert_eq!(pass.manifest().bindings[0].group, 2);
    assert!(!pass.manifest().shares_group);
    assert_eq!(pass.manifest().needs.max_bind_groups, 3);
    assert_draws(&gpu, &pass, &[]);
}

#[test]
fn without_a_free_group_the_last_of_the_least_used_is_shared() {
    let gpu = common::gpu();
    let pass = made(&gpu, 4, tiled(None));
    assert_eq!(pass.shared_group(), Some(3));
    let at: Vec<u32> = (pass.manifest().bindings.iter())
        .map(|b| b.binding)
        .collect();
    assert_eq!(at, [4, 5]);
    assert_draws(&gpu, &pass, &[]);
}

#[test]
fn a_given_place_is_taken() {
    let gpu = common::gpu();
    for (group, binding, is_shared) in [(0, 1, true), (1, 0, true), (3, 7, false)] {
        let pass = made(&gpu, 2, tiled(Some(Place { group, binding })));
        assert_eq!(pass.shared_group(), is_shared.then_some(group));
        assert_draws(&gpu, &pass, &[]);
    }
}

#[test]
fn what_was_rewritten_before_shares_a_group_too() {
    let gpu = common::gpu();
    let source = shader(4);
    let (module, info) = input::wgsl(&source).expect("a valid shader");
    let rewritten =
        vrcs_passes::rewrite(&module, &info, Entries::PerPixel, &tiled(None)).expect("a rewrite");
    let text = emit::wgsl(&rewritten.module, &rewritten.info).expect("text");
    let manifest = rewritten.manifest.to_json();
    let pass =
        Pass::prewritten(&gpu.device, &text, &manifest, &PassOptions::default()).expect("a pass");
    assert_eq!(pass.shared_group(), Some(3));
    assert_draws(&gpu, &pass, &[]);
}

/// A layout of one binding, and others.
fn layout(
    gpu: &Gpu,
    binding: u32,
    ty: wgpu::BufferBindingType,
    more: &[wgpu::BindGroupLayoutEntry],
) -> Option<wgpu::BindGroupLayout> {
    let own = wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let entries = [&[own], more].concat();
    let descriptor = wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    };
    Some(gpu.device.create_bind_group_layout(&descriptor))
}

#[test]
fn the_users_layouts_hold_the_added_bindings() {
    let gpu = common::gpu();
    let storage = wgpu::BufferBindingType::Storage { read_only: false };
    let uniform = wgpu::BufferBindingType::Uniform;
    let with = |layouts: &[Option<wgpu::BindGroupLayout>], place| {
        let layouts: Vec<Option<&wgpu::BindGroupLayout>> =
            layouts.iter().map(Option::as_ref).collect();
        let options = PassOptions {
            rewrite: tiled(place),
            layouts: &layouts,
            ..PassOptions::default()
        };
        Pass::new(&gpu.device, &shader(2), &options)
    };
    let place = Place {
        group: 1,
        binding: 8,
    };
    let merged = [
        layout(&gpu, 0, storage, &[]),
        layout(&gpu, 3, uniform, &layout_entries(8)),
    ];
    let pass = with(&merged, Some(place)).expect("a pass");
    assert_eq!(pass.shared_group(), Some(1));
    assert_draws(&gpu, &pass, &merged);

    let own = [layout(&gpu, 0, storage, &[]), layout(&gpu, 3, uniform, &[])];
    let pass = with(&own, None).expect("a pass");
    assert_eq!(pass.shared_group(), None);
    assert_draws(&gpu, &pass, &own);

    let without = [layout(&gpu, 0, storage, &[])];
    let error = with(&without, Some(place)).expect_err("no layout for the shared group");
    assert!(
        matches!(error, PassError::GroupMissing { group: 1, first: 8 }),
        "{error}"
    );

    let too_many = [own.to_vec(), vec![layout(&gpu, 0, uniform, &[])]].concat();
    let error = with(&too_many, None).expect_err("a layout for the added bindings' group");
    assert!(
        matches!(error, PassError::GroupTaken { group: 2 }),
        "{error}"
    );
}
