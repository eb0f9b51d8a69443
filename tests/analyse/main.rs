//! The analysis on the GPU makes the same bytes as its integer twin, whatever is compiled into it.

#[path = "../common/mod.rs"]
mod common;

mod cameras;
mod chance;
mod granularity;
mod lines;
mod made;
mod neutral;
mod oracle;
mod tiles;

use fastrand::Rng;
use vrcs::{
    Plan, Scene,
    analyse::{Analysis, Frame, integer},
    plan::Binding,
};

use chance::settings;
use made::{Made, assert_equal};

#[test]
fn the_gpu_makes_the_bytes_of_its_integer_twin() {
    let gpu = common::gpu();
    let seed = common::seed();
    let cases = std::env::var("VRCS_CASES")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(10);
    let sizes = [
        [64u32, 32],
        [1, 1],
        [3, 2],
        [67, 35],
        [130, 9],
        [17, 70],
        [8, 4],
        [31, 33],
    ];
    for case in 0..cases {
        let mut rng = Rng::with_seed(seed + case);
        let mut scene = Scene::default();
        let settings = settings(&mut rng, &mut scene);
        let plan = Plan::new(&scene, &settings).expect("settings that the scene serves");
        let size = sizes[rng.usize(..sizes.len())];
        let previous = if rng.u32(..3) == 0 {
            [size[0].div_ceil(2) + 1, size[1] + 3]
        } else {
            size
        };
        let frame = Frame {
            previous_size: previous,
            has_history: rng.u32(..16) > 0,
            resolution_scale: 0.5 + rng.f64() / 2.0,
            ..Frame::of_size(size)
        };
        let made = Made::new(size, previous, &mut rng);
        let wanted =
            integer::analyse(&made.inputs(&plan, &frame), &settings).expect("inputs that fit");
        let got = made.run(&gpu, &plan, &frame);
        println!("case {case}: {size:?}");
        assert_equal(&got, &wanted, &plan);
        if let Some(half) = &wanted.half {
            let layout = half.layout();
            for (x, y) in (0..layout.height).flat_map(|y| (0..layout.width).map(move |x| (x, y))) {
                let at = (y * layout.pitch + x) as usize;
                assert_eq!(got[4][at], half.code(x, y), "half of {x},{y}\n{plan}");
            }
        }
        if plan.bindings.contains(&Binding::SqrtLuma) {
            let pitch = previous[0].next_multiple_of(256);
            for (x, y) in (0..previous[1]).flat_map(|y| (0..previous[0]).map(move |x| (x, y))) {
                let at = (y * pitch + x) as usize;
                assert_eq!(got[3][at], wanted.sqrt_luma[at], "√luma of {x},{y}");
            }
        }
    }
}

#[test]
fn every_plan_is_made_under_wgpus_default_limits() {
    let adapters = vrcs::check::gpu::adapters();
    let adapter = adapters.first().expect("a driver");
    let (device, _queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_limits: wgpu::Limits::default(),
        ..wgpu::DeviceDescriptor::default()
    }))
    .expect("a device that asks for nothing");
    let seed = common::seed();
    for case in 0..12 {
        let mut rng = Rng::with_seed(seed + case);
        let mut scene = Scene::default();
        let settings = settings(&mut rng, &mut scene);
        let plan = Plan::new(&scene, &settings).expect("settings that the scene serves");
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let analysis = Analysis::new(&device, &plan).expect("a device for it");
        let error = pollster::block_on(scope.pop());
        assert!(error.is_none(), "{error:?}\n{}", analysis.plan());
    }
}
