//! What shaders need of a device's limits, read off their modules and held against the device before anything is made of them.
//!
//! *Needs*: a composed or rewritten module. *Guarantees*: a device that has too little is told by the name of the limit, what is
//! needed and what it has; nothing of it reaches wgpu, which would panic. *Refuses*: nothing else.

use naga::{
    AddressSpace, GlobalVariable, ImageClass, Module, ShaderStage, TypeInner, proc::Layouter,
    valid::ModuleInfo,
};

/// A device has less than something needs.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what} needs {needed} of `{limit}`, and the device has {had}: {help}")]
pub struct LimitError {
    /// What needs it: a kernel's file, or a shader's entry point.
    pub what: String,
    /// The limit, as [`wgpu::Limits`] calls it.
    pub limit: &'static str,
    /// What is needed.
    pub needed: u64,
    /// What the device has.
    pub had: u64,
    /// What to do.
    pub help: &'static str,
}

/// What the caller can do where a device has too little and more can be had.
const REQUEST: &str = "request it in `DeviceDescriptor::required_limits`";
/// The same for workgroups, which tiles decide.
const TILES: &str = "request it in `DeviceDescriptor::required_limits`, or choose smaller tiles (`BuildOptions::tile` and the \
    rewriter's `Options::tile`, which have to agree)";
/// The same for immediates.
const IMMEDIATES: &str =
    "request it in `DeviceDescriptor::required_limits`, with `Features::IMMEDIATES`";

/// What a shader needs of a device's limits, by wgpu's names for them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// Invocations of a workgroup, on each axis.
    pub workgroup: [u32; 3],
    /// Bytes of workgroup memory.
    pub workgroup_memory: u32,
    /// Bind groups, up to the highest that is used.
    pub groups: u32,
    /// Binding numbers, up to the highest that is used.
    pub bindings: u32,
    /// Uniform buffers.
    pub uniform_buffers: u32,
    /// Storage buffers.
    pub storage_buffers: u32,
    /// Textures that are sampled or loaded.
    pub sampled_textures: u32,
    /// Storage textures.
    pub storage_textures: u32,
    /// Samplers.
    pub samplers: u32,
    /// Bytes of immediates.
    pub immediates: u32,
}

impl Needs {
    /// What a compute entry point needs: of the module's variables those that it uses. `workgroup` is its size, overrides resolved.
    pub fn of_entry(
        module: &Module,
        info: &ModuleInfo,
        entry: usize,
        workgroup: [u32; 3],
    ) -> Needs {
        let uses = info.get_entry_point(entry);
        let used = module.global_variables.iter();
        let used = used.filter(|&(handle, _)| !uses[handle].is_empty());
        Needs::of(module, used.map(|(_, global)| global), workgroup)
    }

    /// What a kernel of ours needs: all variables of its module, since one layout serves all entry points, and its largest
    /// workgroup.
    pub(crate) fn of_kernel(module: &Module) -> Needs {
        let entries = module.entry_points.iter();
        let compute = entries.filter(|entry| entry.stage == ShaderStage::Compute);
        let largest = compute.max_by_key(|entry| entry.workgroup_size.iter().product::<u32>());
        let workgroup = largest.map_or([0; 3], |entry| entry.workgroup_size);
        let globals = module.global_variables.iter().map(|(_, global)| global);
        Needs::of(module, globals, workgroup)
    }

    fn of<'m>(
        module: &'m Module,
        globals: impl Iterator<Item = &'m GlobalVariable>,
        workgroup: [u32; 3],
    ) -> Needs {
        let mut layouts = Layouter::default();
        // a type without a layout here has overrides in it, and only workgroup memory can
        let is_laid_out = layouts.update(module.to_ctx()).is_ok();
        let bytes = |global: &GlobalVariable| match is_laid_out {
            true => layouts[global.ty].size,
            false => 0,
        };
        let mut needs = Needs {
            workgroup,
            ..Needs::default()
        };
        for global in globals {
            if let Some(at) = &global.binding {
                needs.groups = needs.groups.max(at.group.saturating_add(1));
                needs.bindings = needs.bindings.max(at.binding.saturating_add(1));
            }
            match global.space {
                AddressSpace::WorkGroup => {
                    // as wgpu counts it
                    let room = bytes(global).next_multiple_of(16);
                    needs.workgroup_memory = needs.workgroup_memory.saturating_add(room);
                }
                AddressSpace::Immediate => needs.immediates = needs.immediates.max(bytes(global)),
                AddressSpace::Uniform => needs.uniform_buffers += 1,
                AddressSpace::Storage { .. } => needs.storage_buffers += 1,
                _ => needs.add_handle(&module.types[global.ty].inner),
            }
        }
        needs
    }

    fn add_handle(&mut self, inner: &TypeInner) {
        match inner {
            TypeInner::Sampler { .. } => self.samplers += 1,
            TypeInner::Image { class, .. } => match class {
                ImageClass::Storage { .. } => self.storage_textures += 1,
                _ => self.sampled_textures += 1,
            },
            // arrays of bindings have limits and features of their own
            _ => {}
        }
    }

    /// Whether a device has all of it; `what` is what needs it, for the message.
    ///
    /// # Errors
    /// The first limit that is too low.
    pub fn check(&self, device: &wgpu::Device, what: &str) -> Result<(), LimitError> {
        self.within(&device.limits(), what)
    }

    fn within(&self, limits: &wgpu::Limits, what: &str) -> Result<(), LimitError> {
        let [x, y, z] = self.workgroup;
        let invocations = [x, y, z].into_iter().fold(1, u32::saturating_mul);
        let rows = [
            (
                "max_compute_invocations_per_workgroup",
                invocations,
                limits.max_compute_invocations_per_workgroup,
                TILES,
            ),
            (
                "max_compute_workgroup_size_x",
                x,
                limits.max_compute_workgroup_size_x,
                TILES,
            ),
            (
                "max_compute_workgroup_size_y",
                y,
                limits.max_compute_workgroup_size_y,
                TILES,
            ),
            (
                "max_compute_workgroup_size_z",
                z,
                limits.max_compute_workgroup_size_z,
                REQUEST,
            ),
            (
                "max_compute_workgroup_storage_size",
                self.workgroup_memory,
                limits.max_compute_workgroup_storage_size,
                REQUEST,
            ),
            (
                "max_bind_groups",
                self.groups,
                limits.max_bind_groups,
                REQUEST,
            ),
            (
                "max_bindings_per_bind_group",
                self.bindings,
                limits.max_bindings_per_bind_group,
                REQUEST,
            ),
            (
                "max_uniform_buffers_per_shader_stage",
                self.uniform_buffers,
                limits.max_uniform_buffers_per_shader_stage,
                REQUEST,
            ),
            (
                "max_storage_buffers_per_shader_stage",
                self.storage_buffers,
                limits.max_storage_buffers_per_shader_stage,
                REQUEST,
            ),
            (
                "max_sampled_textures_per_shader_stage",
                self.sampled_textures,
                limits.max_sampled_textures_per_shader_stage,
                REQUEST,
            ),
            (
                "max_storage_textures_per_shader_stage",
                self.storage_textures,
                limits.max_storage_textures_per_shader_stage,
                REQUEST,
            ),
            (
                "max_samplers_per_shader_stage",
                self.samplers,
                limits.max_samplers_per_shader_stage,
                REQUEST,
            ),
            (
                "max_immediate_size",
                self.immediates,
                limits.max_immediate_size,
                IMMEDIATES,
            ),
        ];
        match rows.into_iter().find(|&(_, needed, had, _)| needed > had) {
            None => Ok(()),
            Some((limit, needed, had, help)) => Err(LimitError {
                what: what.to_owned(),
                limit,
                needed: u64::from(needed),
                had: u64::from(had),
                help,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn needs(text: &str) -> Needs {
        let module = naga::front::wgsl::parse_str(text).expect("a shader");
        Needs::of_kernel(&module)
    }

    #[test]
    fn a_shader_that_binds_nothing_needs_its_workgroup() {
        let needs = needs("@compute @workgroup_size(8, 4) fn main() {}");
        let only = Needs {
            workgroup: [8, 4, 1],
            ..Needs::default()
        };
        assert_eq!(needs, only);
        assert_eq!(needs.within(&wgpu::Limits::default(), "main"), Ok(()));
    }

    #[test]
    fn each_kind_is_counted_by_itself_and_the_largest_workgroup_counts() {
        let needs = needs(
            "@group(0) @binding(7) var<uniform> a: u32;
             @group(2) @binding(0) var<storage> b: array<u32>;
             @group(0) @binding(1) var<storage, read_write> c: array<u32>;
             @group(0) @binding(2) var d: texture_2d<f32>;
             @group(0) @binding(3) var e: texture_storage_2d<rgba8unorm, write>;
             @group(0) @binding(4) var f: sampler;
             var<workgroup> g: array<u32, 5>;
             @compute @workgroup_size(4) fn small() {}
             @compute @workgroup_size(4, 32, 2) fn large() {}",
        );
        let wanted = Needs {
            workgroup: [4, 32, 2],
            workgroup_memory: 32,
            groups: 3,
            bindings: 8,
            uniform_buffers: 1,
            storage_buffers: 2,
            sampled_textures: 1,
            storage_textures: 1,
            samplers: 1,
            immediates: 0,
        };
        assert_eq!(needs, wanted);
    }

    #[test]
    fn what_a_device_lacks_is_told_by_its_name() {
        let needs = needs("@compute @workgroup_size(16, 16) fn main() {}");
        let limits = wgpu::Limits {
            max_compute_invocations_per_workgroup: 128,
            ..wgpu::Limits::default()
        };
        let error = needs
            .within(&limits, "`main`")
            .expect_err("128 are too few");
        let words = error.to_string();
        assert!(
            words.starts_with(
                "`main` needs 256 of `max_compute_invocations_per_workgroup`, and the device has 128: request it"
            ),
            "{words}"
        );
    }
}
