//! From a rewritten module to a pipeline, whether it was rewritten just now or before.
//!
//! *Needs*: the module, its manifest entry and the caller's layouts, if there are any. *Refuses*: layouts that do not serve the shader, and
//! devices that have too little, before wgpu does: see [`PassError`].

use std::{collections::HashMap, sync::Arc};

use naga::{Module, ShaderStage, back::pipeline_constants::process_overrides, valid::ModuleInfo};
use vrcs_passes::{
    Finding, manifest,
    options::{Mode, Place},
};

use super::{
    Pass, PassError, PassOptions,
    reflect::{self, Resource},
};
use crate::{home::Home, limits::Needs, scope, view::View};

/// A rewritten module, and what is known of it.
pub(super) struct Made<'m> {
    pub(super) module: Module,
    pub(super) info: &'m ModuleInfo,
    pub(super) manifest: manifest::Entry,
    pub(super) original_group_size: [u32; 3],
    pub(super) warnings: Vec<Finding>,
    /// The shader's file, for its label.
    pub(super) source: &'m str,
}

/// The pipeline's layout.
struct Layout {
    groups: Vec<Option<wgpu::BindGroupLayout>>,
    /// Whether the group of the added bindings is the caller's.
    is_shared: bool,
}

/// Makes the pipeline.
pub(super) fn make(
    device: &wgpu::Device,
    made: Made,
    options: &PassOptions,
) -> Result<Pass, PassError> {
    let name = made.manifest.name.clone();
    check_tile(&made.manifest, made.original_group_size)?;
    let added = place_of(&made.manifest)?;
    let index = entry_index(&made.module, &name)?;
    let needs = Needs::of_entry(&made.module, made.info, index, workgroup_of(&made));
    needs.check(device, &format!("the entry point `{name}`"))?;
    let resources = reflect::resources(&made.module, made.info, index)?;
    let layout = layout(device, &resources, &made.manifest, added, options)?;
    let label = match options.label {
        Some(label) => label.to_owned(),
        None => format!("{} {name}", made.source),
    };
    let pipeline = scope::caught(device, || {
        let groups: Vec<_> = layout.groups.iter().map(Option::as_ref).collect();
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(&label),
            bind_group_layouts: &groups,
            immediate_size: needs.immediates.next_multiple_of(4),
        });
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(&label),
            source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(made.module.clone())),
        });
        device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(&label),
            layout: Some(&pipeline_layout),
            module: &shader,
            entry_point: Some(&name),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: options.constants,
                ..wgpu::PipelineCompilationOptions::default()
            },
            cache: options.cache,
        })
    })
    .map_err(|error| in_terms_of_layouts(&error, &resources))?;
    Ok(Pass {
        home: Home::of(device),
        label,
        pipeline,
        added,
        is_shared: layout.is_shared,
        layouts: layout.groups,
        manifest: made.manifest,
        original_group_size: made.original_group_size,
        warnings: made.warnings,
        immediates: needs.immediates,
        module: Arc::new(made.module),
    })
}

/// The rewritten entry point's workgroup, overrides resolved.
fn workgroup_of(made: &Made) -> [u32; 3] {
    match made.manifest.group.is_some() || made.manifest.mode == Mode::Graded {
        true => made.original_group_size,
        false => made.manifest.workgroup_size,
    }
}

/// What wgpu has against a pipeline.
fn in_terms_of_layouts(error: &wgpu::Error, resources: &[Resource]) -> PassError {
    let Some((at, why)) = scope::unserved_binding(error) else {
        return PassError::Pipeline(scope::in_words(error));
    };
    let is_it =
        |resource: &&Resource| (resource.group, resource.entry.binding) == (at.group, at.binding);
    let resource = resources.iter().find(is_it);
    PassError::Layout {
        group: at.group,
        binding: at.binding,
        name: resource.map_or_else(String::new, |resource| resource.name.clone()),
        wanted: resource.map_or_else(String::new, |resource| format!("{:?}", resource.entry.ty)),
        why,
    }
}

fn entry_index(module: &Module, name: &str) -> Result<usize, PassError> {
    let mut entries = module.entry_points.iter();
    entries
        .position(|entry| entry.name == name && entry.stage == ShaderStage::Compute)
        .ok_or_else(|| {
            PassError::Manifest(format!("the shader has no compute entry point `{name}`"))
        })
}

/// Refuses a workgroup that has to be a tile, and is larger than tiles can be.
fn check_tile(manifest: &manifest::Entry, size: [u32; 3]) -> Result<(), PassError> {
    const MOST: u32 = 256;
    let area = size
        .iter()
        .fold(1, |area: u32, side| area.saturating_mul(*side));
    match manifest.group.is_some() && area > MOST {
        true => Err(PassError::GroupTooLarge {
            size,
            area,
            most: MOST,
        }),
        false => Ok(()),
    }
}

/// The workgroup size of an entry point, its overrides resolved.
pub(crate) fn group_size(
    module: &Module,
    info: &ModuleInfo,
    entry: &str,
    constants: &[(&str, f64)],
) -> Result<[u32; 3], PassError> {
    let constants: HashMap<String, f64> = constants
        .iter()
        .map(|&(name, value)| (name.to_owned(), value))
        .collect();
    let constants = constants.into_iter().collect();
    let (resolved, _) = process_overrides(
        module,
        info,
        Some((ShaderStage::Compute, entry)),
        &constants,
    )
    .map_err(|error| PassError::Constants(error.to_string()))?;
    let index = entry_index(&resolved, entry)?;
    Ok(resolved.entry_points[index].workgroup_size)
}

/// Where the added bindings are.
fn place_of(manifest: &manifest::Entry) -> Result<Place, PassError> {
    let unfit = |why: &str| PassError::Manifest(why.to_owned());
    let [params, coords] = manifest.bindings.as_slice() else {
        return Err(unfit("it does not name the two added bindings"));
    };
    let is_pair = params.group == coords.group
        && params.binding.checked_add(1) == Some(coords.binding)
        && (params.name.as_str(), coords.name.as_str()) == ("params", "coords");
    match is_pair {
        true => Ok(Place {
            group: params.group,
            binding: params.binding,
        }),
        false => Err(unfit("the added bindings are not two in a row")),
    }
}

/// The layouts of all groups: the caller's or those that the shader asks for, and that of the added bindings.
fn layout(
    device: &wgpu::Device,
    resources: &[Resource],
    manifest: &manifest::Entry,
    added: Place,
    options: &PassOptions,
) -> Result<Layout, PassError> {
    let Place { group, binding } = added;
    let mut groups = match options.layouts {
        [] => reflect::group_layouts(device, resources, &manifest.name),
        given => {
            check_groups(resources, given, added)?;
            given.iter().map(|layout| layout.cloned()).collect()
        }
    };
    while groups.len() <= group as usize {
        groups.push(None);
    }
    let is_given = !options.layouts.is_empty() && groups[group as usize].is_some();
    let is_shared = manifest.shares_group || is_given;
    match (is_shared, groups[group as usize].is_some()) {
        (true, false) => {
            return Err(PassError::GroupMissing {
                group,
                first: binding,
            });
        }
        (true, true) => {}
        (false, _) => groups[group as usize] = Some(View::bind_group_layout(device, binding)),
    }
    Ok(Layout { groups, is_shared })
}

/// Refuses layouts that leave out a group in which the shader binds something.
fn check_groups(
    resources: &[Resource],
    given: &[Option<&wgpu::BindGroupLayout>],
    added: Place,
) -> Result<(), PassError> {
    let is_given = |group: u32| given.get(group as usize).is_some_and(Option::is_some);
    let missing = resources
        .iter()
        .find(|resource| resource.group != added.group && !is_given(resource.group));
    match missing {
        None => Ok(()),
        Some(resource) => Err(PassError::Layout {
            group: resource.group,
            binding: resource.entry.binding,
            name: resource.name.clone(),
            wanted: format!("{:?}", resource.entry.ty),
            why: "no layout is given for the group".to_owned(),
        }),
    }
}
