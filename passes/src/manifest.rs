//! What whoever dispatches a rewritten shader has to know, as data.
//!
//! The manifest is JSON with a version of its own; fields are only ever added within a version.

use naga::{
    Module, ResourceBinding,
    valid::{GlobalUse, ModuleInfo},
};
use serde::{Deserialize, Serialize};

use crate::{
    finding::Finding,
    graded,
    options::{Atomics, FullTiles, Linear, MaxRate, Mode, Options, Policy, Sky},
    plan::{TargetPlan, regions::report::Group},
    source::Source,
    transform::bindings::{self, Placement},
};

/// The version of the manifest's form, and of that of the lists that a rewritten shader reads: 2 since an entry tells its duplicates as the
/// primary sees them, and workgroups stand in rows of 32; 3 since classified lists tell where the segments of their rates end.
pub const VERSION: u32 = 3;

/// What is known of a rewritten module.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`VERSION`].
    pub version: u32,
    /// The program that wrote it.
    pub generator: String,
    /// What the rewrite takes for granted.
    pub preconditions: Vec<String>,
    /// The rewritten entry points, in the module's order.
    pub entries: Vec<Entry>,
    /// What the shader was written as, if it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<Output>,
}

/// What a module was written as, and where its bindings are in that language's terms.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Output {
    /// `wgsl`, `spirv`, `hlsl`, `msl` or `glsl`.
    pub language: String,
    /// Its version: `1.3`, `6.0`, `2.4`, `450`; empty for WGSL.
    pub version: String,
    /// The entry points that are in it, whether rewritten or not. For WGSL none: there, nothing moves.
    pub entries: Vec<OutputEntry>,
}

impl Output {
    /// WGSL text: groups and bindings are the module's.
    pub(crate) fn wgsl() -> Output {
        Output {
            language: "wgsl".to_owned(),
            ..Output::default()
        }
    }
}

/// An entry point of a written module.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutputEntry {
    /// Its name in the module.
    pub name: String,
    /// Its name in the text.
    pub written: String,
    /// Its bindings.
    pub bindings: Vec<OutputBinding>,
    /// What the back end adds, and where it is.
    #[serde(default, skip_serializing_if = "std::collections::BTreeMap::is_empty")]
    pub extra: std::collections::BTreeMap<String, String>,
}

/// Where a binding is in a language's terms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutputBinding {
    /// The variable's name in the module.
    pub name: String,
    /// Its group in the module; `null` for immediates.
    pub group: Option<u32>,
    /// Its number in the group.
    pub binding: Option<u32>,
    /// What it is: `uniform`, `storage`, `read-only-storage`, `texture`, `storage-texture`, `sampler`, `immediate`.
    pub class: String,
    /// What it is numbered among: `binding` or `push-constant` in SPIR-V, `b`, `t`, `u` or `sampler-index` in HLSL,
    /// `buffer`, `texture` or `sampler` in MSL, `uniform`, `buffer`, `image` or `texture` in GLSL.
    pub register: String,
    /// Its number there.
    pub index: u32,
    /// The descriptor set in SPIR-V, the register space in HLSL.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub space: Option<u32>,
}

impl Manifest {
    /// The manifest as JSON, with a line break at its end.
    pub fn to_json(&self) -> String {
        match serde_json::to_string_pretty(self) {
            Ok(json) => json + "\n",
            Err(error) => unreachable!("a manifest is plain data: {error}"),
        }
    }

    pub(crate) fn new() -> Manifest {
        Manifest {
            version: VERSION,
            generator: concat!("vrcs ", env!("CARGO_PKG_VERSION")).to_owned(),
            preconditions: preconditions(),
            entries: Vec::new(),
            output: None,
        }
    }
}

/// A rewritten entry point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Its name, as before.
    pub name: String,
    /// How primaries find their pixels.
    pub mode: Mode,
    /// Why, if it was chosen for the shader.
    #[serde(default)]
    pub mode_reason: Option<String>,
    /// Its new workgroup size.
    pub workgroup_size: [u32; 3],
    /// The workgroup size that the shader was written for; `null` on an axis where an `override` decides.
    pub original_workgroup_size: [Option<u32>; 3],
    /// The tile of the coordinate buffer, in pixels.
    pub tile: [u32; 2],
    /// The largest rate whose copies it makes.
    pub max_rate: MaxRate,
    /// How many invocations retire together, for the nearly-full rule.
    pub wave: u32,
    /// The nearly-full rule.
    pub full_tiles: FullTiles,
    /// What becomes of sky.
    #[serde(default)]
    pub sky: Sky,
    /// The number of workgroups to dispatch, on each axis, for a logical extent.
    pub dispatch: Dispatch,
    /// Where the width comes from, if the original's dispatch has one dimension over the pixels' numbers; the logical extent is
    /// the picture's, no wider than this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub linear: Option<Linear>,
    /// What becomes of its atomics.
    #[serde(default)]
    pub atomics: Atomics,
    /// The added bindings.
    pub bindings: Vec<Binding>,
    /// Whether the entry point has bindings of its own in the group of the added ones. Then one bind group holds both.
    #[serde(default)]
    pub shares_group: bool,
    /// What it needs of a device, the added buffers included.
    #[serde(default)]
    pub needs: Needs,
    /// Whether it asks `vrcs_user()`: what its view builds has to have the user's own bits of each tile.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub user: bool,
    /// Whether it reads entries that carry linear depth: what its view builds has to carry it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub linear_depth: bool,
    /// The resources that it stores to.
    pub targets: Vec<Target>,
    /// For a shader whose invocations work together: how it was taken apart. Then the tile is the workgroup, its overrides
    /// resolved, and `tile`, `workgroup_size` and `dispatch` tell what it is if no override is set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<Group>,
    /// Findings that did not stop the rewrite.
    pub warnings: Vec<Warning>,
}

impl Entry {
    /// Makes the tile the workgroup.
    pub(crate) fn set_group(&mut self, group: Group, size: [u32; 3]) {
        self.group = Some(group);
        self.workgroup_size = size;
        self.tile = [size[0], size[1]];
        self.dispatch.divide = size;
    }

    /// The tile of the coordinate buffer, for the workgroup size that the original has with its overrides.
    pub fn tile_for(&self, original_workgroup_size: [u32; 3]) -> [u32; 2] {
        match self.group {
            Some(_) => [original_workgroup_size[0], original_workgroup_size[1]],
            None => self.tile,
        }
    }

    /// The number of workgroups to dispatch for a logical extent, for the workgroup size that the original has with its
    /// overrides.
    pub fn groups_for(&self, extent: [u32; 3], original_workgroup_size: [u32; 3]) -> [u32; 3] {
        match self.group.is_some() || self.mode == Mode::Graded {
            true => std::array::from_fn(|axis| {
                extent[axis].div_ceil(original_workgroup_size[axis].max(1))
            }),
            false => self.dispatch.groups(extent),
        }
    }
}

/// What a rewritten entry point needs of a device's limits, by wgpu's names for them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Needs {
    /// Bind groups, up to the highest that is used.
    pub max_bind_groups: u32,
    /// Uniform buffers.
    pub max_uniform_buffers_per_shader_stage: u32,
    /// Storage buffers.
    pub max_storage_buffers_per_shader_stage: u32,
}

impl Needs {
    fn new(module: &Module, info: &ModuleInfo, index: usize, placement: Placement) -> Needs {
        let uses = info.get_entry_point(index);
        let groups = module
            .global_variables
            .iter()
            .filter(|&(handle, _)| !uses[handle].is_empty())
            .filter_map(|(_, global)| Some(global.binding?.group))
            .chain([placement.params.group]);
        let own = bindings::buffers(module, info, index);
        Needs {
            max_bind_groups: groups.max().map_or(0, |highest| highest.saturating_add(1)),
            max_uniform_buffers_per_shader_stage: own.uniform.len() as u32 + 1,
            max_storage_buffers_per_shader_stage: own.storage.len() as u32 + 1,
        }
    }
}

/// The rule for the number of workgroups.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dispatch {
    /// On each axis, the extent is divided by this, rounded up. Where the dispatch is indirect, this is the dispatch with
    /// shading rates switched off.
    pub divide: [u32; 3],
    /// Whether the number of workgroups stands in a buffer that the build writes.
    #[serde(default)]
    pub indirect: bool,
}

impl Dispatch {
    /// The number of workgroups for a logical extent, in invocations.
    pub fn groups(&self, extent: [u32; 3]) -> [u32; 3] {
        std::array::from_fn(|axis| extent[axis].div_ceil(self.divide[axis]))
    }
}

/// An added binding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Binding {
    /// What it is for: `params` or `coords`.
    pub name: String,
    /// Its bind group.
    pub group: u32,
    /// Its number in the group.
    pub binding: u32,
    /// What it is: `uniform` or `read-only-storage`.
    pub kind: String,
    /// Its least size, in bytes.
    pub size: u32,
    /// What the bytes mean.
    pub layout: Vec<Field>,
}

/// A field of a binding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its offset, in bytes.
    pub offset: u32,
    /// Its WGSL type.
    #[serde(rename = "type")]
    pub ty: String,
}

/// A resource that the shader stores to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Its name.
    pub name: String,
    /// Its bind group.
    pub group: u32,
    /// Its number in the group.
    pub binding: u32,
    /// What becomes of its stores.
    pub policy: Policy,
    /// Whether the shader reads it, too.
    pub read: bool,
}

/// A finding that did not stop the rewrite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Warning {
    /// Its stable code.
    pub code: String,
    /// One sentence.
    pub message: String,
    /// The file and line, if known.
    pub place: Option<String>,
}

impl Warning {
    /// A finding as a warning.
    pub fn new(finding: &Finding, source: Option<&Source>) -> Warning {
        let place = finding
            .labels
            .first()
            .and_then(|label| source?.place(label.span))
            .map(|place| format!("{}:{}:{}", place.file, place.line, place.column));
        Warning {
            code: finding.code.to_string(),
            message: finding.message.clone(),
            place,
        }
    }
}

/// What holds for every rewrite.
pub fn preconditions() -> Vec<String> {
    vec![
        "distinct writable bindings name disjoint memory".to_owned(),
        "the dispatch covers the logical extent from its origin".to_owned(),
    ]
}

/// The added bindings, for a placement.
pub fn added(placement: Placement) -> Vec<Binding> {
    let field = |name: &str, offset, ty: &str| Field {
        name: name.to_owned(),
        offset,
        ty: ty.to_owned(),
    };
    let binding = |name: &str, at: ResourceBinding, kind: &str, size, layout| Binding {
        name: name.to_owned(),
        group: at.group,
        binding: at.binding,
        kind: kind.to_owned(),
        size,
        layout,
    };
    vec![
        binding(
            "params",
            placement.params,
            "uniform",
            PARAMS_SIZE,
            vec![
                field("extent", 0, "vec3<u32>"),
                field("flags", 12, "u32"),
                field("groups", 16, "vec3<u32>"),
                field("tiles_per_row", 28, "u32"),
                field("entries", 32, "u32"),
                field("entries_per_tile", 36, "u32"),
                field("capacity", 40, "u32"),
                field("stride", 44, "u32"),
            ],
        ),
        binding(
            "coords",
            placement.coords,
            "read-only-storage",
            4,
            vec![field("words", 0, "array<u32>")],
        ),
    ]
}

/// The size of the parameters, in bytes.
pub const PARAMS_SIZE: u32 = 48;

/// The workgroup size of a rewritten entry point. A list has no rows.
pub fn workgroup_size(options: &Options) -> [u32; 3] {
    let [width, height] = options.tile;
    match options.mode {
        Mode::Tiled | Mode::Graded | Mode::Auto => [width, height, 1],
        Mode::List | Mode::Classified => [width * height, 1, 1],
    }
}

/// An entry of the manifest.
pub fn entry(
    module: &Module,
    info: &ModuleInfo,
    index: usize,
    options: &Options,
    placement: Placement,
    targets: &[TargetPlan],
) -> Entry {
    let entry = &module.entry_points[index];
    let overrides = entry.workgroup_size_overrides.unwrap_or_default();
    let [width, height] = options.tile;
    let uses = info.get_entry_point(index);
    Entry {
        name: entry.name.clone(),
        mode: options.mode,
        mode_reason: None,
        workgroup_size: workgroup_size(options),
        original_workgroup_size: std::array::from_fn(|axis| {
            overrides[axis]
                .is_none()
                .then_some(entry.workgroup_size[axis])
        }),
        tile: options.tile,
        max_rate: options.max_rate,
        wave: options.wave,
        full_tiles: options.full_tiles,
        sky: options.sky,
        dispatch: Dispatch {
            divide: [width, height, 1],
            indirect: matches!(options.mode, Mode::List | Mode::Classified),
        },
        linear: options.linear.clone(),
        atomics: options.atomics,
        bindings: added(placement),
        shares_group: bindings::is_shared(module, info, index, placement),
        needs: Needs::new(module, info, index, placement),
        user: graded::asks_user(module, index),
        linear_depth: options.linear_depth && options.mode != Mode::Graded,
        targets: targets
            .iter()
            .filter_map(|target| {
                let global = &module.global_variables[target.global];
                let binding = global.binding?;
                Some(Target {
                    name: global.name.clone().unwrap_or_default(),
                    group: binding.group,
                    binding: binding.binding,
                    policy: target.policy,
                    read: uses[target.global].contains(GlobalUse::READ),
                })
            })
            .collect(),
        group: None,
        warnings: Vec::new(),
    }
}
