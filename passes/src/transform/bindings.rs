//! Chooses where the added resources are bound, and counts what the device has to have for them.
//!
//! *Does*: takes the place that the options give; else the lowest bind group that nothing in the module uses; else two free
//! numbers of a group that is in use: of those that the device has, the one of which the entry points use least, and of
//! equals the last, since what changes most often is bound last.
//! *Guarantees*: no binding of the author's is touched, and none of the module, of whichever entry point, has the number of an
//! added one. Where a group is shared its layout grows by two entries, and the manifest says so.
//! *Refuses*: a given place that is taken or that the device does not have; a module without two free numbers; an entry point
//! that leaves no uniform buffer or no storage buffer to the device's limits.

use naga::{
    AddressSpace, GlobalVariable, Handle, Module, ResourceBinding, TypeInner,
    valid::{GlobalUse, ModuleInfo},
};

use crate::{
    finding::{Code, Finding},
    options::{Options, Place},
};

/// Where the added resources are bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placement {
    /// The parameters, a uniform buffer.
    pub params: ResourceBinding,
    /// The coordinate buffer, a read-only storage buffer.
    pub coords: ResourceBinding,
}

impl Placement {
    fn new(Place { group, binding }: Place) -> Placement {
        Placement {
            params: ResourceBinding { group, binding },
            coords: ResourceBinding {
                group,
                binding: binding + 1,
            },
        }
    }
}

/// Chooses a placement that suits all of these entry points.
///
/// # Errors
/// If the place that the options give cannot be had, or there is none.
pub fn place(
    module: &Module,
    info: &ModuleInfo,
    entries: &[usize],
    options: &Options,
) -> Result<Placement, Finding> {
    if let Some(place) = options.place {
        return given(module, place, options);
    }
    let groups = options.max_bind_groups;
    let numbers = |group| {
        let bindings = module
            .global_variables
            .iter()
            .filter_map(|(_, g)| g.binding);
        let mut numbers: Vec<u32> = bindings
            .filter(|at| at.group == group)
            .map(|at| at.binding)
            .collect();
        numbers.sort_unstable();
        numbers
    };
    if let Some(group) = (0..groups).find(|&group| numbers(group).is_empty()) {
        return Ok(Placement::new(Place { group, binding: 0 }));
    }
    let uses = |group| {
        let of_entry = |&entry: &usize| {
            used(module, info, entry)
                .filter(|(_, global)| global.binding.is_some_and(|at| at.group == group))
                .count()
        };
        entries.iter().map(of_entry).sum::<usize>()
    };
    let mut shared: Vec<u32> = (0..groups).rev().collect();
    shared.sort_by_key(|&group| uses(group));
    let free = shared.into_iter().find_map(|group| {
        let binding = two_free(&numbers(group), options.max_bindings_per_group)?;
        Some(Place { group, binding })
    });
    free.map(Placement::new).ok_or_else(|| {
        Finding::new(
            Code::NoFreeBinding,
            format!(
                "none of the {groups} bind groups has two free binding numbers below {} for the parameters and the coordinate buffer",
                options.max_bindings_per_group
            ),
        )
        .help("number the bindings of one group from 0, without gaps; or say where the two go with `--place GROUP:BINDING`")
    })
}

/// Two free numbers in a row: past the highest if the device allows, else in a gap. `numbers` is sorted.
fn two_free(numbers: &[u32], limit: u32) -> Option<u32> {
    let fits = |&binding: &u32| binding.saturating_add(1) < limit;
    let is_free = |binding: &u32| !numbers.contains(binding) && !numbers.contains(&(binding + 1));
    let past = numbers.last().map_or(0, |last| last.saturating_add(1));
    let mut gaps = (0..past).filter(is_free);
    Some(past).filter(fits).or_else(|| gaps.find(fits))
}

/// The place that the options give.
fn given(module: &Module, place: Place, options: &Options) -> Result<Placement, Finding> {
    if place.group >= options.max_bind_groups {
        return Err(Finding::new(
            Code::UnfitOption,
            format!(
                "there is no bind group {} to place the added bindings in: the device is taken to have {}",
                place.group, options.max_bind_groups
            ),
        )
        .help("name a lower group, or more groups with `--max-bind-groups`"));
    }
    if place.binding.saturating_add(1) >= options.max_bindings_per_group {
        return Err(Finding::new(
            Code::UnfitOption,
            format!(
                "the added bindings cannot have the numbers {} and the next: those of a group are below {}",
                place.binding, options.max_bindings_per_group
            ),
        )
        .help("name a lower binding number"));
    }
    let placement = Placement::new(place);
    let added = [
        ("parameters", placement.params),
        ("coordinate buffer", placement.coords),
    ];
    for (what, at) in added {
        let taken = module
            .global_variables
            .iter()
            .find(|(_, global)| global.binding == Some(at));
        let Some((handle, global)) = taken else {
            continue;
        };
        let name = global.name.as_deref().unwrap_or("an unnamed resource");
        return Err(Finding::new(
            Code::PlaceTaken,
            format!(
                "the {what} cannot be binding {} of group {}: that is `{name}`",
                at.binding, at.group
            ),
        )
        .at(
            module.global_variables.get_span(handle),
            format!("`{name}` has this place"),
        )
        .help(format!(
            "the added bindings take two numbers in a row, {} and {}: name others, or leave `--place` out",
            place.binding,
            place.binding + 1
        )));
    }
    Ok(placement)
}

/// The resources that an entry point uses.
fn used<'m>(
    module: &'m Module,
    info: &'m ModuleInfo,
    entry: usize,
) -> impl Iterator<Item = (Handle<GlobalVariable>, &'m GlobalVariable)> {
    let uses = info.get_entry_point(entry);
    module
        .global_variables
        .iter()
        .filter(move |&(handle, _)| uses[handle] != GlobalUse::empty())
}

/// Whether an entry point has bindings of its own in the group of the added ones.
pub fn is_shared(module: &Module, info: &ModuleInfo, entry: usize, placement: Placement) -> bool {
    used(module, info, entry)
        .filter_map(|(_, global)| global.binding)
        .any(|at| at.group == placement.params.group)
}

/// The buffers that an entry point uses of a device: its own, without the added ones. Those in binding arrays have limits of
/// their own.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Buffers {
    /// Uniform buffers.
    pub uniform: Vec<Handle<GlobalVariable>>,
    /// Storage buffers.
    pub storage: Vec<Handle<GlobalVariable>>,
}

/// Counts the buffers of an entry point.
pub fn buffers(module: &Module, info: &ModuleInfo, entry: usize) -> Buffers {
    let mut buffers = Buffers::default();
    for (handle, global) in used(module, info, entry) {
        if matches!(
            module.types[global.ty].inner,
            TypeInner::BindingArray { .. }
        ) {
            continue;
        }
        match global.space {
            AddressSpace::Uniform => buffers.uniform.push(handle),
            AddressSpace::Storage { .. } => buffers.storage.push(handle),
            _ => {}
        }
    }
    buffers
}

/// Whether the device's limits leave room for the added buffers. Where the shader on its own is beyond the limit that is taken for
/// granted, its author has asked the device for more, and is told how many that has to be now.
///
/// # Errors
/// With what is used of which limit.
pub fn check_limits(
    module: &Module,
    info: &ModuleInfo,
    entry: usize,
    options: &Options,
) -> Result<Vec<Finding>, Finding> {
    let usual = Options::default();
    let mut warnings = Vec::new();
    let Buffers { uniform, storage } = buffers(module, info, entry);
    let kinds = [
        (
            uniform,
            (options.max_uniform_buffers, usual.max_uniform_buffers),
            "uniform",
            "the parameters",
            "put two of them into one",
        ),
        (
            storage,
            (options.max_storage_buffers, usual.max_storage_buffers),
            "storage",
            "the coordinate buffer",
            "put two of them into one, or make one that is only read and small a uniform",
        ),
    ];
    for (own, (limit, usual), kind, added, change) in kinds {
        let count = own.len() as u32;
        if count < limit {
            continue;
        }
        let name = &module.entry_points[entry].name;
        if count > limit && limit == usual {
            let last = own[limit as usize];
            warnings.push(
                Finding::new(
                    Code::BeyondUsualLimit,
                    format!("`{name}` uses {count} {kind} buffers, more than WebGPU's {limit} a stage; with {added} the device has to give {}", count + 1),
                )
                .at(module.global_variables.get_span(last), format!("{kind} buffer {}", limit + 1))
                .help(format!("ask for `max_{kind}_buffers_per_shader_stage: {}`; `--max-{kind}-buffers` says what the device has", count + 1)),
            );
            continue;
        }
        let mut finding = Finding::new(
            Code::TooManyBuffers,
            format!(
                "`{name}` uses {count} {kind} buffers; with {added} that makes {}, and the device is taken to have {limit} a stage",
                count + 1
            ),
        );
        for (number, &global) in own.iter().enumerate() {
            let span = module.global_variables.get_span(global);
            finding = finding.at(span, format!("{kind} buffer {}", number + 1));
        }
        return Err(finding.help(format!(
            "if the device has more (`max_{kind}_buffers_per_shader_stage`), say so with `--max-{kind}-buffers {}`; else {change}",
            count + 1
        )));
    }
    Ok(warnings)
}

/// Whether a shader may write a resource.
pub fn is_writable(module: &Module, global: &naga::GlobalVariable) -> bool {
    let ty = match module.types[global.ty].inner {
        naga::TypeInner::BindingArray { base, .. } => base,
        _ => global.ty,
    };
    let access = match (global.space, &module.types[ty].inner) {
        (naga::AddressSpace::Storage { access }, _) => access,
        (
            _,
            naga::TypeInner::Image {
                class: naga::ImageClass::Storage { access, .. },
                ..
            },
        ) => *access,
        _ => return false,
    };
    access.contains(naga::StorageAccess::STORE)
}
