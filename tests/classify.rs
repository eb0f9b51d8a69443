//! Tile classification: every tile in exactly one list, the one that the CPU twin says; dispatches that reach every pixel once.

mod common;

use fastrand::Rng;
use vrcs::{
    check::gpu::Gpu,
    classify::{Class, Classifier, Lists, Options, Rule, cpu},
};

const SIZES: [[u32; 2]; 7] = [
    [1, 1],
    [31, 33],
    [64, 64],
    [200, 100],
    [3, 1080],
    [2000, 5],
    [257, 129],
];

/// A texture of two floats a texel.
fn texture(gpu: &Gpu, size: [u32; 2], texels: &[[f32; 2]]) -> wgpu::TextureView {
    let bytes = bytemuck::cast_slice(texels);
    gpu.texture("values", size, wgpu::TextureFormat::Rg32Float, bytes)
}

/// Smooth areas, areas at rest and noise, in patches that are not the tiles; a few values are no numbers.
fn values(extent: [u32; 2], rng: &mut Rng, with_nan: bool) -> Vec<[f32; 2]> {
    let patches: Vec<u32> = (0..4096).map(|_| rng.u32(0..4)).collect();
    (0..extent[0] * extent[1])
        .map(|i| {
            let (x, y) = (i % extent[0], i / extent[0]);
            let patch = patches[(y / 90 * 53 + x / 90) as usize % 4096];
            let value = match patch {
                0 => 0.25,
                1 => 0.5 + 0.125 * (x % 2) as f32,
                2 => rng.f32(),
                _ => -1.0 - rng.f32(),
            };
            match with_nan && rng.u32(0..4000) == 0 {
                true => [f32::NAN, 0.0],
                false => [value, 0.0],
            }
        })
        .collect()
}

fn bound(gpu: &Gpu, classifier: &Classifier, view: &wgpu::TextureView, extent: [u32; 2]) -> Lists {
    let mut lists = classifier
        .bind(&gpu.device, view)
        .unwrap_or_else(|e| panic!("{e}"));
    classifier
        .set_extent(&gpu.queue, &mut lists, extent)
        .unwrap_or_else(|e| panic!("{e}"));
    lists
}

/// The class of each tile, by the GPU's lists; each tile has to be in exactly one. Also the arguments.
fn classes_of(
    gpu: &Gpu,
    classifier: &Classifier,
    lists: &Lists,
    extent: [u32; 2],
) -> (Vec<usize>, Vec<u32>) {
    let mut encoder = gpu.encoder();
    classifier.record(&mut encoder, lists).expect("an extent");
    let read = gpu
        .submit_and_read(encoder, &[lists.buffer(), lists.arguments()])
        .unwrap_or_else(|e| panic!("{e}"));
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(&read[0]);
    let tiles = classifier.options().tiles(extent);
    let count = (tiles[0] * tiles[1]) as usize;
    assert_eq!(words[..3], [extent[0], extent[1], count as u32]);
    let mut classes = vec![usize::MAX; count];
    for class in 0..words[3] as usize {
        let start = 16 + class * count;
        for &tile in &words[start..start + words[4 + class] as usize] {
            let at = (tile >> 16) as usize * tiles[0] as usize + (tile & 0xffff) as usize;
            assert_eq!(classes[at], usize::MAX, "tile {tile:#x} is in two lists");
            classes[at] = class;
        }
    }
    assert!(!classes.contains(&usize::MAX), "a tile is in no list");
    (classes, bytemuck::pod_collect_to_vec(&read[1]))
}

#[test]
fn one_pixel_is_one_tile() {
    let gpu = common::gpu();
    let classifier = Classifier::new(&gpu.device, Options::circle_of_confusion(0.4, 0.2)).unwrap();
    for (value, class) in [
        (0.1, "early"),
        (0.5, "cheap"),
        (f32::INFINITY, "expensive"),
        (f32::NAN, "expensive"),
    ] {
        let view = texture(&gpu, [1, 1], &[[value, 0.0]]);
        let lists = bound(&gpu, &classifier, &view, [1, 1]);
        let (classes, arguments) = classes_of(&gpu, &classifier, &lists, [1, 1]);
        assert_eq!(classes, [classifier.class(class).unwrap()], "{value}");
        assert_eq!(
            arguments[classes[0] * 3..][..3],
            [16, 1, 1],
            "Wicked's tile_replicate"
        );
    }
}

#[test]
fn the_gpu_sorts_tiles_as_its_cpu_twin() {
    let gpu = common::gpu();
    let seed = common::seed();
    let own = Options {
        tile: 16,
        functions: "fn vrcs_test_middle(lo: f32, hi: f32) -> f32 { return lo; }".into(),
        ..Options::new(
            "texel.r * 2.0",
            vec![
                Class::new("below", Rule::MaxBelow(0.0)),
                Class::new(
                    "mine",
                    Rule::Wgsl("vrcs_test_middle(lo, hi) > 0.9 && hi < 1.3".into()),
                ),
                Class::new("even", Rule::RangeBelow(0.5)),
                Class::new("rest", Rule::Rest),
            ],
        )
    };
    let alone = Options {
        neighbourhood: false,
        ..own.clone()
    };
    let dof = Options::circle_of_confusion(0.4, 0.2);
    let velocity = Options::velocity(0.3, 0.2);
    let roughness = Options::roughness(0.35, 0.3);
    let one = Options::new("texel.r", vec![Class::new("all", Rule::Rest)]);
    let mut seen = [0; 8];
    for (case, options) in [own, alone, dof, velocity, roughness, one]
        .into_iter()
        .enumerate()
    {
        let classifier = Classifier::new(&gpu.device, options.clone()).unwrap();
        for (size, extent) in SIZES.into_iter().enumerate() {
            let mut rng = Rng::with_seed(seed + (case * 10 + size) as u64);
            let texels = values(extent, &mut rng, size % 2 == 0);
            let view = texture(&gpu, extent, &texels);
            let lists = bound(&gpu, &classifier, &view, extent);
            let measured: Vec<f32> = texels
                .iter()
                .map(|[r, _]| match options.measure.as_str() {
                    "texel.r * 2.0" => r * 2.0,
                    "length(texel.rg)" => r.abs(),
                    _ => *r,
                })
                .collect();
            let wanted = cpu::classify(&measured, extent, &options, |class, lo, hi| {
                assert_eq!(class, 1);
                lo > 0.9 && hi < 1.3
            });
            // two frames in a row: the counters start anew
            for frame in 0..2 {
                let (got, arguments) = classes_of(&gpu, &classifier, &lists, extent);
                assert_eq!(got, wanted, "case {case}, {extent:?}, frame {frame}");
                for class in 0..options.classes.len() {
                    let groups =
                        got.iter().filter(|&&c| c == class).count() as u32 * options.replicate();
                    let [x, y] = [arguments[class * 3], arguments[class * 3 + 1]];
                    assert_eq!(x, groups.min(65_535));
                    assert_eq!(y, groups.div_ceil(x.max(1)));
                }
            }
            for class in wanted {
                seen[class] += 1;
            }
        }
    }
    assert!(
        seen[..4].iter().all(|&count| count > 20),
        "every class has tiles: {seen:?}"
    );
}

/// The classes' shaders, each with its own pipeline, write every pixel of the extent exactly once.
#[test]
fn classes_shade_every_pixel_once() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    // the last has more blocks than one dimension holds
    for (room, extent, options) in [
        (
            [200, 100],
            [187, 93],
            Options::circle_of_confusion(0.4, 0.2),
        ),
        (
            [64, 64],
            [64, 64],
            Options {
                tile: 64,
                block: 16,
                ..Options::circle_of_confusion(0.4, 0.2)
            },
        ),
        (
            [2112, 2112],
            [2112, 2111],
            Options {
                block: 8,
                ..Options::circle_of_confusion(9.0, 0.0)
            },
        ),
    ] {
        let classifier = Classifier::new(&gpu.device, options.clone()).unwrap();
        let texels = values(room, &mut rng, false);
        let view = texture(&gpu, room, &texels);
        let lists = bound(&gpu, &classifier, &view, extent);
        let written = gpu.buffer(
            "written",
            &vec![0; (room[0] * room[1] * 4) as usize],
            wgpu::BufferUsages::STORAGE,
        );
        let own_layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries: &[wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: wgpu::ShaderStages::COMPUTE,
                    ty: wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Storage { read_only: false },
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                    count: None,
                }],
            });
        let own = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &own_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: written.as_entire_binding(),
            }],
        });
        let layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[
                    Some(&own_layout),
                    Some(&Classifier::lists_layout(&gpu.device)),
                ],
                immediate_size: 0,
            });
        let mut encoder = gpu.encoder();
        classifier.record(&mut encoder, &lists).expect("an extent");
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_bind_group(0, &own, &[]);
        for (index, class) in options.classes.iter().enumerate() {
            let text = classifier.wgsl(&class.name, 1).unwrap()
                + &format!(
                    "@group(0) @binding(0) var<storage, read_write> written: array<atomic<u32>>;
                     @compute @workgroup_size({})
                     fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {{
                         let pixel = vrcs_pixel(group, index);
                         if pixel.is_inside {{
                             atomicAdd(&written[pixel.at.y * {}u + pixel.at.x], {}u);
                         }}
                     }}",
                    options.block * options.block,
                    room[0],
                    1 << (index * 8),
                );
            let shader = gpu
                .device
                .create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: None,
                    source: wgpu::ShaderSource::Wgsl(text.into()),
                });
            let pipeline = gpu
                .device
                .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: None,
                    layout: Some(&layout),
                    module: &shader,
                    entry_point: None,
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    cache: None,
                });
            pass.set_pipeline(&pipeline);
            lists.dispatch(&mut pass, index, 1).expect("a class");
        }
        drop(pass);
        let read = gpu
            .submit_and_read(encoder, &[&written])
            .unwrap_or_else(|e| panic!("{e}"));
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&read[0]);
        let measured: Vec<f32> = (0..extent[0] * extent[1])
            .map(|i| texels[(i / extent[0] * room[0] + i % extent[0]) as usize][0])
            .collect();
        let classes = cpu::classify(&measured, extent, &options, |_, _, _| false);
        let tiles = options.tiles(extent);
        for (i, &word) in words.iter().enumerate() {
            let (x, y) = (i as u32 % room[0], i as u32 / room[0]);
            let wanted = match x < extent[0] && y < extent[1] {
                true => {
                    1 << (classes[(y / options.tile * tiles[0] + x / options.tile) as usize] * 8)
                }
                false => 0,
            };
            assert_eq!(word, wanted, "{extent:?}: pixel {x},{y}");
        }
    }
}

#[test]
fn an_extent_may_be_a_corner_and_change() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let options = Options::circle_of_confusion(0.4, 0.2);
    let classifier = Classifier::new(&gpu.device, options.clone()).unwrap();
    let room = [300, 200];
    let texels = values(room, &mut rng, false);
    let view = texture(&gpu, room, &texels);
    let mut lists = classifier.bind(&gpu.device, &view).unwrap();
    for extent in [[300, 200], [33, 33], [150, 199], [1, 1]] {
        classifier
            .set_extent(&gpu.queue, &mut lists, extent)
            .unwrap();
        let corner: Vec<f32> = (0..extent[0] * extent[1])
            .map(|i| texels[(i / extent[0] * room[0] + i % extent[0]) as usize][0])
            .collect();
        let wanted = cpu::classify(&corner, extent, &options, |_, _, _| false);
        assert_eq!(
            classes_of(&gpu, &classifier, &lists, extent).0,
            wanted,
            "{extent:?}"
        );
    }
    assert!(
        classifier
            .set_extent(&gpu.queue, &mut lists, [301, 1])
            .is_err()
    );
}

#[test]
fn what_makes_no_sense_is_refused() {
    let gpu = common::gpu();
    let refused = |options: Options| match Classifier::new(&gpu.device, options) {
        Ok(_) => panic!("accepted"),
        Err(error) => error.to_string(),
    };
    let good = Options::circle_of_confusion(0.4, 0.2);
    let with = |rule| {
        Options::new(
            "texel.r",
            vec![Class::new("a", rule), Class::new("b", Rule::Rest)],
        )
    };
    let text = refused(with(Rule::Wgsl("hi < unknown".into())));
    assert!(
        text.contains("no definition in scope") && text.contains("unknown"),
        "{text}"
    );
    let text = refused(with(Rule::Wgsl("hi + lo".into())));
    assert!(text.contains("do not compile"), "{text}");
    assert!(
        refused(Options {
            measure: "texel".into(),
            ..good.clone()
        })
        .contains("do not compile")
    );
    assert!(refused(with(Rule::MaxBelow(f32::NAN))).contains("NaN"));
    assert!(refused(with(Rule::Rest)).contains("`Rest`"));
    assert!(
        refused(Options {
            tile: 20,
            ..good.clone()
        })
        .contains("multiple of 8")
    );
    assert!(
        refused(Options {
            block: 12,
            ..good.clone()
        })
        .contains("divides")
    );
    assert!(
        refused(Options {
            classes: Vec::new(),
            ..good.clone()
        })
        .contains("1 to 8")
    );
    let twice = vec![
        Class::new("a", Rule::MaxBelow(1.0)),
        Class::new("a", Rule::Rest),
    ];
    assert!(
        refused(Options {
            classes: twice,
            ..good.clone()
        })
        .contains("called \"a\"")
    );
    let classifier = Classifier::new(&gpu.device, good).unwrap();
    assert!(
        classifier
            .wgsl("fast", 1)
            .unwrap_err()
            .to_string()
            .contains("\"fast\"")
    );
    gpu.check().unwrap_or_else(|e| panic!("{e}"));
}
