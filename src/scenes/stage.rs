//! A scene on a device: its G-buffer, its passes at full rate and as the rewriter makes them.
//!
//! *Does*: makes textures and pipelines once; records the passes of a frame into the caller's encoder.
//! *Guarantees*: a pass at full rate and the same pass at variable rate read and write the same textures; a texture that none of
//! the scene's own passes binds is not there.

use std::collections::{HashMap, HashSet};

use rayon::prelude::*;
use vrcs_passes::{Options, input};

use super::{PassName, SceneName, frame::Frame};
use crate::{
    check::gpu::{Gpu, by_construction},
    dispatch::{Pass, PassOptions, reflect},
    flat,
    view::View,
};

/// Why a scene could not be staged.
#[derive(Debug, thiserror::Error)]
#[error("the scene {scene}: {why}")]
pub struct StageError {
    /// The scene.
    pub scene: SceneName,
    /// What went wrong.
    pub why: String,
}

/// A pass at full rate.
#[derive(Debug)]
struct FullRate {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

/// A scene's passes as the rewriter makes them with certain options.
#[derive(Debug)]
pub struct Rewritten {
    passes: Vec<(PassName, Pass)>,
}

impl Rewritten {
    /// The passes, in order.
    pub fn passes(&self) -> impl Iterator<Item = (PassName, &Pass)> {
        self.passes.iter().map(|(name, pass)| (*name, pass))
    }
}

/// A scene's G-buffer and passes.
#[derive(Debug)]
pub struct Stage {
    scene: SceneName,
    size: [u32; 2],
    frame: wgpu::Buffer,
    textures: HashMap<&'static str, wgpu::Texture>,
    gbuffer: Vec<FullRate>,
    camera_motion: Option<FullRate>,
    transparents: Option<FullRate>,
    passes: Vec<(PassName, FullRate)>,
    rewritten: Rewritten,
}

/// The textures that there can be: name and format.
const TEXTURES: [(&str, wgpu::TextureFormat); 13] = [
    ("ids", wgpu::TextureFormat::R32Uint),
    ("depth", wgpu::TextureFormat::R32Float),
    ("normals", wgpu::TextureFormat::Rgba16Float),
    ("surfaces", wgpu::TextureFormat::R32Uint),
    ("materials", wgpu::TextureFormat::Rgba8Unorm),
    ("motion", wgpu::TextureFormat::Rg32Float),
    ("noise", wgpu::TextureFormat::R32Float),
    ("albedo", wgpu::TextureFormat::Rgba8Unorm),
    ("surface", wgpu::TextureFormat::Rgba8Unorm),
    ("light", wgpu::TextureFormat::Rgba16Float),
    ("traced", wgpu::TextureFormat::Rgba16Float),
    ("picture", wgpu::TextureFormat::Rgba8Unorm),
    ("shown", wgpu::TextureFormat::Rgba8Unorm),
];

/// The texture behind a variable of the shaders.
fn texture_of(variable: &str) -> &str {
    match variable {
        "normal_out" => "normals",
        "opaque" => "picture",
        other => other.trim_end_matches("_out"),
    }
}

impl Stage {
    /// Makes a scene's textures and pipelines.
    ///
    /// # Errors
    /// If the device lacks what the scene needs.
    pub fn new(
        gpu: &Gpu,
        scene: SceneName,
        size: [u32; 2],
        options: &Options,
    ) -> Result<Stage, StageError> {
        let failed = |why: &dyn std::fmt::Display| StageError {
            scene,
            why: why.to_string(),
        };
        let source = scene.source();
        let (module, info) = input::wgsl(&source).map_err(|error| failed(&error))?;
        let frame = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<Frame>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let bound = bound(scene, &module, &info).map_err(|why| failed(&why))?;
        let textures = TEXTURES
            .into_iter()
            .filter(|(name, _)| bound.contains(*name))
            .map(|(name, format)| (name, texture(&gpu.device, name, format, size)))
            .collect();
        let shader = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(scene.name()),
                source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module.clone())),
            });
        let maker = Maker {
            gpu,
            module: &module,
            info: &info,
            shader: &shader,
            frame: &frame,
            textures: &textures,
        };
        let full_rate = |entry: &str| maker.full_rate(entry).map_err(|e| failed(&e));
        let gbuffer: Result<Vec<FullRate>, StageError> =
            scene.gbuffer().into_par_iter().map(full_rate).collect();
        let passes: Result<Vec<(PassName, FullRate)>, StageError> = scene
            .passes()
            .par_iter()
            .map(|&name| Ok((name, full_rate(name.entry())?)))
            .collect();
        let camera_motion = match scene.declared().camera_motion {
            true => Some(full_rate("camera_motion")?),
            false => None,
        };
        let transparents = match scene.declared().transparents {
            true => Some(full_rate("transparents")?),
            false => None,
        };
        Ok(Stage {
            scene,
            size,
            gbuffer: gbuffer?,
            camera_motion,
            transparents,
            passes: passes?,
            rewritten: rewrite(gpu, scene, options)?,
            frame,
            textures,
        })
    }

    /// The scene.
    pub fn scene(&self) -> SceneName {
        self.scene
    }

    /// Width and height of the picture.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The names of its textures, in no order.
    pub fn textures(&self) -> impl Iterator<Item = &'static str> {
        self.textures.keys().copied()
    }

    /// One of the textures: `ids`, `depth`, `normals`, `albedo`, `surface`, `light` and `picture`; and, as the scene declares them,
    /// `surfaces`, `materials`, `motion`, `noise`, `traced` and `shown`.
    pub fn texture(&self, name: &str) -> Option<&wgpu::Texture> {
        self.textures.get(name)
    }

    /// What is shown in the end, `rgba8unorm`: the finished picture and, in a scene that declares them, transparents over it.
    pub fn shown(&self) -> &wgpu::Texture {
        self.texture("shown").unwrap_or_else(|| self.picture())
    }

    /// The finished picture, `rgba8unorm`.
    pub fn picture(&self) -> &wgpu::Texture {
        &self.textures["picture"]
    }

    /// The passes that are made variable-rate, in order.
    pub fn passes(&self) -> impl Iterator<Item = (PassName, &Pass)> {
        self.rewritten.passes()
    }

    /// Sets the frame for what is submitted from now on.
    pub fn set_frame(&self, queue: &wgpu::Queue, frame: &Frame) {
        queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(frame));
    }

    /// Records the G-buffer, all parts that the scene declares.
    pub fn record_geometry(&self, pass: &mut wgpu::ComputePass) {
        for part in &self.gbuffer {
            self.record(pass, part);
        }
    }

    /// Records what makes motion vectors of depth and the camera's matrices, in a scene that declares those alone.
    pub fn record_camera_motion(&self, pass: &mut wgpu::ComputePass) {
        if let Some(camera_motion) = &self.camera_motion {
            self.record(pass, camera_motion);
        }
    }

    /// Records what lays transparents over the finished picture, in a scene that declares them: always at full rate.
    pub fn record_transparents(&self, pass: &mut wgpu::ComputePass) {
        if let Some(transparents) = &self.transparents {
            self.record(pass, transparents);
        }
    }

    /// Records a pass at full rate, as its author wrote it.
    pub fn record_full_rate(&self, pass: &mut wgpu::ComputePass, name: PassName) {
        if let Some((_, full_rate)) = self.passes.iter().find(|(known, _)| *known == name) {
            self.record(pass, full_rate);
        }
    }

    /// Records a pass at a view's rates.
    pub fn record_variable(&self, pass: &mut wgpu::ComputePass, name: PassName, view: &View) {
        self.record_rewritten(pass, name, &self.rewritten, view);
    }

    /// Records a pass of other [options](rewrite) at a view's rates.
    pub fn record_rewritten(
        &self,
        pass: &mut wgpu::ComputePass,
        name: PassName,
        rewritten: &Rewritten,
        view: &View,
    ) {
        let full_rate = self.passes.iter().find(|(known, _)| *known == name);
        let variable = rewritten.passes().find(|(known, _)| *known == name);
        if let (Some((_, full_rate)), Some((_, variable))) = (full_rate, variable) {
            pass.set_bind_group(0, &full_rate.group, &[]);
            by_construction(variable.dispatch(pass, view));
        }
    }

    fn record(&self, pass: &mut wgpu::ComputePass, what: &FullRate) {
        let [width, height] = self.size;
        pass.set_pipeline(&what.pipeline);
        pass.set_bind_group(0, &what.group, &[]);
        pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
    }
}

/// Has a scene's passes rewritten. What becomes of sky is [each pass's own](PassName::sky) choice, not that of the options.
///
/// # Errors
/// If a pass is refused, or the device lacks what it needs.
pub fn rewrite(gpu: &Gpu, scene: SceneName, options: &Options) -> Result<Rewritten, StageError> {
    let failed = |why: &dyn std::fmt::Display| StageError {
        scene,
        why: why.to_string(),
    };
    let source = scene.source();
    let (module, info) = input::wgsl(&source).map_err(|error| failed(&error))?;
    // drivers compile each on a processor of its own
    let make = |&name: &PassName| {
        let pass_options = PassOptions {
            label: Some(name.entry()),
            entry: Some(name.entry()),
            rewrite: Options {
                sky: name.sky(),
                ..options.clone()
            },
            ..PassOptions::default()
        };
        let pass = Pass::from_module(&gpu.device, &module, &info, &source, &pass_options)
            .map_err(|e| failed(&e))?;
        Ok((name, pass))
    };
    let passes: Result<Vec<(PassName, Pass)>, StageError> =
        scene.passes().par_iter().map(make).collect();
    gpu.check().map_err(|e| failed(&e))?;
    Ok(Rewritten { passes: passes? })
}

/// What an entry point binds.
fn resources_of(
    module: &naga::Module,
    info: &naga::valid::ModuleInfo,
    entry: &str,
) -> Result<Vec<reflect::Resource>, String> {
    let index = module.entry_points.iter().position(|e| e.name == entry);
    let index = index.ok_or_else(|| format!("it has no pass `{entry}`"))?;
    reflect::resources(module, info, index).map_err(|error| error.to_string())
}

/// The names of the textures that a scene's passes bind.
fn bound(
    scene: SceneName,
    module: &naga::Module,
    info: &naga::valid::ModuleInfo,
) -> Result<HashSet<String>, String> {
    let declared = scene.declared();
    let more = [
        declared.camera_motion.then_some("camera_motion"),
        declared.transparents.then_some("transparents"),
    ];
    let own = scene.passes().iter().map(|pass| pass.entry());
    let mut names = HashSet::new();
    for entry in scene
        .gbuffer()
        .into_iter()
        .chain(own)
        .chain(more.into_iter().flatten())
    {
        let resources = resources_of(module, info, entry)?;
        names.extend(resources.iter().map(|r| texture_of(&r.name).to_owned()));
    }
    Ok(names)
}

fn texture(
    device: &wgpu::Device,
    name: &str,
    format: wgpu::TextureFormat,
    size: [u32; 2],
) -> wgpu::Texture {
    let usage = wgpu::TextureUsages::STORAGE_BINDING
        | wgpu::TextureUsages::TEXTURE_BINDING
        | wgpu::TextureUsages::COPY_SRC
        | wgpu::TextureUsages::COPY_DST;
    device.create_texture(&flat::texture(name, size, format, usage))
}

/// Makes full-rate passes.
struct Maker<'m> {
    gpu: &'m Gpu,
    module: &'m naga::Module,
    info: &'m naga::valid::ModuleInfo,
    shader: &'m wgpu::ShaderModule,
    frame: &'m wgpu::Buffer,
    textures: &'m HashMap<&'static str, wgpu::Texture>,
}

impl Maker<'_> {
    fn full_rate(&self, entry: &str) -> Result<FullRate, String> {
        let device = &self.gpu.device;
        let resources = resources_of(self.module, self.info, entry)?;
        let layouts = reflect::group_layouts(device, &resources, entry);
        let Some(Some(layout)) = layouts.first() else {
            return Err(format!("`{entry}` binds nothing"));
        };
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(entry),
            bind_group_layouts: &[Some(layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&pipeline_layout),
            module: self.shader,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let mut views = HashMap::new();
        for resource in &resources {
            if let Some(texture) = self.textures.get(texture_of(&resource.name)) {
                let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
                views.insert(resource.entry.binding, view);
            }
        }
        let entries: Vec<_> = resources
            .iter()
            .map(|resource| wgpu::BindGroupEntry {
                binding: resource.entry.binding,
                resource: match views.get(&resource.entry.binding) {
                    Some(view) => wgpu::BindingResource::TextureView(view),
                    None => self.frame.as_entire_binding(),
                },
            })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(entry),
            layout,
            entries: &entries,
        });
        Ok(FullRate { pipeline, group })
    }
}
