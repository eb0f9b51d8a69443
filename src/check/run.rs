//! Runs builds of a shader over made-up resources, and reads back what they wrote.

use naga::{Module, ResourceBinding, valid::ModuleInfo};

use super::{
    gpu::{Gpu, GpuError},
    inputs::{Made, MadeKind, write_texture},
};
use crate::dispatch::reflect::{self, Resource, Unbindable};

/// A build of a shader, as a pipeline.
#[derive(Debug)]
pub struct Program {
    pipeline: wgpu::ComputePipeline,
    resources: Vec<Resource>,
    layouts: Vec<Option<wgpu::BindGroupLayout>>,
}

/// Why a build could not be made or run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The device would not have it, or stopped working.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// wgpu cannot bind one of its resources.
    #[error(transparent)]
    Unbindable(#[from] Unbindable),
}

/// How a build is handed to the device.
#[derive(Clone, Copy, Debug)]
pub enum Code<'c> {
    /// As WGSL.
    Text(&'c str),
    /// As naga's module.
    Module,
}

/// A build of a shader, before it is a pipeline.
#[derive(Clone, Copy, Debug)]
pub struct Build<'b> {
    /// Its name in captures.
    pub label: &'b str,
    /// The module.
    pub module: &'b Module,
    /// What naga knows of it.
    pub info: &'b ModuleInfo,
    /// The entry point's number.
    pub entry: usize,
    /// How it is handed over.
    pub code: Code<'b>,
    /// Values of its overrides.
    pub constants: &'b [(String, f64)],
    /// The bytes of its immediates.
    pub immediate_size: u32,
}

/// A resource that is bound besides the author's.
pub type Extra<'e> = (ResourceBinding, &'e wgpu::Buffer);

/// What a shader wrote: the bytes of each written resource, in the order of [`Made`].
pub type Outputs = Vec<Vec<u8>>;

impl Program {
    /// Makes the pipeline of an entry point.
    ///
    /// # Errors
    /// If the device refuses it.
    pub fn new(gpu: &Gpu, build: Build) -> Result<Program, RunError> {
        let Build {
            label,
            module,
            info,
            entry,
            code,
            constants,
            immediate_size,
        } = build;
        let resources = reflect::resources(module, info, entry)?;
        let layouts = reflect::group_layouts(&gpu.device, &resources, label);
        // wgpu checks what it is given, and that the device has the features for it
        let plain = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: match code {
                    Code::Text(text) => wgpu::ShaderSource::Wgsl(text.into()),
                    Code::Module => {
                        wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module.clone()))
                    }
                },
            });
        gpu.check()?;
        let shader = exact_shader(gpu, &build, &resources)?.unwrap_or(plain);
        let groups: Vec<_> = layouts.iter().map(Option::as_ref).collect();
        let layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: &groups,
                immediate_size,
            });
        let constants: Vec<(&str, f64)> = constants
            .iter()
            .map(|(name, value)| (name.as_str(), *value))
            .collect();
        let pipeline = gpu
            .device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(label),
                layout: Some(&layout),
                module: &shader,
                entry_point: Some(&module.entry_points[entry].name),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &constants,
                    ..wgpu::PipelineCompilationOptions::default()
                },
                cache: None,
            });
        gpu.check()?;
        Ok(Program {
            pipeline,
            resources,
            layouts,
        })
    }

    /// Puts every written resource back to what it starts with, runs the build, and reads what was written; then the
    /// given buffers.
    ///
    /// # Errors
    /// If the device refuses, or is lost.
    pub fn run(
        &self,
        gpu: &Gpu,
        made: &[Made],
        extras: &[Extra],
        immediates: &[u8],
        groups: [u32; 3],
        read: &[&wgpu::Buffer],
    ) -> Result<(Outputs, Vec<Vec<u8>>), RunError> {
        reset(gpu, made);
        let bind_groups = self.bind(gpu, made, extras);
        let mut encoder = gpu.encoder();
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("vrcs check"),
                timestamp_writes: None,
            });
            pass.set_pipeline(&self.pipeline);
            for (index, group) in bind_groups.iter().enumerate() {
                if let Some(group) = group {
                    pass.set_bind_group(index as u32, group, &[]);
                }
            }
            if !immediates.is_empty() {
                pass.set_immediates(0, immediates);
            }
            let [x, y, z] = groups;
            pass.dispatch_workgroups(x, y, z);
        }
        let written: Vec<ReadBack> = made
            .iter()
            .filter(|made| made.written)
            .map(|made| ReadBack::record(gpu, &mut encoder, &made.kind))
            .collect();
        let buffers: Vec<&wgpu::Buffer> = written
            .iter()
            .map(|back| &back.buffer)
            .chain(read.iter().copied())
            .collect();
        let mut bytes = gpu.submit_and_read(encoder, &buffers)?;
        let extra = bytes.split_off(written.len());
        let outputs = written
            .iter()
            .zip(bytes)
            .map(|(back, bytes)| back.without_padding(bytes))
            .collect();
        Ok((outputs, extra))
    }

    fn bind(&self, gpu: &Gpu, made: &[Made], extras: &[Extra]) -> Vec<Option<wgpu::BindGroup>> {
        self.layouts
            .iter()
            .enumerate()
            .map(|(group, layout)| {
                let layout = layout.as_ref()?;
                let entries: Vec<_> = self
                    .resources
                    .iter()
                    .filter(|resource| resource.group as usize == group)
                    .filter_map(|resource| {
                        Some(wgpu::BindGroupEntry {
                            binding: resource.entry.binding,
                            resource: binding(resource, made, extras)?,
                        })
                    })
                    .collect();
                Some(gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("vrcs check"),
                    layout,
                    entries: &entries,
                }))
            })
            .collect()
    }
}

fn binding<'b>(
    resource: &Resource,
    made: &'b [Made],
    extras: &[Extra<'b>],
) -> Option<wgpu::BindingResource<'b>> {
    let at = ResourceBinding {
        group: resource.group,
        binding: resource.entry.binding,
    };
    if let Some((_, buffer)) = extras.iter().find(|(binding, _)| *binding == at) {
        return Some(buffer.as_entire_binding());
    }
    let found = made.iter().find(|made| {
        made.resource.group == at.group && made.resource.entry.binding == at.binding
    })?;
    Some(match &found.kind {
        MadeKind::Buffer { buffer, .. } => buffer.as_entire_binding(),
        MadeKind::Texture { view, .. } => wgpu::BindingResource::TextureView(view),
        MadeKind::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
    })
}

/// The shader with [exact](super::exact) arithmetic; `None` where the device takes no SPIR-V.
fn exact_shader(
    gpu: &Gpu,
    build: &Build,
    resources: &[Resource],
) -> Result<Option<wgpu::ShaderModule>, RunError> {
    if !gpu.takes_spirv() {
        return Ok(None);
    }
    let name = &build.module.entry_points[build.entry].name;
    let bindings = resources
        .iter()
        .map(|resource| (resource.group, resource.entry.binding))
        .collect();
    let spirv = |module: &Module, info: &ModuleInfo| {
        super::exact::spirv(module, info, name, build.constants, &bindings)
    };
    let written = match build.code {
        Code::Module => spirv(build.module, build.info),
        Code::Text(text) => {
            let source = vrcs_passes::Source::new(build.label, text);
            match vrcs_passes::input::wgsl(&source) {
                Ok((module, info)) => spirv(&module, &info),
                Err(invalid) => Err(invalid.rendered),
            }
        }
    };
    let (words, workgroup_size) = written.map_err(GpuError::Refused)?;
    let workgroup_size = (workgroup_size[0], workgroup_size[1], workgroup_size[2]);
    let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
        label: Some(build.label),
        entry_points: std::borrow::Cow::Owned(vec![wgpu::PassthroughShaderEntryPoint {
            name: name.as_str().into(),
            workgroup_size,
        }]),
        spirv: Some(words.into()),
        ..wgpu::ShaderModuleDescriptorPassthrough::default()
    };
    // SAFETY: naga wrote the SPIR-V from a valid module, with its own bounds checks on all buffers, images and indices and
    // its bounds on all loops; the decorations only forbid optimisations.
    Ok(Some(unsafe {
        gpu.device.create_shader_module_passthrough(descriptor)
    }))
}

fn reset(gpu: &Gpu, made: &[Made]) {
    for made in made.iter().filter(|made| made.written) {
        match &made.kind {
            MadeKind::Buffer { buffer, initial } => gpu.write(buffer, initial),
            MadeKind::Texture {
                texture, initial, ..
            } => write_texture(gpu, texture, 0, initial),
            MadeKind::Sampler(_) => {}
        }
    }
}

/// A copy of a resource on its way back.
struct ReadBack {
    buffer: wgpu::Buffer,
    /// Bytes of a row, and bytes from row to row, for a texture.
    rows: Option<(usize, usize)>,
}

impl ReadBack {
    fn record(gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, kind: &MadeKind) -> ReadBack {
        match kind {
            MadeKind::Buffer { buffer, .. } => ReadBack {
                buffer: buffer.clone(),
                rows: None,
            },
            MadeKind::Texture { texture, .. } => {
                let size = texture.size();
                let texel = texture.format().block_copy_size(None).unwrap_or(4);
                let row = size.width * texel;
                let pitch = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
                let bytes = u64::from(pitch)
                    * u64::from(size.height)
                    * u64::from(size.depth_or_array_layers);
                let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("vrcs texture read-back"),
                    size: bytes,
                    usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                });
                encoder.copy_texture_to_buffer(
                    texture.as_image_copy(),
                    wgpu::TexelCopyBufferInfo {
                        buffer: &buffer,
                        layout: wgpu::TexelCopyBufferLayout {
                            offset: 0,
                            bytes_per_row: Some(pitch),
                            rows_per_image: Some(size.height),
                        },
                    },
                    size,
                );
                ReadBack {
                    buffer,
                    rows: Some((row as usize, pitch as usize)),
                }
            }
            MadeKind::Sampler(_) => unreachable!("nobody writes to a sampler"),
        }
    }

    fn without_padding(&self, bytes: Vec<u8>) -> Vec<u8> {
        match self.rows {
            None => bytes,
            Some((row, pitch)) => bytes
                .chunks(pitch)
                .flat_map(|r| r[..row].to_vec())
                .collect(),
        }
    }
}
