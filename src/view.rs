//! A view: one picture's shading rates, coordinate buffer and parameters, shared by all passes that shade it.
//!
//! *Needs*: the caller's device; it is only used to make resources. *Guarantees*: nothing is submitted, polled or waited for;
//! after the first frame nothing is allocated until the extent outgrows the buffers. *Refuses*: what the device has too little for,
//! and a build whose coverage is not known.

mod error;
mod params;

use std::sync::{Arc, Mutex, PoisonError};

use vrcs_passes::options::{Mode, Sky};

pub use error::ViewError;
use error::{check, check_textures};
pub use params::Params;

use crate::{
    build::{
        BuildOptions, CoordLayout,
        gpu::{BoundBuilder, Buffers, Builder},
        primary::Order,
    },
    coverage::Textures,
    dispatch::bindings::{Bindings, layout_entries},
    home::Home,
    object::ObjectOptions,
    scope,
    sri::{Sri, SriLayout},
};

/// One picture's shading rates and what is built from them.
#[derive(Debug)]
pub struct View {
    device: wgpu::Device,
    home: Home,
    label: String,
    extent: [u32; 3],
    origin: [u32; 2],
    enabled: bool,
    order: Order,
    layout: CoordLayout,
    builder: Arc<Builder>,
    buffers: Buffers,
    generation: u64,
    /// Workgroups that the device dispatches on an axis.
    most_groups: u32,
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
    /// If the extent is empty or too large for the device, the options cannot be, or the device has too little for the kernels.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        extent: [u32; 3],
        options: BuildOptions,
    ) -> Result<View, ViewError> {
        View::with(device, queue, extent, options, &ObjectOptions::default())
    }

    /// The same, with a name for captures and the caller's cache of pipelines.
    ///
    /// # Errors
    /// As [`View::new`].
    pub fn with(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        extent: [u32; 3],
        options: BuildOptions,
        objects: &ObjectOptions,
    ) -> Result<View, ViewError> {
        check(device, extent, &options)?;
        let builder = Arc::new(Builder::new(device, options, objects)?);
        View::of_builder(device, queue, extent, builder, objects)
    }

    /// Makes a view by a builder that there is.
    ///
    /// # Errors
    /// As [`View::new`].
    #[cfg(feature = "cli")]
    pub(crate) fn by(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        extent: [u32; 3],
        builder: Arc<Builder>,
    ) -> Result<View, ViewError> {
        check(device, extent, builder.options())?;
        View::of_builder(device, queue, extent, builder, &ObjectOptions::default())
    }

    /// Makes another view with this one's options, by the same pipelines: the second half of a split screen, the other eye of a
    /// headset. The two share nothing else.
    ///
    /// # Errors
    /// As [`View::new`].
    pub fn another(
        &self,
        queue: &wgpu::Queue,
        extent: [u32; 3],
        label: &str,
    ) -> Result<View, ViewError> {
        check(&self.device, extent, self.options())?;
        let (device, builder) = (&self.device, Arc::clone(&self.builder));
        View::of_builder(
            device,
            queue,
            extent,
            builder,
            &ObjectOptions::labelled(label),
        )
    }

    fn of_builder(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        extent: [u32; 3],
        builder: Arc<Builder>,
        objects: &ObjectOptions,
    ) -> Result<View, ViewError> {
        let options = builder.options();
        let size = [extent[0], extent[1]];
        let buffers = Buffers::new(device, options, size, objects);
        let bound = builder.bind(device, &buffers, &Textures::default());
        let view = View {
            label: objects.label.unwrap_or("vrcs").to_owned(),
            extent,
            origin: [0; 2],
            enabled: true,
            order: Order::Fixed,
            layout: CoordLayout::new(size, options),
            builder,
            buffers,
            generation: 0,
            most_groups: device.limits().max_compute_workgroups_per_dimension,
            bound,
            params: Mutex::default(),
            home: Home::of(device),
            device: device.clone(),
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
    /// If a declared texture is missing, too small or not what was declared; the view then stays as it is.
    pub fn cover(&mut self, queue: &wgpu::Queue, textures: &Textures) -> Result<(), ViewError> {
        check_textures(self.builder.options(), textures, self.extent, self.origin)?;
        let texels = textures.scale.saturating_add(1);
        let placed = Textures {
            sample: [0, 1].map(|axis| {
                let first = self.origin[axis].saturating_mul(texels);
                textures.sample[axis].saturating_add(first)
            }),
            ..*textures
        };
        let bind = || self.builder.bind(&self.device, &self.buffers, &placed);
        let bound = scope::caught(&self.device, bind);
        let bound = bound.map_err(|error| ViewError::Refused(scope::in_words(&error)))?;
        self.bound = Some(bound.ok_or(ViewError::Uncovered)?);
        self.write_build_params(queue);
        Ok(())
    }

    /// Lets the primaries rotate: which pixel of a group is shaded follows the frame's number (the slides' "Rotating Pixels"). Holds for
    /// builds that are recorded from now on. Uploads nothing.
    pub fn rotate(&mut self, frame: u32) {
        self.order = Order::Rotating(frame);
    }

    /// Which pixel of a group is shaded: what a [deblocker](crate::deblock::Deblocker) has to know.
    pub fn order(&self) -> Order {
        self.order
    }

    fn write_build_params(&self, queue: &wgpu::Queue) {
        if let Some(bound) = &self.bound {
            self.builder.set(queue, bound, self.extent);
        }
    }

    /// Changes the extent for what is submitted from now on. Where coverage is declared, its textures have to be
    /// [given](View::cover) again: until then, a build is refused.
    ///
    /// Buffers that are too small are made anew. Then [`generation`](View::generation) is another, and what holds the old ones has to be
    /// bound again: an [`Analyser`](crate::Analyser) and a [deblocker](crate::deblock::Deblocker::record_view) refuse to go on until it is.
    /// Bind groups of the caller's own cannot tell.
    ///
    /// # Errors
    /// If the extent is empty or too large for the device; the view then stays as it is.
    pub fn set_extent(&mut self, queue: &wgpu::Queue, extent: [u32; 3]) -> Result<(), ViewError> {
        if extent == self.extent {
            return Ok(());
        }
        let options = *self.builder.options();
        check(&self.device, extent, &options)?;
        let size = [extent[0], extent[1]];
        let fit = self.buffers.fit(&options, size);
        if !fit {
            let objects = ObjectOptions::labelled(&self.label);
            self.buffers = Buffers::new(&self.device, &options, size, &objects);
            self.generation += 1;
            self.params
                .get_mut()
                .unwrap_or_else(PoisonError::into_inner)
                .clear();
        }
        if !fit || !options.coverage.is_empty() {
            let none = Textures::default();
            self.bound = self.builder.bind(&self.device, &self.buffers, &none);
        }
        self.extent = extent;
        self.layout = CoordLayout::new(size, &options);
        self.write_build_params(queue);
        self.write_params(queue);
        Ok(())
    }

    /// Says where the view's first pixel lies in the pictures that several views share: those of the coverage, of an analysis and of a
    /// deblocker. At first it is their first corner. Where coverage is declared, its textures have to be [given](View::cover) again: until
    /// then, a build is refused. See [split screens](crate#several-views).
    ///
    /// # Errors
    /// If the extent would end beyond 65,536 pixels; the view then stays as it is.
    pub fn set_origin(&mut self, origin: [u32; 2]) -> Result<(), ViewError> {
        let is_within = |axis: usize| {
            origin[axis]
                .checked_add(self.extent[axis])
                .is_some_and(|end| end <= 1 << 16)
        };
        if !is_within(0) || !is_within(1) {
            return Err(ViewError::Origin {
                origin,
                extent: self.extent,
            });
        }
        if origin != self.origin && !self.builder.options().coverage.is_empty() {
            self.bound = None;
        }
        self.origin = origin;
        Ok(())
    }

    /// Where the view's first pixel lies in pictures that hold more than the view.
    pub fn origin(&self) -> [u32; 2] {
        self.origin
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
    /// # Errors
    /// [`ViewError::Uncovered`] if coverage is declared, and its textures were not [given](View::cover) since the extent changed; nothing is
    /// recorded then.
    pub fn build(&self, encoder: &mut wgpu::CommandEncoder) -> Result<(), ViewError> {
        self.covered()?;
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("vrcs build"),
            timestamp_writes: None,
        });
        self.build_in(&mut pass)
    }

    /// Records the build into a compute pass of the caller's. Sets pipelines and bind group 0.
    ///
    /// # Errors
    /// As [`View::build`].
    pub fn build_in(&self, pass: &mut wgpu::ComputePass) -> Result<(), ViewError> {
        let _span = tracing::trace_span!("vrcs build").entered();
        let bound = self.covered()?;
        let [width, height, _] = self.extent;
        self.builder
            .record(pass, bound, [width, height], self.order);
        Ok(())
    }

    fn covered(&self) -> Result<&BoundBuilder, ViewError> {
        self.bound.as_ref().ok_or(ViewError::Uncovered)
    }

    pub(crate) fn home(&self) -> &Home {
        &self.home
    }

    pub(crate) fn most_groups(&self) -> u32 {
        self.most_groups
    }

    /// Counts how often the buffers were made anew: bind groups of the caller's own that hold [`View::sri`], [`View::effective`] or a pass's
    /// [`Bindings`] have to be made anew, too, when this is another than it was.
    pub fn generation(&self) -> u64 {
        self.generation
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
            label: Some(&self.label),
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
            label: Some(&format!("{} params", self.label)),
            size: size_of::<Params>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: true,
        });
        // a device without memory for it, or that is lost, has told its owner, and runs nothing that reads it
        if let Ok(mut range) = buffer.get_mapped_range_mut(..) {
            range.copy_from_slice(bytemuck::bytes_of(&params));
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
