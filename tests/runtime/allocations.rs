//! A steady frame costs what wgpu itself costs.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use vrcs::{
    View,
    analyse::Frame,
    build::BuildOptions,
    check::gpu::Gpu,
    deblock::{self, Deblocker, Inputs, Packing, Picture, PictureInput},
};

use crate::{
    common,
    renderer::{Drawn, SIZE},
};

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

/// The commands of [`Drawn::record`], recorded by hand: an analysis, a build of two dispatches, an indirect dispatch; each in its debug
/// group. Pipelines and bind groups are as many as there, since wgpu leaves out what is set already.
struct ByHand {
    pipelines: [wgpu::ComputePipeline; 4],
    groups: [wgpu::BindGroup; 5],
    arguments: wgpu::Buffer,
}

impl ByHand {
    fn new(gpu: &Gpu) -> ByHand {
        let module = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: None,
                source: wgpu::ShaderSource::Wgsl("@compute @workgroup_size(1) fn main() {}".into()),
            });
        let layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries: &[],
            });
        ByHand {
            pipelines: std::array::from_fn(|_| {
                gpu.device
                    .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                        label: None,
                        layout: None,
                        module: &module,
                        entry_point: None,
                        compilation_options: Default::default(),
                        cache: None,
                    })
            }),
            groups: std::array::from_fn(|_| {
                gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: None,
                    layout: &layout,
                    entries: &[],
                })
            }),
            arguments: gpu.buffer("arguments", &[0; 12], wgpu::BufferUsages::INDIRECT),
        }
    }

    fn record(&self, pass: &mut wgpu::ComputePass) {
        let [analyse, build, finish, light] = &self.pipelines;
        let [pictures, coordinates, counters, own, added] = &self.groups;
        pass.push_debug_group("vrcs analyse");
        pass.set_bind_group(0, pictures, &[]);
        pass.set_pipeline(analyse);
        pass.dispatch_workgroups(1, 1, 1);
        pass.pop_debug_group();

        pass.push_debug_group("vrcs build");
        pass.set_pipeline(build);
        pass.set_bind_group(0, coordinates, &[0]);
        pass.dispatch_workgroups(1, 1, 1);
        pass.set_pipeline(finish);
        pass.set_bind_group(0, counters, &[0]);
        pass.dispatch_workgroups(1, 1, 1);
        pass.pop_debug_group();

        pass.set_bind_group(0, own, &[]);
        pass.push_debug_group("fill.wgsl main");
        pass.set_pipeline(light);
        pass.set_bind_group(1, added, &[]);
        pass.dispatch_workgroups_indirect(&self.arguments, 0);
        pass.pop_debug_group();
    }
}

/// What a frame allocates is what wgpu allocates for its commands, to the block: the list of commands, the labels, the offsets.
#[test]
fn a_steady_frame_allocates_nothing_but_what_its_commands_do_by_hand() {
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
    let by_hand = ByHand::new(&gpu);
    let mut encoder = gpu.encoder();
    let mut compute = encoder.begin_compute_pass(&Default::default());
    let bare = allocations(|| by_hand.record(&mut compute));
    drop(compute);
    println!("allocations of frames: {counts:?}; of their commands by hand: {bare}");
    assert!(bare > 0, "the counter counts");
    let steady = counts.split_off(2);
    assert_eq!(steady, [bare; 6]);
}

/// The same of the stages after: a deblocker that follows a view with rotating primaries.
#[test]
fn a_steady_deblocker_allocates_nothing_but_what_its_commands_do_by_hand() {
    let gpu = common::gpu();
    let built = BuildOptions {
        effective: true,
        ..BuildOptions::default()
    };
    let mut view = View::new(&gpu.device, &gpu.queue, [64, 48, 1], built).expect("a view");
    let options = deblock::Options::new(Picture::Buffer(Packing::Rgba8Unorm));
    let deblocker = Deblocker::new(&gpu.device, None, options).expect("a deblocker");
    let picture = gpu.buffer("picture", &[0; 64 * 48 * 4], wgpu::BufferUsages::STORAGE);
    let inputs = Inputs::of_view(&view, PictureInput::Buffer(&picture, 64)).expect("rates");
    let bound = deblocker.bind(&gpu.device, &inputs).expect("bound");
    let mut counts = Vec::new();
    for number in 0..8 {
        let mut encoder = gpu.encoder();
        let mut compute = encoder.begin_compute_pass(&Default::default());
        view.rotate(number);
        counts.push(allocations(|| {
            deblocker
                .record_view(&gpu.queue, &mut compute, &bound, &view)
                .expect("bound to it");
        }));
        drop(compute);
        gpu.queue.submit([encoder.finish()]);
    }
    let by_hand = ByHand::new(&gpu);
    let mut encoder = gpu.encoder();
    let mut compute = encoder.begin_compute_pass(&Default::default());
    let bare = allocations(|| {
        compute.push_debug_group("vrcs deblock");
        compute.set_pipeline(&by_hand.pipelines[0]);
        compute.set_bind_group(0, &by_hand.groups[0], &[0]);
        compute.dispatch_workgroups(1, 1, 1);
        compute.pop_debug_group();
    });
    drop(compute);
    println!("allocations of frames: {counts:?}; of their commands by hand: {bare}");
    assert_eq!(counts.split_off(1), [bare; 7]);
}
