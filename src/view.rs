//! A view: one picture's shading rates, coordinate buffer and parameters, shared by all passes that shade it.
//!
//! *Needs*: the caller's device; it is only used to make resources. *Guarantees*: nothing is submitted, polled or waited for;
//! after the first frame nothing is allocated until the extent outgrows the buffers.

use std::sync::{Mutex, PoisonError};

use bytemuck::{Pod, Zeroable};

use crate::{
    build::{
        BuildOptions, CoordLayout,
        gpu::{BoundBuilder, Builder},
    },
    sri::{Sri, SriLayout},
};

/// The parameters of a rewritten shader, as in its `VrcsParams`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Params {
    /// The logical extent, in invocations.
    pub extent: [u32; 3],
    /// [`Params::ENABLED`].
    pub flags: u32,
    /// What `num_workgroups` would be in the original dispatch.
    pub groups: [u32; 3],
    /// Tiles in a row of the coordinate buffer.
    pub tiles_per_row: u32,
    /// The word at which the entries start.
    pub entries: u32,
    /// Words for each tile's entries.
    pub entries_per_tile: u32,
    /// Room to a multiple of 16 bytes.
    pub padding: [u32; 2],
}

impl Params {
    /// Variable-rate shading is on; without this flag every invocation shades its own pixel.
    pub const ENABLED: u32 = 1;

    /// The parameters of a dispatch.
    pub fn new(
        extent: [u32; 3],
        enabled: bool,
        original_group_size: [u32; 3],
        layout: &CoordLayout,
    ) -> Params {
        Params {
            extent,
            flags: match enabled {
                true => Params::ENABLED,
                false => 0,
            },
            groups: std::array::from_fn(|axis| {
                extent[axis].div_ceil(original_group_size[axis].max(1))
            }),
            tiles_per_row: layout.tiles[0],
            entries: layout.entries,
            entries_per_tile: layout.entries_per_tile,
            padding: [0; 2],
        }
    }
}

/// Why a view could not be made or changed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// There is nothing to shade.
    #[error("the extent {0:?} has no pixels")]
    Empty([u32; 3]),
    /// A buffer would be larger than the device allows.
    #[error(
        "a view of {extent:?} needs a buffer of {bytes} bytes; the device binds at most {limit}"
    )]
    TooLarge {
        /// The extent.
        extent: [u32; 3],
        /// The bytes needed.
        bytes: u64,
        /// The device's limit.
        limit: u64,
    },
    /// More workgroups on one axis than the device dispatches.
    #[error(
        "a view of {extent:?} needs {groups} workgroups on one axis; the device dispatches at most {limit}"
    )]
    TooManyGroups {
        /// The extent.
        extent: [u32; 3],
        /// The workgroups needed.
        groups: u32,
        /// The device's limit.
        limit: u32,
    },
    /// The shading-rate image is of another size.
    #[error("the shading-rate image is {got:?} quads; the view is {wanted:?}")]
    WrongSri {
        /// The image's size.
        got: [u32; 2],
        /// The view's size.
        wanted: [u32; 2],
    },
}

/// One picture's shading rates and what is built from them.
#[derive(Debug)]
pub struct View {
    device: wgpu::Device,
    extent: [u32; 3],
    enabled: bool,
    layout: CoordLayout,
    builder: Builder,
    buffers: Buffers,
    params: Mutex<Vec<ParamsFor>>,
}

#[derive(Debug)]
struct Buffers {
    sri: wgpu::Buffer,
    coords: wgpu::Buffer,
    bound: BoundBuilder,
}

/// The parameters for shaders of one original workgroup size.
#[derive(Debug)]
struct ParamsFor {
    group_size: [u32; 3],
    buffer: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl View {
    /// Makes a view of an extent: the original dispatch's invocations, or the part of them that shows.
    ///
    /// # Errors
    /// If the extent is empty or too large for the device.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        extent: [u32; 3],
        options: BuildOptions,
    ) -> Result<View, ViewError> {
        let layout = check(device, extent, &options)?;
        let builder = Builder::new(device, options);
        let buffers = Buffers::new(device, &builder, extent, &layout);
        let view = View {
            device: device.clone(),
            extent,
            enabled: true,
            layout,
            builder,
            buffers,
            params: Mutex::default(),
        };
        let [width, height, _] = extent;
        view.builder
            .set_extent(queue, &view.buffers.bound, [width, height]);
        Ok(view)
    }

    /// Changes the extent for what is submitted from now on. Buffers grow if they have to.
    ///
    /// # Errors
    /// If the extent is empty or too large for the device; the view then stays as it is.
    pub fn set_extent(&mut self, queue: &wgpu::Queue, extent: [u32; 3]) -> Result<(), ViewError> {
        let layout = check(&self.device, extent, self.builder.options())?;
        let fits = self.buffers.coords.size() >= u64::from(layout.words()) * 4
            && self.buffers.sri.size() >= SriLayout::new(extent[0], extent[1]).bytes();
        if !fits {
            self.buffers = Buffers::new(&self.device, &self.builder, extent, &layout);
            self.params
                .get_mut()
                .unwrap_or_else(PoisonError::into_inner)
                .clear();
        }
        self.extent = extent;
        self.layout = layout;
        self.builder
            .set_extent(queue, &self.buffers.bound, [extent[0], extent[1]]);
        self.write_params(queue);
        Ok(())
    }

    /// Turns variable-rate shading on or off for what is submitted from now on. Off, every pixel is shaded, by the
    /// same pipelines.
    pub fn set_enabled(&mut self, queue: &wgpu::Queue, enabled: bool) {
        self.enabled = enabled;
        self.write_params(queue);
    }

    fn write_params(&mut self, queue: &wgpu::Queue) {
        let (extent, enabled, layout) = (self.extent, self.enabled, self.layout);
        let params = self
            .params
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner);
        for known in params {
            let params = Params::new(extent, enabled, known.group_size, &layout);
            queue.write_buffer(&known.buffer, 0, bytemuck::bytes_of(&params));
        }
    }

    /// The logical extent, in invocations.
    pub fn extent(&self) -> [u32; 3] {
        self.extent
    }

    /// Where things are in the coordinate buffer.
    pub fn layout(&self) -> &CoordLayout {
        &self.layout
    }

    /// The shading-rate image: [`SriLayout`] tells its form. Write it, or have an analysis write it, before the build.
    pub fn sri(&self) -> &wgpu::Buffer {
        &self.buffers.sri
    }

    /// The coordinate buffer.
    pub fn coords(&self) -> &wgpu::Buffer {
        &self.buffers.coords
    }

    /// Uploads shading rates from memory.
    ///
    /// # Errors
    /// If the image is of another size than the view.
    pub fn write_sri(&self, queue: &wgpu::Queue, sri: &Sri) -> Result<(), ViewError> {
        let wanted = SriLayout::new(self.extent[0], self.extent[1]);
        if sri.layout() != wanted {
            return Err(ViewError::WrongSri {
                got: [sri.layout().width, sri.layout().height],
                wanted: [wanted.width, wanted.height],
            });
        }
        queue.write_buffer(&self.buffers.sri, 0, sri.bytes());
        Ok(())
    }

    /// Records the build of the coordinate buffer from the shading rates.
    pub fn build(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("vrcs build"),
            timestamp_writes: None,
        });
        self.build_in(&mut pass);
    }

    /// Records the build into a compute pass of the caller's.
    pub fn build_in(&self, pass: &mut wgpu::ComputePass) {
        let [width, height, _] = self.extent;
        self.builder
            .record(pass, &self.buffers.bound, [width, height]);
    }

    /// The layout of the bind group that rewritten shaders need.
    pub fn bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("vrcs"),
            entries: &[
                entry(0, wgpu::BufferBindingType::Uniform),
                entry(1, wgpu::BufferBindingType::Storage { read_only: true }),
            ],
        })
    }

    /// The bind group for shaders of an original workgroup size; made at the first call for each size.
    pub(crate) fn bind_group(&self, group_size: [u32; 3]) -> wgpu::BindGroup {
        let mut known = self.params.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = known.iter().find(|known| known.group_size == group_size) {
            return known.group.clone();
        }
        let params = Params::new(self.extent, self.enabled, group_size, &self.layout);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("vrcs params"),
            size: size_of::<Params>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: true,
        });
        match buffer.get_mapped_range_mut(..) {
            Ok(mut range) => range.copy_from_slice(bytemuck::bytes_of(&params)),
            Err(error) => unreachable!("a buffer that is mapped at its creation: {error}"),
        }
        buffer.unmap();
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("vrcs"),
            layout: &View::bind_group_layout(&self.device),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: buffer.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: self.buffers.coords.as_entire_binding(),
                },
            ],
        });
        known.push(ParamsFor {
            group_size,
            buffer,
            group: group.clone(),
        });
        group
    }
}

impl Buffers {
    fn new(
        device: &wgpu::Device,
        builder: &Builder,
        extent: [u32; 3],
        layout: &CoordLayout,
    ) -> Buffers {
        let buffer = |label, size| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_DST
                    | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        };
        let sri = buffer(
            "vrcs shading rates",
            SriLayout::new(extent[0], extent[1]).bytes(),
        );
        let coords = buffer("vrcs coordinates", u64::from(layout.words()) * 4);
        let bound = builder.bind(device, &sri, &coords);
        Buffers { sri, coords, bound }
    }
}

fn check(
    device: &wgpu::Device,
    extent: [u32; 3],
    options: &BuildOptions,
) -> Result<CoordLayout, ViewError> {
    if extent.contains(&0) {
        return Err(ViewError::Empty(extent));
    }
    let limits = device.limits();
    let groups = [
        extent[0].div_ceil(options.tile[0]),
        extent[1].div_ceil(options.tile[1]),
        extent[2],
    ];
    let limit = limits.max_compute_workgroups_per_dimension;
    if let Some(&groups) = groups.iter().find(|&&groups| groups > limit) {
        return Err(ViewError::TooManyGroups {
            extent,
            groups,
            limit,
        });
    }
    let layout = CoordLayout::new([extent[0], extent[1]], options);
    let bytes = (u64::from(layout.words()) * 4).max(SriLayout::new(extent[0], extent[1]).bytes());
    let limit = limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size);
    match bytes > limit {
        true => Err(ViewError::TooLarge {
            extent,
            bytes,
            limit,
        }),
        false => Ok(layout),
    }
}
