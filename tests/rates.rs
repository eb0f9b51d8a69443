//! The algebra of rates on a driver: `shaders/rate.wgsl` gives what `vrcs::rate` gives, for every pair of bytes.

mod common;

use std::borrow::Cow;

use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor};
use vrcs::{
    Rate,
    check::gpu::Gpu,
    rate::{Combiner, LargestAxis, WGSL},
};

/// For each pair of bytes: the first as a code, meet, join, within, then each combiner on either kind of device. For each pair
/// of axes that are coded in the bytes: what they resolve to.
const KERNEL: &str = "
#import vrcs::rate

@group(0) @binding(0) var<storage, read_write> results: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let first = id.x & 15u;
    let second = id.x >> 4u;
    let a = rate::or_full(first);
    let b = rate::or_full(second);
    let at = id.x * 17u;
    results[at] = a;
    results[at + 1u] = rate::meet(a, b);
    results[at + 2u] = rate::join(a, b);
    results[at + 3u] = u32(rate::is_within(a, b));
    results[at + 4u] = rate::resolve(vec2<u32>(first, second));
    for (var combiner = 0u; combiner < 6u; combiner++) {
        results[at + 5u + combiner] = rate::combine(combiner, a, b, rate::R2X2);
        results[at + 11u + combiner] = rate::combine(combiner, a, b, rate::R4X4);
    }
}
";

fn composed() -> naga::Module {
    let mut composer = Composer::default();
    composer
        .add_composable_module(ComposableModuleDescriptor {
            source: WGSL,
            file_path: "rate.wgsl",
            ..ComposableModuleDescriptor::default()
        })
        .expect("the module");
    composer
        .make_naga_module(NagaModuleDescriptor {
            source: KERNEL,
            file_path: "table.wgsl",
            ..NagaModuleDescriptor::default()
        })
        .expect("the kernel")
}

fn run(gpu: &Gpu) -> Vec<u32> {
    let module = gpu
        .device
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("table of rates"),
            source: wgpu::ShaderSource::Naga(Cow::Owned(composed())),
        });
    let pipeline = gpu
        .device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("table of rates"),
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
    let results = gpu.buffer(
        "results",
        &[0xa5; 256 * 17 * 4],
        wgpu::BufferUsages::STORAGE,
    );
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: results.as_entire_binding(),
        }],
    });
    let mut encoder = gpu.encoder();
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(4, 1, 1);
    }
    let read = gpu.submit_and_read(encoder, &[&results]).expect("results");
    bytemuck::pod_collect_to_vec(&read[0])
}

#[test]
fn kernels_have_the_algebra_of_the_library() {
    let got = run(&common::gpu());
    for pair in 0..256u32 {
        let (first, second) = (pair & 15, pair >> 4);
        let a = Rate::from_code_or_full(first as u8);
        let b = Rate::from_code_or_full(second as u8);
        let code = |rate: Rate| u32::from(rate.code());
        let mut wanted = vec![
            code(a),
            code(a.meet(b)),
            code(a.join(b)),
            u32::from(a.is_within(b)),
            code(Rate::from_log2([first, second])),
        ];
        for largest in [LargestAxis::Two, LargestAxis::Four] {
            wanted.extend(Combiner::ALL.map(|combiner| code(combiner.combine(a, b, largest))));
        }
        let at = pair as usize * 17;
        assert_eq!(
            got[at..at + 17],
            wanted,
            "{a} and {b}, bytes {first} and {second}"
        );
    }
}
