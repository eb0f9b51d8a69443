//! SPIR-V whose float arithmetic no compiler may change.
//!
//! Drivers may reorder and fuse float operations, and what they do depends on the rest of the program: lavapipe computes
//! `(a + b) + 3.0` as `(a + 3.0) + b` in one shader and not in the other. Two correct programs then differ in the last
//! bit. So a check hands the driver SPIR-V of its own, in which every float operation is decorated `NoContraction`, where the device
//! lets it (`PASSTHROUGH_SHADERS`, on Vulkan).
//!
//! *Does*: writes an entry point as wgpu would (overrides given, bindings numbered in order, indices checked, loops bounded,
//! workgroup memory cleared), and decorates it.

use std::collections::BTreeSet;

use naga::{
    Module, ResourceBinding, ShaderStage,
    back::{pipeline_constants::process_overrides, spv},
    proc::{BoundsCheckPolicies, BoundsCheckPolicy},
    valid::ModuleInfo,
};

/// The SPIR-V of a compute entry point, and its workgroup size. `bindings` are those of the pipeline's layout.
///
/// # Errors
/// What naga says, where it cannot write the module.
pub(super) fn spirv(
    module: &Module,
    info: &ModuleInfo,
    entry: &str,
    constants: &[(String, f64)],
    bindings: &BTreeSet<(u32, u32)>,
) -> Result<(Vec<u32>, [u32; 3]), String> {
    let constants = constants
        .iter()
        .map(|(name, value)| (name.clone(), *value))
        .collect();
    let stage = ShaderStage::Compute;
    let (module, info) = process_overrides(module, info, Some((stage, entry)), &constants)
        .map_err(|error| error.to_string())?;
    let is_entry = |e: &&naga::EntryPoint| e.stage == stage && e.name == entry;
    let size = module
        .entry_points
        .iter()
        .find(is_entry)
        .ok_or("the entry point is gone")?
        .workgroup_size;
    let options = spv::Options {
        lang_version: (1, 3),
        flags: spv::WriterFlags::empty(),
        binding_map: binding_map(bindings),
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            buffer: BoundsCheckPolicy::Restrict,
            // a texel beyond the end may be any: here none that others store to in the meantime
            image_load: BoundsCheckPolicy::ReadZeroSkipWrite,
            binding_array: BoundsCheckPolicy::Unchecked,
        },
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::Polyfill,
        force_loop_bounding: true,
        ..spv::Options::default()
    };
    let pipeline = spv::PipelineOptions {
        shader_stage: stage,
        entry_point: entry.to_owned(),
    };
    let words = spv::write_vec(&module, &info, &options, Some(&pipeline))
        .map_err(|error| error.to_string())?;
    Ok((decorated(&words), size))
}

/// wgpu numbers the bindings of a group anew, in their order.
fn binding_map(bindings: &BTreeSet<(u32, u32)>) -> spv::BindingMap {
    let mut map = spv::BindingMap::default();
    let mut next = (0, 0);
    for &(group, binding) in bindings {
        if next.0 != group {
            next = (group, 0);
        }
        map.insert(
            ResourceBinding { group, binding },
            spv::BindingInfo {
                descriptor_set: group,
                binding: next.1,
                binding_array_size: None,
            },
        );
        next.1 += 1;
    }
    map
}

const HEADER: usize = 5;
const OP_EXT_INST: u32 = 12;
const OP_TYPE_FLOAT: u32 = 22;
const OP_TYPE_VECTOR: u32 = 23;
const OP_F_DIV: u32 = 136;
const OP_DECORATE: u32 = 71;
const NO_CONTRACTION: u32 = 42;

/// Whether an instruction is float arithmetic: `OpFNegate`, `OpFAdd` and so on, products of vectors and matrices, `OpDot`.
fn is_float_arithmetic(opcode: u32) -> bool {
    matches!(
        opcode,
        127 | 129 | 131 | 133 | 136 | 140..=148 | OP_EXT_INST
    )
}

/// Decorates every float operation `NoContraction`, but divisions of halves: a quotient has nothing to be contracted with that another
/// operation's decoration does not forbid, and where one is decorated NVIDIA's driver (580.159.04, Vulkan, H100 and H200) writes into another
/// value of the program: `vec4(f32(f16(x) / 3.0h), x, y, 0.0)` gave the `y` of another pixel.
fn decorated(words: &[u32]) -> Vec<u32> {
    let mut decorations = Vec::new();
    let mut halves = BTreeSet::new();
    // decorations come right before the first type
    let mut types = words.len();
    let mut at = HEADER;
    while at < words.len() {
        let (opcode, length) = (words[at] & 0xffff, (words[at] >> 16).max(1) as usize);
        if (19..=39).contains(&opcode) {
            types = types.min(at);
        }
        match (opcode, words.get(at + 2)) {
            (OP_TYPE_FLOAT, Some(16)) => {
                halves.insert(words[at + 1]);
            }
            (OP_TYPE_VECTOR, Some(of)) if halves.contains(of) => {
                halves.insert(words[at + 1]);
            }
            _ => {}
        }
        let is_quotient_of_halves = opcode == OP_F_DIV && halves.contains(&words[at + 1]);
        if is_float_arithmetic(opcode) && !is_quotient_of_halves {
            decorations.extend([3 << 16 | OP_DECORATE, words[at + 2], NO_CONTRACTION]);
        }
        at += length;
    }
    [&words[..types], &decorations, &words[types..]].concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    #[test]
    fn float_operations_are_decorated_and_integer_ones_are_not() {
        let module = naga::front::wgsl::parse_str(
            "@group(1) @binding(7) var<storage, read_write> values: array<f32>;
            override side: u32 = 4u;
            @compute @workgroup_size(side) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
                values[id.x * 3u] = values[id.x] * 2.0 + 1.0;
            }",
        )
        .expect("WGSL");
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(&module)
            .expect("valid");
        let constants = [("side".to_owned(), 8.0)];
        let bindings = BTreeSet::from([(1, 7)]);
        let (words, size) = spirv(&module, &info, "main", &constants, &bindings).expect("SPIR-V");
        assert_eq!(size, [8, 1, 1]);
        let mut at = HEADER;
        let (mut decorated, mut float, mut seen_type) = (0, 0, false);
        while at < words.len() {
            let (opcode, length) = (words[at] & 0xffff, words[at] >> 16);
            seen_type |= (19..=39).contains(&opcode);
            if opcode == OP_DECORATE && words[at + 2] == NO_CONTRACTION {
                decorated += 1;
                assert!(!seen_type);
            }
            float += u32::from(is_float_arithmetic(opcode) && opcode != OP_EXT_INST);
            at += length as usize;
        }
        assert_eq!(float, 2);
        assert!(decorated >= 2);
    }
}
