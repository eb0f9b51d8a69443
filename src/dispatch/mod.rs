//! The dispatch stage: a rewritten shader as a compute pipeline, recorded into the caller's compute pass.
//!
//! *Needs*: the caller's device, shader and layouts. *Guarantees*: what the shader needs of the device is asked of it up front. *Refuses*:
//! shaders that cannot be rewritten, layouts that do not serve them, views that were built for something else; each with an error, never
//! with a panic.

pub mod bindings;
mod error;
mod pipeline;
mod prewritten;
mod record;
pub mod reflect;

use std::sync::Arc;

use naga::valid::ModuleInfo;
use vrcs_passes::{
    Color, Finding, Options, Refusal, Source, manifest,
    options::{Mode, Place},
};

use crate::home::Home;
pub use error::{Mismatch, PassError};
use pipeline::Made;
pub(crate) use pipeline::group_size;

/// How a [`Pass`] is made.
#[derive(Clone, Debug)]
pub struct PassOptions<'p> {
    /// A name for captures; by default the shader's file and entry point.
    pub label: Option<&'p str>,
    /// The entry point; the only compute entry point if there is just one.
    pub entry: Option<&'p str>,
    /// How the shader is rewritten. By default its mode is [chosen](Mode::Auto) for it: see [`Pass::mode`]. Limits are the
    /// device's, but `max_bind_groups`, which may be lower.
    pub rewrite: Options,
    /// The layouts of the shader's own bind groups, with dynamic offsets where the caller wants them. If there are none, they are read
    /// off the shader, without any; see [`Pass::bind_group_layout`]. A layout of the group in which the added bindings lie has their
    /// [entries](bindings::layout_entries), too.
    pub layouts: &'p [Option<&'p wgpu::BindGroupLayout>],
    /// Values of the shader's `override` constants.
    pub constants: &'p [(&'p str, f64)],
    /// The caller's cache of compiled pipelines.
    pub cache: Option<&'p wgpu::PipelineCache>,
}

impl Default for PassOptions<'_> {
    fn default() -> Self {
        PassOptions {
            label: None,
            entry: None,
            rewrite: Options {
                mode: Mode::Auto,
                ..Options::default()
            },
            layouts: &[],
            constants: &[],
            cache: None,
        }
    }
}

impl<'p> PassOptions<'p> {
    /// The defaults, for a shader whose bind groups have the caller's layouts: `layouts[n]` is that of group n.
    pub fn with_layouts(layouts: &'p [Option<&'p wgpu::BindGroupLayout>]) -> PassOptions<'p> {
        PassOptions {
            layouts,
            ..PassOptions::default()
        }
    }
}

/// A rewritten shader, ready to be dispatched over [views](crate::View).
#[derive(Debug)]
pub struct Pass {
    home: Home,
    label: String,
    pipeline: wgpu::ComputePipeline,
    /// Where the added bindings are.
    added: Place,
    /// Whether their group is the caller's.
    is_shared: bool,
    layouts: Vec<Option<wgpu::BindGroupLayout>>,
    manifest: manifest::Entry,
    original_group_size: [u32; 3],
    warnings: Vec<Finding>,
    /// Bytes.
    immediates: u32,
    module: Arc<naga::Module>,
}

impl Pass {
    /// Rewrites a WGSL shader and makes its pipeline.
    ///
    /// # Errors
    /// See [`PassError`].
    pub fn new(
        device: &wgpu::Device,
        source: &Source,
        options: &PassOptions,
    ) -> Result<Pass, PassError> {
        let (module, info) = vrcs_passes::input::wgsl(source)
            .map_err(|invalid| PassError::Invalid(invalid.rendered))?;
        Pass::from_module(device, &module, &info, source, options)
    }

    /// Rewrites a naga module and makes its pipeline. `source` is the text that the module's spans point into; it
    /// may be empty.
    ///
    /// # Errors
    /// See [`PassError`].
    pub fn from_module(
        device: &wgpu::Device,
        module: &naga::Module,
        info: &ModuleInfo,
        source: &Source,
        options: &PassOptions,
    ) -> Result<Pass, PassError> {
        let _span = tracing::trace_span!("vrcs pass").entered();
        let refused = |refusal: Refusal| PassError::Refused {
            rendered: refusal.render(source, Color::Never),
            refusal,
        };
        let entry = match options.entry {
            Some(name) => vrcs_passes::Entries::Named(name),
            None => vrcs_passes::Entries::PerPixel,
        };
        let limits = device.limits();
        let rewrite_options = Options {
            max_bind_groups: options.rewrite.max_bind_groups.min(limits.max_bind_groups),
            max_bindings_per_group: limits.max_bindings_per_bind_group,
            max_uniform_buffers: limits.max_uniform_buffers_per_shader_stage,
            max_storage_buffers: limits.max_storage_buffers_per_shader_stage,
            ..options.rewrite.clone()
        };
        let rewritten =
            vrcs_passes::rewrite(module, info, entry, &rewrite_options).map_err(refused)?;
        let Some(manifest) = rewritten.manifest.entries.first().cloned() else {
            return Err(PassError::Manifest(
                "the rewriter made no entry point".to_owned(),
            ));
        };
        let is_given = |group: u32| {
            let layout = options.layouts.get(group as usize);
            layout.is_some_and(Option::is_some)
        };
        let added = manifest.bindings.first().map(|params| params.group);
        if let Some(group) = added
            && is_given(group)
            && !manifest.shares_group
            && options.rewrite.place.is_none()
        {
            return Err(PassError::GroupTaken { group });
        }
        let made = Made {
            original_group_size: group_size(module, info, &manifest.name, options.constants)?,
            module: rewritten.module,
            info: &rewritten.info,
            manifest,
            warnings: rewritten.warnings.into_iter().map(|(_, w)| w).collect(),
            source: source.names().next().unwrap_or_default(),
        };
        pipeline::make(device, made, options)
    }

    /// What is known of the rewritten entry point.
    pub fn manifest(&self) -> &manifest::Entry {
        &self.manifest
    }

    /// What the rewriter warns of.
    pub fn warnings(&self) -> &[Finding] {
        &self.warnings
    }

    /// The rewritten module.
    pub fn module(&self) -> &naga::Module {
        &self.module
    }

    /// The workgroup size that the shader was written for.
    pub fn original_group_size(&self) -> [u32; 3] {
        self.original_group_size
    }

    /// The layout of one of the shader's own bind groups; `None` if it uses no such group. That of a
    /// [shared](Pass::shared_group) group has the added bindings, too.
    pub fn bind_group_layout(&self, group: u32) -> Option<&wgpu::BindGroupLayout> {
        match group == self.added.group && !self.is_shared {
            true => None,
            false => self.layouts.get(group as usize)?.as_ref(),
        }
    }

    /// How primaries find their pixels, and why if it was chosen for the shader.
    pub fn mode(&self) -> (Mode, Option<&str>) {
        (self.manifest.mode, self.manifest.mode_reason.as_deref())
    }

    /// The bytes of immediates that the shader reads, which [`dispatch_with`](Pass::dispatch_with) is for; 0 if it has none.
    pub fn immediate_size(&self) -> u32 {
        self.immediates
    }
}
