//! A module in the languages of native APIs, by naga's back ends, with the map of its bindings.
//!
//! *Does*: gives overrides their values, numbers the bindings of each entry point in the order of their declaration, writes.
//! *Guarantees*: the [map](Output) names every binding of the text, the added ones included. Bounds are checked as WGSL promises it,
//! unless that is turned off.
//! *Refuses*: what a back end cannot say, in one sentence; a back end that panics is an error, too.

// without any of the languages there is nobody to describe bindings for
#![cfg_attr(
    not(all(feature = "spirv", feature = "hlsl", feature = "msl", feature = "glsl")),
    allow(dead_code)
)]

use std::{borrow::Cow, collections::BTreeMap};

use naga::{
    AddressSpace, EntryPoint, GlobalVariable, ImageClass, Module, ShaderStage, StorageAccess,
    TypeInner, back::pipeline_constants::process_overrides, valid::ModuleInfo,
};

use super::{EmitError, Form, Language, Target, Written};
use crate::{
    deep,
    manifest::{Output, OutputBinding, OutputEntry},
};

/// Writes a module in one of the languages of native APIs.
pub(super) fn write(
    module: &Module,
    info: &ModuleInfo,
    target: Target,
    form: &Form,
) -> Result<Written, EmitError> {
    let entry = chosen(module, target, form)?;
    if target.language() == Language::Glsl
        && let Err(EmitError::NoText(what)) = super::refuse_what_panics(module)
    {
        return Err(EmitError::BackEnd {
            language: target.language(),
            why: format!("it has nothing for {what}"),
        });
    }
    // back ends panic on what they do not know; on a thread of its own that is a message
    let written = deep::run(|| {
        let (module, info) = process_overrides(module, info, entry, &form.constants())
            .map_err(|error| EmitError::Constants(error.to_string()))?;
        let job = Job {
            module,
            info,
            target,
            form,
        };
        job.write()
    });
    written.unwrap_or_else(|panic| {
        Err(EmitError::BackEnd {
            language: target.language(),
            why: panic,
        })
    })
}

/// The entry point that is written, if it is one alone.
fn chosen<'m>(
    module: &'m Module,
    target: Target,
    form: &Form,
) -> Result<Option<(ShaderStage, &'m str)>, EmitError> {
    let found = |entry: &'m EntryPoint| Some((entry.stage, entry.name.as_str()));
    if let Some(name) = &form.entry {
        let entry = module.entry_points.iter().find(|entry| entry.name == *name);
        return entry
            .map(found)
            .ok_or_else(|| EmitError::NoEntry(name.clone()));
    }
    match (target.language(), module.entry_points.as_slice()) {
        (Language::Glsl, [only]) => Ok(found(only)),
        (Language::Glsl, several) => Err(EmitError::OneEntry(
            several.iter().map(|entry| entry.name.clone()).collect(),
        )),
        _ => Ok(None),
    }
}

struct Job<'m> {
    module: Cow<'m, Module>,
    info: Cow<'m, ModuleInfo>,
    target: Target,
    form: &'m Form,
}

/// What a binding is to a native API.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Class {
    Uniform,
    ReadBuffer,
    WriteBuffer,
    Texture,
    StorageTexture,
    Sampler,
    AccelerationStructure,
    Immediate,
}

impl Class {
    fn name(self) -> &'static str {
        match self {
            Class::Uniform => "uniform",
            Class::ReadBuffer => "read-only-storage",
            Class::WriteBuffer => "storage",
            Class::Texture => "texture",
            Class::StorageTexture => "storage-texture",
            Class::Sampler => "sampler",
            Class::AccelerationStructure => "acceleration-structure",
            Class::Immediate => "immediate",
        }
    }
}

impl Job<'_> {
    fn write(&self) -> Result<Written, EmitError> {
        match self.target.language() {
            Language::Wgsl => Err(self.failed("WGSL is written elsewhere")),
            Language::SpirV => self.spirv(),
            Language::Hlsl => self.hlsl(),
            Language::Msl => self.msl(),
            Language::Glsl => self.glsl(),
        }
    }

    fn failed(&self, why: impl ToString) -> EmitError {
        EmitError::BackEnd {
            language: self.target.language(),
            why: why.to_string(),
        }
    }

    fn class(&self, global: &GlobalVariable) -> Option<Class> {
        let ty = match self.module.types[global.ty].inner {
            TypeInner::BindingArray { base, .. } => &self.module.types[base].inner,
            ref other => other,
        };
        match global.space {
            AddressSpace::Uniform => Some(Class::Uniform),
            AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => {
                Some(Class::WriteBuffer)
            }
            AddressSpace::Storage { .. } => Some(Class::ReadBuffer),
            AddressSpace::Immediate => Some(Class::Immediate),
            AddressSpace::Handle => match ty {
                TypeInner::Sampler { .. } => Some(Class::Sampler),
                TypeInner::AccelerationStructure { .. } => Some(Class::AccelerationStructure),
                TypeInner::Image {
                    class: ImageClass::Storage { .. },
                    ..
                } => Some(Class::StorageTexture),
                _ => Some(Class::Texture),
            },
            _ => None,
        }
    }

    /// The resources of an entry point, in the order of their declaration.
    fn resources(&self, index: usize) -> Vec<(&GlobalVariable, Class)> {
        let uses = self.info.get_entry_point(index);
        self.module
            .global_variables
            .iter()
            .filter(|(handle, _)| !uses[*handle].is_empty())
            .filter_map(|(_, global)| Some((global, self.class(global)?)))
            .collect()
    }

    /// Describes the bindings of each entry point; `place` tells where one is, in the terms of the API.
    fn output(
        &self,
        names: impl Fn(usize) -> Option<String>,
        place: impl Fn(usize, &GlobalVariable, Class) -> Option<(String, u32, Option<u32>)>,
    ) -> Output {
        let entries = self.module.entry_points.iter().enumerate();
        let entries = entries.filter_map(|(index, entry)| {
            Some(OutputEntry {
                name: entry.name.clone(),
                written: names(index)?,
                bindings: self
                    .resources(index)
                    .into_iter()
                    .filter_map(|(global, class)| {
                        let (register, number, space) = place(index, global, class)?;
                        Some(OutputBinding {
                            name: global.name.clone().unwrap_or_default(),
                            group: global.binding.map(|binding| binding.group),
                            binding: global.binding.map(|binding| binding.binding),
                            class: class.name().to_owned(),
                            register,
                            index: number,
                            space,
                        })
                    })
                    .collect(),
                extra: BTreeMap::new(),
            })
        });
        Output {
            language: self.target.language().name().to_owned(),
            version: self.target.version().to_owned(),
            entries: entries.collect(),
        }
    }
}

#[cfg(feature = "spirv")]
impl Job<'_> {
    fn spirv(&self) -> Result<Written, EmitError> {
        use naga::back::spv;
        let is_open = |global: &&GlobalVariable| {
            let inner = &self.module.types[global.ty].inner;
            matches!(
                inner,
                TypeInner::BindingArray {
                    size: naga::ArraySize::Dynamic,
                    ..
                }
            )
        };
        let mut globals = self
            .module
            .global_variables
            .iter()
            .map(|(_, global)| global);
        if let Some(global) = globals.find(is_open) {
            let name = global.name.as_deref().unwrap_or("an unnamed resource");
            return Err(self.failed(format!(
                "naga's writer makes no valid module of `{name}`, a binding array without a length, of the original neither; give it one \
                 (`binding_array<T, 64>`), or write WGSL"
            )));
        }
        let (major, minor) = self.target.numbers();
        let options = spv::Options {
            lang_version: (major as u8, minor),
            bounds_check_policies: self.form.policies(),
            ..spv::Options::default()
        };
        let pipeline = self.form.entry.as_ref().and_then(|name| {
            let entry = self.module.entry_points.iter().find(|e| e.name == *name)?;
            Some(spv::PipelineOptions {
                shader_stage: entry.stage,
                entry_point: name.clone(),
            })
        });
        let words = spv::write_vec(&self.module, &self.info, &options, pipeline.as_ref())
            .map_err(|error| self.failed(error))?;
        let output = self.output(
            |index| Some(self.module.entry_points[index].name.clone()),
            |_, global, class| match (class, global.binding) {
                (_, Some(at)) => Some(("binding".to_owned(), at.binding, Some(at.group))),
                _ => Some(("push-constant".to_owned(), 0, None)),
            },
        );
        Ok(Written {
            bytes: words.iter().flat_map(|word| word.to_le_bytes()).collect(),
            output,
        })
    }
}

#[cfg(feature = "hlsl")]
impl Job<'_> {
    /// Registers are the bindings' numbers, spaces their groups. Samplers are found as naga's text finds them: in one heap, by an
    /// index from a buffer of each group.
    fn hlsl(&self) -> Result<Written, EmitError> {
        use naga::back::hlsl;
        // spaces behind every group
        const INDEX_SPACE: u8 = 254;
        const IMMEDIATES_SPACE: u8 = 253;
        let mut options = hlsl::Options {
            shader_model: match self.target.version() {
                "5.1" => hlsl::ShaderModel::V5_1,
                "6.1" => hlsl::ShaderModel::V6_1,
                "6.2" => hlsl::ShaderModel::V6_2,
                "6.3" => hlsl::ShaderModel::V6_3,
                "6.4" => hlsl::ShaderModel::V6_4,
                "6.5" => hlsl::ShaderModel::V6_5,
                "6.6" => hlsl::ShaderModel::V6_6,
                "6.7" => hlsl::ShaderModel::V6_7,
                _ => hlsl::ShaderModel::V6_0,
            },
            fake_missing_bindings: false,
            restrict_indexing: self.form.checks_bounds,
            immediates_target: Some(hlsl::BindTarget {
                space: IMMEDIATES_SPACE,
                ..hlsl::BindTarget::default()
            }),
            ..hlsl::Options::default()
        };
        let mut samplers: BTreeMap<u32, u32> = BTreeMap::new();
        for (_, global) in self.module.global_variables.iter() {
            let (Some(at), Some(class)) = (global.binding, self.class(global)) else {
                continue;
            };
            let space = u8::try_from(at.group).map_err(|_| self.failed("too many bind groups"))?;
            let register = match class {
                Class::Sampler => {
                    let count = samplers.entry(at.group).or_default();
                    *count += 1;
                    *count - 1
                }
                _ => at.binding,
            };
            options.binding_map.insert(
                at,
                hlsl::BindTarget {
                    space,
                    register,
                    restrict_indexing: self.form.checks_bounds,
                    ..hlsl::BindTarget::default()
                },
            );
        }
        for &group in samplers.keys() {
            options.sampler_buffer_binding_map.insert(
                hlsl::SamplerIndexBufferKey { group },
                hlsl::BindTarget {
                    space: INDEX_SPACE,
                    register: group,
                    ..hlsl::BindTarget::default()
                },
            );
        }
        let pipeline = hlsl::PipelineOptions {
            entry_point: self.form.entry.as_ref().and_then(|name| {
                let entry = self.module.entry_points.iter().find(|e| e.name == *name)?;
                Some((entry.stage, name.clone()))
            }),
        };
        let mut text = String::new();
        let reflection = hlsl::Writer::new(&mut text, &options, &pipeline)
            .write(&self.module, &self.info, None)
            .map_err(|error| self.failed(error))?;
        for name in &reflection.entry_point_names {
            if let Err(error) = name {
                return Err(self.failed(error));
            }
        }
        let register = |class| match class {
            Class::Uniform | Class::Immediate => "b",
            Class::WriteBuffer | Class::StorageTexture => "u",
            Class::Sampler => "sampler-index",
            Class::ReadBuffer | Class::Texture | Class::AccelerationStructure => "t",
        };
        let mut output = self.output(
            |index| reflection.entry_point_names.get(index)?.clone().ok(),
            |_, global, class| {
                let (number, space) = match global.binding {
                    Some(at) => (options.binding_map[&at].register, at.group),
                    None => (0, u32::from(IMMEDIATES_SPACE)),
                };
                Some((register(class).to_owned(), number, Some(space)))
            },
        );
        for entry in &mut output.entries {
            let groups: Vec<u32> = entry
                .bindings
                .iter()
                .filter(|binding| binding.class == "sampler")
                .filter_map(|binding| binding.group)
                .collect();
            for group in groups {
                entry.extra.insert(
                    format!("nagaGroup{group}SamplerIndexArray"),
                    format!("t{group}, space{INDEX_SPACE}"),
                );
                entry
                    .extra
                    .insert("nagaSamplerHeap".to_owned(), "s0, space0".to_owned());
                entry.extra.insert(
                    "nagaComparisonSamplerHeap".to_owned(),
                    "s0, space1".to_owned(),
                );
            }
        }
        Ok(Written::text(text, output))
    }
}

#[cfg(feature = "msl")]
impl Job<'_> {
    /// Buffers, textures and samplers of each entry point are numbered from 0; then come the immediates, then the buffer of the
    /// sizes of the buffers without a fixed size, in the order of their declaration.
    fn msl(&self) -> Result<Written, EmitError> {
        use naga::back::msl;
        let (major, minor) = self.target.numbers();
        let mut per_entry_point_map = msl::EntryPointResourceMap::default();
        let mut sizes = Vec::new();
        for (index, entry) in self.module.entry_points.iter().enumerate() {
            let mut resources = msl::EntryPointResources::default();
            let (mut buffers, mut textures, mut samplers) = (0u8, 0u8, 0u8);
            let full = |class: Class| {
                self.failed(format!(
                    "{}: too many bindings of one kind: {}",
                    entry.name,
                    class.name()
                ))
            };
            let mut immediates = false;
            for (global, class) in self.resources(index) {
                let Some(at) = global.binding else {
                    immediates |= class == Class::Immediate;
                    continue;
                };
                let mut bind = msl::BindTarget::default();
                let slots = match class {
                    Class::Texture | Class::StorageTexture => &mut textures,
                    Class::Sampler => &mut samplers,
                    _ => &mut buffers,
                };
                let slot = *slots;
                *slots = slot.checked_add(1).ok_or_else(|| full(class))?;
                match class {
                    Class::Texture => bind.texture = Some(slot),
                    Class::StorageTexture => (bind.texture, bind.mutable) = (Some(slot), true),
                    Class::Sampler => bind.sampler = Some(msl::BindSamplerTarget::Resource(slot)),
                    Class::WriteBuffer => (bind.buffer, bind.mutable) = (Some(slot), true),
                    _ => bind.buffer = Some(slot),
                }
                resources.resources.insert(at, bind);
            }
            if immediates {
                resources.immediates_buffer = Some(buffers);
                buffers = buffers
                    .checked_add(1)
                    .ok_or_else(|| full(Class::Immediate))?;
            }
            resources.sizes_buffer = Some(buffers);
            sizes.push(buffers);
            per_entry_point_map.insert(entry.name.clone(), resources);
        }
        let options = msl::Options {
            lang_version: (major as u8, minor),
            per_entry_point_map,
            fake_missing_bindings: false,
            bounds_check_policies: self.form.policies(),
            ..msl::Options::default()
        };
        let pipeline = msl::PipelineOptions {
            entry_point: self.form.entry.as_ref().and_then(|name| {
                let entry = self.module.entry_points.iter().find(|e| e.name == *name)?;
                Some((entry.stage, name.clone()))
            }),
            ..msl::PipelineOptions::default()
        };
        let (text, translation) = msl::write_string(&self.module, &self.info, &options, &pipeline)
            .map_err(|error| self.failed(error))?;
        for name in &translation.entry_point_names {
            if let Err(error) = name {
                return Err(self.failed(error));
            }
        }
        let map = &options.per_entry_point_map;
        let mut output = self.output(
            |index| translation.entry_point_names.get(index)?.clone().ok(),
            |index, global, _| {
                let resources = &map[&self.module.entry_points[index].name];
                let Some(at) = global.binding else {
                    let slot = resources.immediates_buffer?;
                    return Some(("buffer".to_owned(), u32::from(slot), None));
                };
                let bind = &resources.resources[&at];
                let (register, slot) = match bind.sampler {
                    Some(msl::BindSamplerTarget::Resource(slot)) => ("sampler", slot),
                    _ => bind
                        .texture
                        .map(|slot| ("texture", slot))
                        .or(bind.buffer.map(|slot| ("buffer", slot)))?,
                };
                Some((register.to_owned(), u32::from(slot), None))
            },
        );
        if text.contains("_mslBufferSizes") {
            for (entry, slot) in output.entries.iter_mut().zip(sizes) {
                entry
                    .extra
                    .insert("_mslBufferSizes".to_owned(), format!("buffer {slot}"));
            }
        }
        Ok(Written::text(text, output))
    }
}

#[cfg(feature = "glsl")]
impl Job<'_> {
    /// Uniform buffers, storage buffers, images and textures are numbered from 0, each kind for itself. GLSL has no samplers of
    /// their own: a texture brings its sampler.
    fn glsl(&self) -> Result<Written, EmitError> {
        use naga::back::glsl;
        let (number, _) = self.target.numbers();
        let version = match self.target.version().ends_with("es") {
            true => glsl::Version::new_gles(number),
            false => glsl::Version::Desktop(number),
        };
        let Some(name) = self
            .form
            .entry
            .clone()
            .or_else(|| Some(self.module.entry_points.first()?.name.clone()))
        else {
            return Err(self.failed("there is no entry point"));
        };
        let position = self.module.entry_points.iter().position(|e| e.name == name);
        let Some(index) = position else {
            return Err(EmitError::NoEntry(name));
        };
        let mut counts: BTreeMap<&str, u8> = BTreeMap::new();
        let mut binding_map = glsl::BindingMap::default();
        let kind = |class| match class {
            Class::Uniform => Some("uniform"),
            Class::ReadBuffer | Class::WriteBuffer => Some("buffer"),
            Class::StorageTexture => Some("image"),
            Class::Texture => Some("texture"),
            Class::Sampler | Class::AccelerationStructure | Class::Immediate => None,
        };
        for (global, class) in self.resources(index) {
            let (Some(at), Some(kind)) = (global.binding, kind(class)) else {
                continue;
            };
            let count = counts.entry(kind).or_default();
            binding_map.insert(at, *count);
            *count = count
                .checked_add(1)
                .ok_or_else(|| self.failed(format!("too many bindings of one kind: {kind}")))?;
        }
        let options = glsl::Options {
            version,
            binding_map,
            ..glsl::Options::default()
        };
        let pipeline = glsl::PipelineOptions {
            shader_stage: self.module.entry_points[index].stage,
            entry_point: name.clone(),
            multiview: None,
        };
        let mut text = String::new();
        let reflection = glsl::Writer::new(
            &mut text,
            &self.module,
            &self.info,
            &options,
            &pipeline,
            self.form.policies(),
        )
        .and_then(|mut writer| writer.write())
        .map_err(|error| self.failed(error))?;
        let mut output = self.output(
            |number| (number == index).then(|| "main".to_owned()),
            |_, global, class| {
                let number = *options.binding_map.get(&global.binding?)?;
                Some((kind(class)?.to_owned(), u32::from(number), None))
            },
        );
        // which sampler a texture brings
        for entry in &mut output.entries {
            for mapping in reflection.texture_mapping.values() {
                if let Some(sampler) = mapping.sampler {
                    let name = |handle| {
                        let global: &GlobalVariable = &self.module.global_variables[handle];
                        global.name.clone().unwrap_or_default()
                    };
                    entry.extra.insert(
                        name(mapping.texture),
                        format!("sampled with {}", name(sampler)),
                    );
                }
            }
        }
        Ok(Written::text(text, output))
    }
}

/// What to say where a language was left out.
macro_rules! left_out {
    ($($feature:literal $name:ident),+) => {
        $(#[cfg(not(feature = $feature))]
        impl Job<'_> {
            fn $name(&self) -> Result<Written, EmitError> {
                Err(self.failed(concat!("vrcs-passes was built without its feature `", $feature, "`")))
            }
        })+
    };
}

left_out!("spirv" spirv, "hlsl" hlsl, "msl" msl, "glsl" glsl);
