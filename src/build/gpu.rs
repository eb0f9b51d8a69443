//! The coordinate builder on the GPU: `shaders/build.wgsl` and `shaders/finish.wgsl`, recorded into the caller's own pass.
//!
//! *Guarantees*: what the options do not ask for is neither compiled nor bound; nothing is read back, and the counters are
//! zero again when the build is done.

use bytemuck::{Pod, Zeroable};

pub use super::buffers::{Buffers, Sizes};
use super::{
    BuildOptions, CoordLayout, ListLayout,
    buffers::{Resource, has_counters, has_lists},
    primary::Order,
};
use crate::{
    coverage::{Normals, Sky, Textures},
    kernel::{self, shader},
    limits::LimitError,
    object::ObjectOptions,
    plan::PlannedPass,
    rate::Rate,
    slots::Slots,
    sri::SriLayout,
};

/// The kernel's parameters, as in `shaders/build.wgsl`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct Params {
    extent: [u32; 2],
    sample_at: [u32; 2],
    plane: [f32; 2],
    sample_scale: u32,
    tiles_per_row: u32,
    tile_count: u32,
    entries: u32,
    entries_per_tile: u32,
    full: u32,
    largest: u32,
    sri_pitch: u32,
    phase: u32,
    list_capacity: u32,
    list_stride: u32,
    mixed: u32,
    graded_pitch: u32,
    wave: u32,
    depth_scale: f32,
    depth_bias: f32,
    depth_tolerance: f32,
    normal_tolerance: u32,
    sky: u32,
    layers: u32,
    linear_factor: f32,
    linear_near: f32,
    linear_share: f32,
    padding: u32,
}

impl Params {
    /// The parameters of a build. `sample` is the coverage textures' scale, and which of a pixel's texels is looked at.
    fn new(options: &BuildOptions, extent: [u32; 3], order: Order, sample: [u32; 3]) -> Params {
        let size = [extent[0], extent[1]];
        let layout = CoordLayout::new(size, options);
        let lists = ListLayout::new(size, options);
        let coverage = &options.coverage;
        let [depth_scale, depth_bias] = coverage
            .depth
            .and_then(|depth| depth.kind.to_inverse())
            .unwrap_or_default();
        let tangents = match coverage.normals {
            Some(Normals::Rebuilt { tangents, .. }) => tangents,
            _ => [1.0; 2],
        };
        let [scale, x, y] = sample;
        Params {
            extent: size,
            sample_at: [x, y],
            plane: [0, 1].map(|axis| size[axis] as f32 / (2.0 * tangents[axis])),
            sample_scale: scale,
            tiles_per_row: layout.tiles[0],
            tile_count: layout.tile_count(),
            entries: layout.entries,
            entries_per_tile: layout.entries_per_tile,
            full: options.full(),
            largest: u32::from(options.largest.code()),
            sri_pitch: SriLayout::new(size[0], size[1]).pitch / 4,
            phase: order.code(),
            list_capacity: lists.capacity,
            list_stride: lists.stride,
            mixed: lists.mixed(),
            graded_pitch: lists.graded_pitch,
            wave: options.wave,
            depth_scale,
            depth_bias,
            depth_tolerance: coverage
                .depth
                .map_or(0.0, |depth| 0.5f32.powi(depth.tolerance as i32)),
            normal_tolerance: coverage.normals.map_or(1, Normals::tolerance),
            sky: match coverage.sky {
                Some(Sky::Triangle(sky) | Sky::Surface(sky)) => sky,
                _ => 0,
            },
            layers: extent[2],
            linear_factor: match (options.linear_depth, coverage.depth) {
                (Some(linear), Some(depth)) => linear.factor(depth.kind),
                _ => 0.0,
            },
            linear_near: options.linear_depth.map_or(0.0, |linear| linear.near),
            linear_share: options
                .linear_depth
                .map_or(0.0, |linear| 1.0 / (linear.far - linear.near)),
            padding: 0,
        }
    }
}

/// The bytes of the parameters of a build without coverage, for a host that is not this one.
pub(crate) fn params(options: &BuildOptions, extent: [u32; 3], order: Order) -> Vec<u8> {
    bytemuck::bytes_of(&Params::new(options, extent, order, [0; 3])).to_vec()
}

/// The parameters of `shaders/finish.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct FinishParams {
    tile_area: u32,
    layers: u32,
    phase: u32,
    padding: u32,
}

/// The pipelines that build coordinate buffers with given options.
#[derive(Debug)]
pub struct Builder {
    options: BuildOptions,
    label: String,
    build: Kernel,
    finish: Option<Kernel>,
}

#[derive(Debug)]
struct Kernel {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
    bindings: Vec<(u32, Resource)>,
}

/// The kernel, with its rooms. Groups within a quad are found in registers.
const KERNEL: kernel::Source = shader!(
    "build.wgsl",
    "build/bindings.wgsl",
    "build/memory.wgsl",
    "build/coverage.wgsl",
    "build/rates.wgsl",
    "build/order.wgsl",
    "build/quads.wgsl",
    "build/groups.wgsl",
    "build/lists.wgsl",
);

/// The kernel for what [`is_wordwise`].
const WORDS_KERNEL: kernel::Source = shader!("build/words.wgsl", "build/bindings.wgsl");

/// The kernel that builds with these options.
pub(crate) fn kernel(options: &BuildOptions) -> kernel::Source {
    match is_wordwise(options) {
        true => WORDS_KERNEL,
        false => KERNEL,
    }
}

/// Whether no group is larger than a quad, and the tile's quads are the picture's.
fn is_local(options: &BuildOptions) -> bool {
    options.largest.is_within(Rate::R2X2) && !options.is_odd()
}

/// Whether an invocation builds the four quads whose rates are one word.
fn is_wordwise(options: &BuildOptions) -> bool {
    is_local(options) && options.coverage.is_empty() && options.tile[0].is_multiple_of(8)
}

/// How many tiles, beside one another, a workgroup builds: as many as make 256 invocations, or 32 with four quads each (one wave, which is
/// what a GPU likes best: see shaders/NOTES.md), and sixteen at most. Samples of coverage fill its memory with one.
fn tiles_together(options: &BuildOptions) -> u32 {
    let [across, down] = options.quads();
    match (options.coverage.is_empty(), is_wordwise(options)) {
        (false, _) => 1,
        (true, false) => (256 / (across * down)).clamp(1, 16),
        (true, true) => (32 * 4 / (across * down)).clamp(1, 16),
    }
}

/// The workgroups of the builder's dispatch.
pub(crate) fn groups(options: &BuildOptions, extent: [u32; 2]) -> [u32; 2] {
    let [across, down] = CoordLayout::new(extent, options).tiles;
    [across.div_ceil(tiles_together(options)), down]
}

/// What the kernels are compiled with.
pub(crate) fn defs(options: &BuildOptions) -> Vec<(&'static str, u32)> {
    let (modes, coverage) = (options.modes, &options.coverage);
    let mut defs = vec![
        ("TILE_WIDTH", options.tile[0]),
        ("TILE_HEIGHT", options.tile[1]),
        ("TILES", tiles_together(options)),
    ];
    let switches = [
        ("TILED", modes.tiled),
        ("LIST", modes.list),
        ("CLASSIFIED", modes.classified),
        ("GRADED", modes.graded),
        ("EFFECTIVE", options.effective),
        ("STATISTICS", options.statistics),
        ("USER", options.user),
        ("LINEAR_DEPTH", options.linear_depth.is_some()),
        ("COUNTERS", has_counters(options)),
        ("ARGUMENTS", has_lists(options)),
        ("ODD", options.is_odd()),
        ("LOCAL", is_local(options)),
        ("SHARED_WORDS", options.tile[0].is_multiple_of(8)),
        ("STORED", modes.tiled || modes.list || modes.classified),
        ("BY_TILE", modes.tiled || modes.classified),
        (
            "ONE_PLANE",
            coverage.normals.is_some() && coverage.depth.is_some(),
        ),
    ];
    defs.extend(switches.iter().filter(|s| s.1).map(|&(name, _)| (name, 1)));
    defs.extend(coverage.defs());
    defs
}

/// The passes of a builder with these options, as [`Builder::new`] makes them.
pub(crate) fn planned(options: &BuildOptions) -> Vec<PlannedPass> {
    let defs = defs(options);
    let finish = has_counters(options).then_some(shader!("finish.wgsl"));
    [kernel(options)]
        .into_iter()
        .chain(finish)
        .map(|source| kernel::planned(source, &defs))
        .collect()
}

/// The bindings of a builder to the buffers of one view.
#[derive(Debug)]
pub struct BoundBuilder {
    params: Slots,
    group: wgpu::BindGroup,
    finish: Option<(Slots, wgpu::BindGroup)>,
    sample: [u32; 3],
}

impl Builder {
    /// Makes the pipelines.
    ///
    /// # Errors
    /// If the device has too little for them.
    pub fn new(
        device: &wgpu::Device,
        options: BuildOptions,
        objects: &ObjectOptions,
    ) -> Result<Builder, LimitError> {
        let coverage = &options.coverage;
        let octahedral = matches!(coverage.normals, Some(Normals::Octahedral { .. }));
        let modes = options.modes;
        let build = [
            (0, Resource::Params, true),
            (1, Resource::Sri, true),
            (2, Resource::Coords, modes.tiled),
            (3, Resource::Counters, has_counters(&options)),
            (4, Resource::List, modes.list),
            (5, Resource::Classified, modes.classified),
            (6, Resource::Effective, options.effective),
            (7, Resource::Graded, modes.graded),
            (8, Resource::Triangles, coverage.triangles),
            (9, Resource::Surfaces, coverage.surfaces),
            (10, Resource::Depth, coverage.depth.is_some()),
            (11, Resource::Normals, octahedral),
            (12, Resource::User, options.user),
        ];
        let finish = [
            (0, Resource::Params, true),
            (1, Resource::Counters, true),
            (2, Resource::List, modes.list),
            (3, Resource::Classified, modes.classified),
            (4, Resource::Arguments, has_lists(&options)),
            (5, Resource::Statistics, options.statistics),
        ];
        let defs = defs(&options);
        let kernel = |source, entry, bindings: &[_]| {
            Kernel::new(device, source, entry, &defs, bindings, objects)
        };
        Ok(Builder {
            options,
            label: objects.name("build"),
            build: kernel(self::kernel(&options), "build", &build)?,
            finish: match has_counters(&options) {
                true => Some(kernel(shader!("finish.wgsl"), "finish", &finish)?),
                false => None,
            },
        })
    }

    /// The options.
    pub fn options(&self) -> &BuildOptions {
        &self.options
    }

    /// Binds buffers, and the textures that coverage is told by; `None` if a declared texture is missing. [`Builder::set`] has to
    /// follow.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        buffers: &Buffers,
        textures: &Textures,
    ) -> Option<BoundBuilder> {
        let label = format!("{} params", self.label);
        let params = Slots::new(device, size_of::<Params>(), &label);
        let finish = match &self.finish {
            None => None,
            Some(kernel) => {
                let params = Slots::new(device, size_of::<FinishParams>(), &label);
                let group = kernel.bind(device, &params, buffers, textures, &self.label)?;
                Some((params, group))
            }
        };
        let build = &self.build;
        Some(BoundBuilder {
            group: build.bind(device, &params, buffers, textures, &self.label)?,
            params,
            finish,
            sample: [textures.scale, textures.sample[0], textures.sample[1]],
        })
    }

    /// Sets the extent of the picture for dispatches that are submitted from now on.
    pub fn set(&self, queue: &wgpu::Queue, bound: &BoundBuilder, extent: [u32; 3]) {
        let options = &self.options;
        bound.params.write(queue, |order| {
            Params::new(options, extent, order, bound.sample)
        });
        if let Some((params, _)) = &bound.finish {
            params.write(queue, |order| FinishParams {
                tile_area: options.area(),
                layers: extent[2],
                phase: order.code(),
                padding: 0,
            });
        }
    }

    /// Records the build into a compute pass, given how primaries are chosen.
    pub fn record(
        &self,
        pass: &mut wgpu::ComputePass,
        bound: &BoundBuilder,
        extent: [u32; 2],
        order: Order,
    ) {
        let [x, y] = groups(&self.options, extent);
        pass.push_debug_group(&self.label);
        pass.set_pipeline(&self.build.pipeline);
        pass.set_bind_group(0, &bound.group, &[bound.params.offset(order)]);
        pass.dispatch_workgroups(x, y, 1);
        if let (Some(kernel), Some((params, group))) = (&self.finish, &bound.finish) {
            pass.set_pipeline(&kernel.pipeline);
            pass.set_bind_group(0, group, &[params.offset(order)]);
            pass.dispatch_workgroups(1, 1, 1);
        }
        pass.pop_debug_group();
    }
}

impl Kernel {
    fn new(
        device: &wgpu::Device,
        source: kernel::Source,
        entry: &str,
        defs: kernel::Defs,
        bindings: &[(u32, Resource, bool)],
        objects: &ObjectOptions,
    ) -> Result<Kernel, LimitError> {
        let bindings: Vec<(u32, Resource)> = bindings
            .iter()
            .filter(|binding| binding.2)
            .map(|&(binding, resource, _)| (binding, resource))
            .collect();
        let entries: Vec<_> = bindings
            .iter()
            .map(|&(binding, resource)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: binding_type(resource),
                count: None,
            })
            .collect();
        // SAFETY: every loop runs to a constant or to what a tile holds, or takes a bit off a word in each round
        let module = unsafe { kernel::trusted_module(device, source, defs) }?;
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(&objects.name(entry)),
            entries: &entries,
        });
        Ok(Kernel {
            pipeline: kernel::pipeline(
                device,
                &layout,
                &module,
                entry,
                kernel::compilation_options(),
                objects,
            ),
            layout,
            bindings,
        })
    }

    fn bind(
        &self,
        device: &wgpu::Device,
        params: &Slots,
        buffers: &Buffers,
        textures: &Textures,
        label: &str,
    ) -> Option<wgpu::BindGroup> {
        let texture = |view: Option<_>| view.map(wgpu::BindingResource::TextureView);
        let entries: Option<Vec<_>> = self
            .bindings
            .iter()
            .map(|&(binding, resource)| {
                let resource = match resource {
                    Resource::Params => Some(params.binding()),
                    Resource::Triangles => texture(textures.triangles),
                    Resource::Surfaces => texture(textures.surfaces),
                    Resource::Depth => texture(textures.depth),
                    Resource::Normals => texture(textures.normals),
                    buffer => buffers.get(buffer).map(wgpu::Buffer::as_entire_binding),
                };
                Some(wgpu::BindGroupEntry {
                    binding,
                    resource: resource?,
                })
            })
            .collect();
        Some(device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(label),
            layout: &self.layout,
            entries: &entries?,
        }))
    }
}

fn binding_type(resource: Resource) -> wgpu::BindingType {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let texture = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    match resource {
        Resource::Params => wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: true,
            min_binding_size: None,
        },
        Resource::Sri | Resource::User => {
            buffer(wgpu::BufferBindingType::Storage { read_only: true })
        }
        Resource::Triangles | Resource::Surfaces => texture(wgpu::TextureSampleType::Uint),
        Resource::Depth | Resource::Normals => {
            texture(wgpu::TextureSampleType::Float { filterable: false })
        }
        _ => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
    }
}
