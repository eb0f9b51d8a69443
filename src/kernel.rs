//! The runtime's own kernels: WGSL from `shaders/`, composed with naga_oil's conditional compilation.

use std::collections::HashMap;

use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue, ShaderType,
};

use crate::{
    limits::{LimitError, Needs},
    object::ObjectOptions,
};

/// Definitions that a kernel's text refers to as `#{NAME}`.
pub(crate) type Defs<'d> = &'d [(&'d str, u32)];

/// A kernel's text.
#[derive(Clone, Copy)]
pub(crate) struct Source {
    /// The file's name, for messages and labels.
    pub(crate) name: &'static str,
    /// Its text.
    pub(crate) text: &'static str,
}

/// Names a file in `shaders/`, and files that hold its rooms.
macro_rules! shader {
    ($name:literal $(, $room:literal)* $(,)?) => {
        $crate::kernel::Source {
            name: $name,
            text: concat!(
                include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $name)),
                $("\n", include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $room)),)*
            ),
        }
    };
}
pub(crate) use shader;

/// Modules that kernels import: each after those that it imports itself.
const MODULES: &[Source] = &[
    shader!("rate.wgsl"),
    shader!("depth.wgsl"),
    shader!("analyse/params.wgsl"),
    shader!("analyse/because.wgsl"),
    shader!("analyse/fixed.wgsl"),
    shader!("analyse/pairs.wgsl"),
    shader!("analyse/pictures.wgsl"),
    shader!("analyse/optics.wgsl"),
    shader!("analyse/source.wgsl"),
    shader!("analyse/cells.wgsl"),
    shader!("analyse/sums.wgsl"),
    shader!("analyse/rates.wgsl"),
    shader!("analyse/strips.wgsl"),
    shader!("analyse/sure.wgsl"),
    shader!("analyse/lines.wgsl"),
    shader!("analyse/areas.wgsl"),
    shader!("deblock/params.wgsl"),
    shader!("deblock/picture.wgsl"),
    shader!("deblock/groups.wgsl"),
    shader!("deblock/surfaces.wgsl"),
];

/// Composes a kernel.
///
/// # Panics
/// If the kernel does not compose: it is ours, and a test composes each.
pub(crate) fn compose(source: Source, defs: Defs) -> naga::Module {
    let shader_defs: HashMap<String, ShaderDefValue> = defs
        .iter()
        .map(|&(name, value)| (name.to_owned(), ShaderDefValue::UInt(value)))
        .collect();
    // halves in f32: packing and unpacking, which every backend but WebGL has
    let mut composer =
        Composer::default().with_capabilities(naga::valid::Capabilities::SHADER_FLOAT16_IN_FLOAT32);
    if source.text.contains("#import") {
        for module in MODULES {
            add_module(&mut composer, *module);
        }
    }
    let composed = composer.make_naga_module(NagaModuleDescriptor {
        source: source.text,
        file_path: source.name,
        shader_type: ShaderType::Wgsl,
        shader_defs,
        ..NagaModuleDescriptor::default()
    });
    match composed {
        Ok(module) => module,
        Err(error) => unreachable!("{}: {}", source.name, error.emit_to_string(&composer)),
    }
}

fn add_module(composer: &mut Composer, module: Source) {
    let added = composer.add_composable_module(ComposableModuleDescriptor {
        source: module.text,
        file_path: module.name,
        ..ComposableModuleDescriptor::default()
    });
    if let Err(error) = added {
        let message = error.emit_to_string(composer);
        unreachable!("{}: {message}", module.name);
    }
}

/// Makes a shader module of a kernel whose loops are not counted: wgpu would end each after 2^64 rounds, and the compiler then unrolls
/// none. Indices are checked as everywhere.
///
/// # Safety
/// Every loop of the kernel has to end, whatever it reads.
///
/// # Errors
/// If the device has too little for it.
pub(crate) unsafe fn trusted_module(
    device: &wgpu::Device,
    source: Source,
    defs: Defs,
) -> Result<wgpu::ShaderModule, LimitError> {
    let checks = wgpu::ShaderRuntimeChecks {
        force_loop_bounding: false,
        ..wgpu::ShaderRuntimeChecks::checked()
    };
    let descriptor = descriptor(device, source, defs)?;
    // SAFETY: the caller's, as above
    Ok(unsafe { device.create_shader_module_trusted(descriptor, checks) })
}

/// Makes a shader module of a kernel, with wgpu's bounds checks on.
///
/// # Errors
/// If the device has too little for it.
pub(crate) fn shader_module(
    device: &wgpu::Device,
    source: Source,
    defs: Defs,
) -> Result<wgpu::ShaderModule, LimitError> {
    Ok(device.create_shader_module(descriptor(device, source, defs)?))
}

fn descriptor(
    device: &wgpu::Device,
    source: Source,
    defs: Defs,
) -> Result<wgpu::ShaderModuleDescriptor<'static>, LimitError> {
    let module = compose(source, defs);
    Needs::of_kernel(&module).check(device, &format!("the kernel `{}`", source.name))?;
    Ok(wgpu::ShaderModuleDescriptor {
        label: Some(source.name),
        source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
    })
}

/// Makes the pipeline of a kernel's entry point, whose one bind group has a layout.
pub(crate) fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    module: &wgpu::ShaderModule,
    entry: &str,
    compilation_options: wgpu::PipelineCompilationOptions,
    objects: &ObjectOptions,
) -> wgpu::ComputePipeline {
    let label = objects.name(entry);
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(&label),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(&label),
        layout: Some(&pipeline_layout),
        module,
        entry_point: Some(entry),
        compilation_options,
        cache: objects.cache,
    })
}

/// Pipelines of kernels that write their workgroup memory before they read it, so that it need not be zeroed first.
pub(crate) fn compilation_options() -> wgpu::PipelineCompilationOptions<'static> {
    wgpu::PipelineCompilationOptions {
        zero_initialize_workgroup_memory: false,
        ..wgpu::PipelineCompilationOptions::default()
    }
}

/// A kernel as a plan tells of it: what is compiled in, and how many resources it binds, counted in the composed module.
pub(crate) fn planned(source: Source, defs: &[(&'static str, u32)]) -> crate::plan::PlannedPass {
    let module = compose(source, defs);
    let bound = |global: &naga::GlobalVariable| global.binding.is_some();
    crate::plan::PlannedPass {
        kernel: source.name,
        effects: defs
            .iter()
            .filter(|(_, value)| *value == 1)
            .map(|&(name, _)| name)
            .collect(),
        bindings: module
            .global_variables
            .iter()
            .filter(|(_, global)| bound(global))
            .count(),
    }
}
