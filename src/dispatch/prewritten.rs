//! Shaders that were rewritten before: by a build script, or by `vrcs rewrite`.

use naga::{Module, ShaderStage, valid::ModuleInfo};
use vrcs_passes::{
    Source, input,
    manifest::{self, Manifest},
};

use super::{
    Pass, PassError, PassOptions,
    pipeline::{self, Made},
};

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
        let unfit = PassError::Manifest;
        let manifest: Manifest =
            serde_json::from_str(manifest).map_err(|error| unfit(error.to_string()))?;
        if manifest.version != manifest::VERSION {
            return Err(unfit(format!(
                "it is of version {}, and this is {}: rewrite the shader again",
                manifest.version,
                manifest::VERSION
            )));
        }
        let entry = match options.entry {
            Some(name) => manifest.entries.into_iter().find(|e| e.name == name),
            None => manifest.entries.into_iter().next(),
        };
        let entry = entry.ok_or_else(|| unfit("it has no such entry point".to_owned()))?;
        let source = Source::new("prewritten.wgsl", text);
        let (module, info) =
            input::wgsl(&source).map_err(|invalid| PassError::Invalid(invalid.rendered))?;
        check(&module, &info, &entry).map_err(unfit)?;
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
        let made = Made {
            module,
            info: &info,
            manifest: entry,
            original_group_size,
            warnings: Vec::new(),
            source: "prewritten",
        };
        pipeline::make(device, made, options)
    }
}

/// Whether a manifest's entry can be that of a text: the two are files of their own, and files get mixed up.
fn check(module: &Module, info: &ModuleInfo, entry: &manifest::Entry) -> Result<(), String> {
    let name = &entry.name;
    let is_it = |e: &naga::EntryPoint| e.name == *name && e.stage == ShaderStage::Compute;
    let Some(index) = module.entry_points.iter().position(is_it) else {
        return Err(format!("the text has no compute entry point `{name}`"));
    };
    let point = &module.entry_points[index];
    if point.workgroup_size_overrides.is_none() && point.workgroup_size != entry.workgroup_size {
        return Err(format!(
            "the text's `{name}` has workgroups of {:?}, the manifest's of {:?}",
            point.workgroup_size, entry.workgroup_size
        ));
    }
    if entry.tile.contains(&0) || entry.dispatch.divide.contains(&0) {
        return Err("a tile or a workgroup of it has no invocations".to_owned());
    }
    let uses = info.get_entry_point(index);
    for added in &entry.bindings {
        let is_there = module.global_variables.iter().any(|(handle, global)| {
            let at = global.binding.as_ref();
            !uses[handle].is_empty()
                && at.is_some_and(|at| (at.group, at.binding) == (added.group, added.binding))
        });
        if !is_there {
            return Err(format!(
                "the text's `{name}` binds nothing at group {}, binding {}, where `{}` should be",
                added.group, added.binding, added.name
            ));
        }
    }
    Ok(())
}
