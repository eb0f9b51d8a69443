//! Shaders that were rewritten before: by a build script, or by `vrcs rewrite`.

use std::sync::Arc;

use vrcs_passes::{Source, input, manifest::Manifest};

use super::{Pass, PassError, PassOptions, entry_index, pipeline_layout, place_of, reflect};

impl Pass {
    /// Makes the pipeline of a shader that has been rewritten: its WGSL text, and its manifest as JSON.
    ///
    /// [`PassOptions::rewrite`] has no say: the manifest tells how it was rewritten.
    ///
    /// # Errors
    /// See [`PassError`]; [`PassError::Manifest`] if text and manifest do not fit.
    pub fn prewritten(
        device: &wgpu::Device,
        text: &str,
        manifest: &str,
        options: &PassOptions,
    ) -> Result<Pass, PassError> {
        let unfit = |why: String| PassError::Manifest(why);
        let manifest: Manifest =
            serde_json::from_str(manifest).map_err(|error| unfit(error.to_string()))?;
        let entry = match options.entry {
            Some(name) => manifest.entries.into_iter().find(|e| e.name == name),
            None => manifest.entries.into_iter().next(),
        };
        let entry = entry.ok_or_else(|| unfit("it has no such entry point".to_owned()))?;
        let source = Source::new("prewritten.wgsl", text);
        let (module, info) =
            input::wgsl(&source).map_err(|invalid| PassError::Invalid(invalid.rendered))?;
        let is_there = module.entry_points.iter().any(|e| e.name == entry.name);
        if !is_there {
            return Err(unfit(format!(
                "the text has no entry point `{}`",
                entry.name
            )));
        }
        let index = entry_index(&module, &entry.name);
        let mut original_group_size = [0; 3];
        for (size, written) in original_group_size
            .iter_mut()
            .zip(entry.original_workgroup_size)
        {
            *size = written.ok_or_else(|| {
                unfit(
                    "an override decides the original workgroup size: rewrite at run time"
                        .to_owned(),
                )
            })?;
        }
        super::check_tile(&entry, original_group_size)?;
        let added = place_of(&entry)?;
        let layouts = match options.layouts {
            [] => {
                let resources = reflect::resources(&module, &info, index)?;
                reflect::group_layouts(device, &resources, &entry.name)
            }
            given => given.iter().map(|layout| layout.cloned()).collect(),
        };
        let (layout, is_shared) =
            pipeline_layout(device, &layouts, added, entry.shares_group, options)?;
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: options.label,
            source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module.clone())),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: options.label,
            layout: Some(&layout),
            module: &shader,
            entry_point: Some(&entry.name),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: options.constants,
                ..wgpu::PipelineCompilationOptions::default()
            },
            cache: None,
        });
        Ok(Pass {
            pipeline,
            added,
            is_shared,
            layouts,
            original_group_size,
            warnings: Vec::new(),
            module: Arc::new(module),
            manifest: entry,
        })
    }
}
