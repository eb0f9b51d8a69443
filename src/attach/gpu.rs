//! The hardware-VRS image on the GPU: `shaders/attach.wgsl`, recorded into the caller's own pass.

use bytemuck::{Pod, Zeroable};

use super::{AttachOptions, AttachmentLayout};
use crate::{
    kernel::{self, shader},
    limits::LimitError,
    object::ObjectOptions,
    scope,
    sri::SriLayout,
};

/// The kernel's parameters, as in `shaders/attach.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Params {
    quads: [u32; 2],
    tiles: [u32; 2],
    sri_pitch: u32,
    pitch: u32,
    pad: [u32; 2],
    texels: [u8; 16],
}

/// The pixels that a workgroup covers.
const GROUP: [u32; 2] = [128, 32];

/// The pipeline that makes hardware-VRS images with given options.
#[derive(Debug)]
pub struct Attacher {
    options: AttachOptions,
    label: String,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

/// The bindings of an attacher to one shading-rate image and one buffer for the hardware-VRS image.
#[derive(Debug)]
pub struct BoundAttacher {
    size: [u32; 2],
    /// Bytes of the shading-rate image and of the hardware's.
    room: [u64; 2],
    params: wgpu::Buffer,
    group: wgpu::BindGroup,
}

/// Why there is no hardware-VRS image.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AttachError {
    /// The device has too little for the kernel.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// wgpu does not bind a buffer: it lacks the usage `STORAGE`, or belongs to another device.
    #[error("attach: wgpu does not bind what was given: {0}")]
    Refused(String),
    /// A buffer is too small for a picture.
    #[error(
        "attach: the {what} of a picture of {size:?} pixels has {wanted} bytes, the buffer {got}"
    )]
    Small {
        /// Which.
        what: &'static str,
        /// The picture's size.
        size: [u32; 2],
        /// The buffer's bytes.
        got: u64,
        /// The least.
        wanted: u64,
    },
}

impl Attacher {
    /// Makes the pipeline.
    ///
    /// # Errors
    /// If the device has too little for it.
    pub fn new(device: &wgpu::Device, options: AttachOptions) -> Result<Attacher, AttachError> {
        Attacher::with(device, options, &ObjectOptions::default())
    }

    /// The same, with a name for captures and the caller's cache of pipelines.
    ///
    /// # Errors
    /// As [`Attacher::new`].
    pub fn with(
        device: &wgpu::Device,
        options: AttachOptions,
        objects: &ObjectOptions,
    ) -> Result<Attacher, AttachError> {
        let buffer = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(&objects.name("attach")),
            entries: &[
                buffer(0, wgpu::BufferBindingType::Uniform),
                buffer(1, wgpu::BufferBindingType::Storage { read_only: true }),
                buffer(2, wgpu::BufferBindingType::Storage { read_only: false }),
            ],
        });
        let defs = [("TILE", options.tile.side())];
        let module = kernel::shader_module(device, shader!("attach.wgsl"), &defs)?;
        // its workgroup memory has to be zero at first
        let zeroed = wgpu::PipelineCompilationOptions::default();
        let pipeline = kernel::pipeline(device, &layout, &module, "attach", zeroed, objects);
        Ok(Attacher {
            options,
            label: objects.name("attach"),
            layout,
            pipeline,
        })
    }

    /// The options.
    pub fn options(&self) -> &AttachOptions {
        &self.options
    }

    /// A buffer for the image of a picture of a size in pixels, to be written here and copied to a texture.
    pub fn buffer(&self, device: &wgpu::Device, size: [u32; 2]) -> wgpu::Buffer {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("vrcs attachment"),
            size: AttachmentLayout::new(size, self.options.tile).bytes(),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        })
    }

    /// Binds a shading-rate image, in [`SriLayout`], and a buffer for the hardware-VRS image, in [`AttachmentLayout`].
    /// [`Attacher::set_size`] has to follow.
    ///
    /// # Errors
    /// If wgpu does not bind a buffer.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        sri: &wgpu::Buffer,
        attachment: &wgpu::Buffer,
    ) -> Result<BoundAttacher, AttachError> {
        scope::caught(device, || self.bound(device, sri, attachment))
            .map_err(|error| AttachError::Refused(scope::in_words(&error)))
    }

    fn bound(
        &self,
        device: &wgpu::Device,
        sri: &wgpu::Buffer,
        attachment: &wgpu::Buffer,
    ) -> BoundAttacher {
        let params = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(&self.label),
            size: size_of::<Params>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&self.label),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: params.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: sri.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 2,
                    resource: attachment.as_entire_binding(),
                },
            ],
        });
        BoundAttacher {
            size: [0, 0],
            room: [sri.size(), attachment.size()],
            params,
            group,
        }
    }

    /// Sets the size of the picture, in pixels, for dispatches that are recorded from now on.
    ///
    /// # Errors
    /// If a buffer is too small for it; the size then stays as it is.
    pub fn set_size(
        &self,
        queue: &wgpu::Queue,
        bound: &mut BoundAttacher,
        size: [u32; 2],
    ) -> Result<(), AttachError> {
        let sri = SriLayout::new(size[0], size[1]);
        let layout = AttachmentLayout::new(size, self.options.tile);
        let needs = [
            ("shading-rate image", sri.bytes()),
            ("hardware's image", layout.bytes()),
        ];
        for ((what, wanted), got) in needs.into_iter().zip(bound.room) {
            if got < wanted {
                return Err(AttachError::Small {
                    what,
                    size,
                    got,
                    wanted,
                });
            }
        }
        bound.size = size;
        let params = Params {
            quads: [sri.width, sri.height],
            tiles: [layout.width, layout.height],
            sri_pitch: sri.pitch / 4,
            pitch: layout.pitch / 4,
            pad: [0; 2],
            texels: self.options.table(),
        };
        queue.write_buffer(&bound.params, 0, bytemuck::bytes_of(&params));
        Ok(())
    }

    /// Records the work into a compute pass. Writes each row's tiles, rounded up to whole words; leaves the rest of its
    /// padding alone. Before [`Attacher::set_size`], there is nothing to do.
    pub fn record(&self, pass: &mut wgpu::ComputePass, bound: &BoundAttacher) {
        let _span = tracing::trace_span!("vrcs attach").entered();
        let size = bound.size;
        pass.push_debug_group(&self.label);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &bound.group, &[]);
        pass.dispatch_workgroups(size[0].div_ceil(GROUP[0]), size[1].div_ceil(GROUP[1]), 1);
        pass.pop_debug_group();
    }
}
