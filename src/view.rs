//! A view: one picture's shading rates, coordinate buffer and parameters, shared by all passes that shade it.
//!
//! *Needs*: the caller's device; it is only used to make resources. *Guarantees*: nothing is submitted, polled or waited for;
//! after the first frame nothing is allocated until the extent outgrows the buffers.

use std::sync::{Mutex, PoisonError};

use bytemuck::{Pod, Zeroable};

use vrcs_passes::options::{Mode, Sky};

use crate::{
    build::{
        BuildOptions, CoordLayout, LIST_HEADER, ListLayout,
        gpu::{BoundBuilder, Buffers, Builder, Sizes},
        primary::Order,
    },
    coverage::{Contradiction, Textures},
    dispatch::bindings::{Bindings, layout_entries},
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
    /// Tiles in a row of the picture; quads in a row of the graded buffer.
    pub tiles_per_row: u32,
    /// The word at which the entries start.
    pub entries: u32,
    /// Words for each tile's entries; in the classified lists, room for tiles in each class.
    pub entries_per_tile: u32,
    /// Room for entries in a list.
    pub capacity: u32,
    /// Words of an entry of a list.
    pub stride: u32,
}

impl Params {
    /// Variable-rate shading is on; without this flag every invocation shades its own pixel.
    pub const ENABLED: u32 = 1;

    /// The parameters of a dispatch over what a build made for `built`, which may be larger than the extent.
    pub fn new(
        extent: [u32; 3],
        enabled: bool,
        original_group_size: [u32; 3],
        mode: Mode,
        built: [u32; 2],
        options: &BuildOptions,
    ) -> Params {
        let layout = CoordLayout::new(built, options);
        let lists = ListLayout::new(built, options);
        let (tiles_per_row, entries, entries_per_tile) = match mode {
            Mode::Tiled => (layout.tiles[0], layout.entries, layout.entries_per_tile),
            Mode::List => (layout.tiles[0], LIST_HEADER, 0),
            Mode::Classified => (layout.tiles[0], lists.mixed(), lists.tiles),
            Mode::Graded | Mode::Auto => (lists.graded_pitch, 0, 0),
        };
        Params {
            extent,
            flags: match enabled {
                true => Params::ENABLED,
                false => 0,
            },
            groups: std::array::from_fn(|axis| {
                extent[axis].div_ceil(original_group_size[axis].max(1))
            }),
            tiles_per_row,
            entries,
            entries_per_tile,
            capacity: lists.capacity,
            stride: lists.stride,
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
    /// The options cannot be.
    #[error("{0}")]
    Options(&'static str),
    /// What the scene is said to have cannot be.
    #[error(transparent)]
    Coverage(#[from] Contradiction),
    /// A texture that the coverage declares was not given.
    #[error("coverage is declared by a texture that was not given: {0}")]
    MissingTexture(&'static str),
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
    order: Order,
    layout: CoordLayout,
    builder: Builder,
    buffers: Buffers,
    /// Nothing until the textures of declared coverage are known.
    bound: Option<BoundBuilder>,
    params: Mutex<Vec<ParamsFor>>,
}

/// The parameters for shaders of one original workgroup size and mode.
#[derive(Debug)]
struct ParamsFor {
    group_size: [u32; 3],
    mode: Mode,
    buffer: wgpu::Buffer,
    /// Bind groups, by the parameters' binding number.
    groups: Vec<(u32, wgpu::BindGroup)>,
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
        let [width, height, _] = extent;
        let buffers = Buffers::new(device, &options, [width, height]);
        let bound = builder.bind(device, &buffers, &Textures::default());
        let view = View {
            device: device.clone(),
            extent,
            enabled: true,
            order: Order::Fixed,
            layout,
            builder,
            buffers,
            bound,
            params: Mutex::default(),
        };
        view.write_build_params(queue);
        Ok(view)
    }

    /// Makes a view of a picture of `width` × `height` pixels, with the default [`BuildOptions`].
    ///
    /// # Errors
    /// As [`View::new`].
    pub fn of_size(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        [width, height]: [u32; 2],
    ) -> Result<View, ViewError> {
        View::new(device, queue, [width, height, 1], BuildOptions::default())
    }

    /// Gives the textures that the coverage declares; to be called again whenever a texture or the extent changes.
    ///
    /// # Errors
    /// If a declared texture is missing.
    pub fn cover(&mut self, queue: &wgpu::Queue, textures: &Textures) -> Result<(), ViewError> {
        let coverage = &self.builder.options().coverage;
        let missing = [
            ("triangles", coverage.triangles, textures.triangles),
            ("surfaces", coverage.surfaces, textures.surfaces),
            ("depth", coverage.depth.is_some(), textures.depth),
        ]
        .into_iter()
        .find(|(_, declared, given)| *declared && given.is_none())
        .map_or("normals", |(name, ..)| name);
        let bound = self.builder.bind(&self.device, &self.buffers, textures);
        self.bound = Some(bound.ok_or(ViewError::MissingTexture(missing))?);
        self.write_build_params(queue);
        Ok(())
    }

    /// Lets the primaries rotate: which pixel of a group is shaded follows the frame's number (the slides' "Rotating Pixels").
    /// To be called before each frame's build.
    pub fn rotate(&mut self, queue: &wgpu::Queue, frame: u32) {
        self.order = Order::Rotating(frame);
        self.write_build_params(queue);
    }

    fn write_build_params(&self, queue: &wgpu::Queue) {
        if let Some(bound) = &self.bound {
            self.builder.set(queue, bound, self.extent, self.order);
        }
    }

    /// Changes the extent for what is submitted from now on. Buffers grow if they have to. Where coverage is declared, its
    /// textures have to be [given](View::cover) again.
    ///
    /// # Errors
    /// If the extent is empty or too large for the device; the view then stays as it is.
    pub fn set_extent(&mut self, queue: &wgpu::Queue, extent: [u32; 3]) -> Result<(), ViewError> {
        let options = *self.builder.options();
        let layout = check(&self.device, extent, &options)?;
        let size = [extent[0], extent[1]];
        if !self.buffers.fit(&options, size) {
            self.buffers = Buffers::new(&self.device, &options, size);
            self.bound = self
                .builder
                .bind(&self.device, &self.buffers, &Textures::default());
            self.params
                .get_mut()
                .unwrap_or_else(PoisonError::into_inner)
                .clear();
        }
        self.extent = extent;
        self.layout = layout;
        self.write_build_params(queue);
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
        let (extent, enabled, options) = (self.extent, self.enabled, *self.builder.options());
        let size = [extent[0], extent[1]];
        let params = self
            .params
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner);
        for known in params {
            let params = Params::new(
                extent,
                enabled,
                known.group_size,
                known.mode,
                size,
                &options,
            );
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

    /// How coordinates are built.
    pub fn options(&self) -> &BuildOptions {
        self.builder.options()
    }

    /// Whether variable-rate shading is on.
    pub fn is_enabled(&self) -> bool {
        self.enabled
    }

    /// What is built; buffers that the options do not ask for do not exist.
    pub fn buffers(&self) -> &Buffers {
        &self.buffers
    }

    /// The tiled buffer, if the options ask for it.
    pub fn coords(&self) -> Option<&wgpu::Buffer> {
        self.buffers.coords.as_ref()
    }

    /// The effective rates after the build, if the options ask for them: one [byte](crate::build::effective) a quad, in the form of
    /// [`SriLayout`].
    pub fn effective(&self) -> Option<&wgpu::Buffer> {
        self.buffers.effective.as_ref()
    }

    /// The statistics of the build, if the options ask for them: copy the buffer, map the copy when it suits, and
    /// [read](crate::build::statistics::Statistics::read) its bytes. Nothing waits for them.
    pub fn statistics(&self) -> Option<&wgpu::Buffer> {
        self.buffers.statistics.as_ref()
    }

    /// The user's own bits of each tile, if the options ask for them, in the form of [`user_words`](crate::build::user_words): write
    /// them, or have a pass write them, before the build. The tile's [header](crate::build::Header::user) has them then.
    pub fn user(&self) -> Option<&wgpu::Buffer> {
        self.buffers.user.as_ref()
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
    ///
    /// # Panics
    /// If coverage is declared, and its textures were not [given](View::cover).
    pub fn build(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("vrcs build"),
            timestamp_writes: None,
        });
        self.build_in(&mut pass);
    }

    /// Records the build into a compute pass of the caller's.
    ///
    /// # Panics
    /// If coverage is declared, and its textures were not [given](View::cover).
    pub fn build_in(&self, pass: &mut wgpu::ComputePass) {
        let _span = tracing::trace_span!("vrcs build").entered();
        let Some(bound) = &self.bound else {
            panic!("the view's coverage declares textures: give them with `View::cover` first");
        };
        let [width, height, _] = self.extent;
        self.builder.record(pass, bound, [width, height]);
    }

    /// The layout of a bind group for the added bindings alone, the parameters' number being `first`.
    pub(crate) fn bind_group_layout(device: &wgpu::Device, first: u32) -> wgpu::BindGroupLayout {
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("vrcs"),
            entries: &layout_entries(first),
        })
    }

    /// The coordinate buffer of a mode; `None` if the build does not serve it.
    fn coords_of(&self, mode: Mode) -> Option<&wgpu::Buffer> {
        match mode {
            Mode::Tiled => self.buffers.coords.as_ref(),
            Mode::List => self.buffers.list.as_ref(),
            Mode::Classified => self.buffers.classified.as_ref(),
            Mode::Graded => self.buffers.graded.as_ref(),
            Mode::Auto => None,
        }
    }

    /// The parameters and the coordinate buffer for shaders of an original workgroup size and mode; `None` if the build does not
    /// serve the mode.
    pub(crate) fn bindings(
        &self,
        group_size: [u32; 3],
        mode: Mode,
    ) -> Option<(wgpu::Buffer, wgpu::Buffer)> {
        let coords = self.coords_of(mode)?;
        let mut known = self.params.lock().unwrap_or_else(PoisonError::into_inner);
        let known = self.params_for(&mut known, group_size, mode);
        Some((known.buffer.clone(), coords.clone()))
    }

    /// The bind group for shaders of an original workgroup size and mode, the parameters' number being `first`, made at the
    /// first call for each; `None` if the build does not serve the mode.
    pub(crate) fn bind_group(
        &self,
        group_size: [u32; 3],
        mode: Mode,
        first: u32,
    ) -> Option<wgpu::BindGroup> {
        let coords = self.coords_of(mode)?;
        let mut known = self.params.lock().unwrap_or_else(PoisonError::into_inner);
        let known = self.params_for(&mut known, group_size, mode);
        if let Some((_, group)) = known.groups.iter().find(|(number, _)| *number == first) {
            return Some(group.clone());
        }
        let bindings = Bindings {
            params: known.buffer.clone(),
            coords: coords.clone(),
            first,
        };
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("vrcs"),
            layout: &View::bind_group_layout(&self.device, first),
            entries: &bindings.entries(),
        });
        known.groups.push((first, group.clone()));
        Some(group)
    }

    /// The parameters for shaders of an original workgroup size and mode, made at the first call for each.
    fn params_for<'k>(
        &self,
        known: &'k mut Vec<ParamsFor>,
        group_size: [u32; 3],
        mode: Mode,
    ) -> &'k mut ParamsFor {
        let is_same = |known: &ParamsFor| known.group_size == group_size && known.mode == mode;
        if let Some(index) = known.iter().position(is_same) {
            return &mut known[index];
        }
        let params = Params::new(
            self.extent,
            self.enabled,
            group_size,
            mode,
            [self.extent[0], self.extent[1]],
            self.builder.options(),
        );
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
        known.push(ParamsFor {
            group_size,
            mode,
            buffer,
            groups: Vec::new(),
        });
        let last = known.len() - 1;
        &mut known[last]
    }

    /// The arguments of a pass's indirect dispatch, and where they stand.
    pub(crate) fn arguments(&self, mode: Mode, sky: Sky) -> Option<(&wgpu::Buffer, u64)> {
        let buffer = self.buffers.arguments.as_ref()?;
        let of_mode = match mode {
            Mode::List => 0,
            Mode::Classified => 24,
            Mode::Tiled | Mode::Graded | Mode::Auto => return None,
        };
        let of_sky = match sky {
            Sky::Skip => 0,
            Sky::Shade => 12,
        };
        Some((buffer, of_mode + of_sky))
    }
}

/// Looks for options that no kernel can be made for.
fn check_options(options: &BuildOptions) -> Result<(), ViewError> {
    let [width, height] = options.tile;
    if width == 0 || height == 0 || width > 256 || height > 256 || width * height > 256 {
        return Err(ViewError::Options("a tile has 1 to 256 pixels"));
    }
    if options.for_tile(options.tile).largest != options.largest {
        return Err(ViewError::Options(
            "groups of the largest rate would lie across the edges of tiles of this size: let `BuildOptions::for_tile` choose it",
        ));
    }
    if options.is_odd() && (options.effective || options.modes.graded) {
        return Err(ViewError::Options(
            "effective rates and the graded buffer are by quads, which tiles with an odd side do not have: use another view for them",
        ));
    }
    if !options.wave.is_power_of_two() || options.wave > 128 {
        return Err(ViewError::Options("a wave has 1, 2, 4 … 128 invocations"));
    }
    Ok(options.coverage.check()?)
}

fn check(
    device: &wgpu::Device,
    extent: [u32; 3],
    options: &BuildOptions,
) -> Result<CoordLayout, ViewError> {
    if extent.contains(&0) {
        return Err(ViewError::Empty(extent));
    }
    check_options(options)?;
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
    let bytes = Sizes::new(options, [extent[0], extent[1]]).largest();
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
