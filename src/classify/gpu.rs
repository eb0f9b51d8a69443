//! Tile classification on the GPU: `shaders/classify.wgsl` with the caller's rules in it, recorded into the caller's encoder.

use std::fmt::Write;

use bytemuck::{Pod, Zeroable};

use super::{ClassifyError, MOST_CLASSES, Options, Rule};
use crate::{kernel, object::ObjectOptions};

const TEXT: &str = include_str!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/shaders/classify.wgsl"
));
const PIXEL: &str = include_str!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/shaders/classified_tiles.wgsl"
));

/// Words before the lists.
const HEADER: u32 = 16;

/// The kernel's parameters, as in `shaders/classify.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Params {
    extent: [u32; 2],
    tiles: [u32; 2],
}

/// The pipelines that classify tiles by given rules.
#[derive(Debug)]
pub struct Classifier {
    options: Options,
    most_groups: u32,
    layout: wgpu::BindGroupLayout,
    lists_layout: wgpu::BindGroupLayout,
    reduce: wgpu::ComputePipeline,
    sort: Option<wgpu::ComputePipeline>,
    kick: wgpu::ComputePipeline,
}

/// The lists of a picture's tiles, one for each class, and what dispatches them.
#[derive(Debug)]
pub struct Lists {
    tiles: [u32; 2],
    room: [u32; 2],
    params: wgpu::Buffer,
    arguments: wgpu::Buffer,
    lists: wgpu::Buffer,
    group: wgpu::BindGroup,
    shading: wgpu::BindGroup,
}

impl Classifier {
    /// Makes the pipelines.
    ///
    /// # Errors
    /// If the options contradict themselves, or what they say in WGSL does not compile.
    pub fn new(device: &wgpu::Device, options: Options) -> Result<Classifier, ClassifyError> {
        options.check()?;
        let most_groups = device
            .limits()
            .max_compute_workgroups_per_dimension
            .min(65_535);
        let text = text(&options, most_groups);
        let module = parse(&text)?;
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("vrcs classify"),
            source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
        });
        let layout = layout(device);
        let objects = ObjectOptions::labelled("vrcs classify");
        let pipeline = |entry| {
            let zeroed = wgpu::PipelineCompilationOptions::default();
            kernel::pipeline(device, &layout, &shader, entry, zeroed, &objects)
        };
        Ok(Classifier {
            reduce: pipeline("reduce_tiles"),
            sort: options.neighbourhood.then(|| pipeline("sort_tiles")),
            kick: pipeline("kick"),
            lists_layout: Classifier::lists_layout(device),
            layout,
            most_groups,
            options,
        })
    }

    /// The options.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The index of a class.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn class(&self, name: &str) -> Result<usize, ClassifyError> {
        let mut classes = self.options.classes.iter();
        classes
            .position(|class| class.name == name)
            .ok_or_else(|| ClassifyError::NoClass(name.to_owned()))
    }

    /// The layout of the bind group that the classes' shaders need, besides the caller's own: one storage buffer, read only.
    pub fn lists_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("vrcs tile lists"),
            entries: &[entry(
                0,
                buffer(wgpu::BufferBindingType::Storage { read_only: true }),
            )],
        })
    }

    /// WGSL to put before the shader of a class: the lists as `@group(group) @binding(0)`, and
    /// `vrcs_pixel(workgroup_id, local_invocation_index)`, which gives the invocation's pixel. The shader's workgroups have
    /// [`block`](Options::block)² invocations in one dimension, and an invocation that is not `is_inside` has nothing to do.
    ///
    /// # Errors
    /// If there is no such class.
    pub fn wgsl(&self, class: &str, group: u32) -> Result<String, ClassifyError> {
        let index = self.class(class)?;
        let mut text = format!("const VRCS_CLASS: u32 = {index}u;\n");
        for (name, value) in [
            ("TILE", self.options.tile),
            ("BLOCK", self.options.block),
            ("REPLICATE", self.options.replicate()),
            ("MOST_GROUPS", self.most_groups),
            ("HEADER", HEADER),
        ] {
            // writing to a string cannot fail
            let _ = writeln!(text, "const VRCS_{name}: u32 = {value}u;");
        }
        text += &PIXEL.replace("VRCS_GROUP", &group.to_string());
        Ok(text)
    }

    /// Makes lists for a texture. [`Classifier::set_extent`] has to follow.
    ///
    /// # Errors
    /// If the texture has more tiles than the device dispatches.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        source: &wgpu::TextureView,
    ) -> Result<Lists, ClassifyError> {
        let room = [source.texture().width(), source.texture().height()];
        let tiles = self.options.tiles(room);
        if tiles.iter().any(|&tiles| tiles > self.most_groups) {
            return Err(ClassifyError::Extent(format!(
                "{}x{} tiles; the device dispatches at most {} on an axis",
                tiles[0], tiles[1], self.most_groups
            )));
        }
        let count = u64::from(tiles[0]) * u64::from(tiles[1]);
        let make = |label, words: u64, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: words.max(1) * 4,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        let params = make("vrcs classify params", 4, Usage::UNIFORM | Usage::COPY_DST);
        let classes = self.options.classes.len() as u64;
        let bounds = match self.sort {
            Some(_) => count * 2,
            None => 2,
        };
        let bounds = make("vrcs tile bounds", bounds, Usage::STORAGE);
        let lists = make(
            "vrcs tile lists",
            u64::from(HEADER) + classes * count,
            Usage::STORAGE | Usage::COPY_SRC,
        );
        let counters = make("vrcs tile counters", MOST_CLASSES as u64, Usage::STORAGE);
        let arguments = make(
            "vrcs tile arguments",
            MOST_CLASSES as u64 * 3,
            Usage::STORAGE | Usage::INDIRECT | Usage::COPY_SRC,
        );
        let resources = [
            params.as_entire_binding(),
            wgpu::BindingResource::TextureView(source),
            bounds.as_entire_binding(),
            lists.as_entire_binding(),
            counters.as_entire_binding(),
            arguments.as_entire_binding(),
        ];
        let entries: Vec<wgpu::BindGroupEntry> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("vrcs classify"),
            layout: &self.layout,
            entries: &entries,
        });
        let shading = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("vrcs tile lists"),
            layout: &self.lists_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: lists.as_entire_binding(),
            }],
        });
        Ok(Lists {
            tiles: [0, 0],
            room,
            params,
            arguments,
            lists,
            group,
            shading,
        })
    }

    /// Sets the extent of the picture for dispatches that are submitted from now on.
    ///
    /// # Errors
    /// If the texture is smaller.
    pub fn set_extent(
        &self,
        queue: &wgpu::Queue,
        lists: &mut Lists,
        extent: [u32; 2],
    ) -> Result<(), ClassifyError> {
        if extent[0] > lists.room[0] || extent[1] > lists.room[1] {
            return Err(ClassifyError::Extent(format!(
                "an extent of {}x{} in a texture of {}x{}",
                extent[0], extent[1], lists.room[0], lists.room[1]
            )));
        }
        lists.tiles = self.options.tiles(extent);
        let params = Params {
            extent,
            tiles: lists.tiles,
        };
        queue.write_buffer(&lists.params, 0, bytemuck::bytes_of(&params));
        Ok(())
    }

    /// Records the classification, with a pass of its own.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, lists: &Lists) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("vrcs classify"),
            timestamp_writes: None,
        });
        self.record_in(&mut pass, lists);
    }

    /// Records the classification into a compute pass of the caller's.
    pub fn record_in(&self, pass: &mut wgpu::ComputePass, lists: &Lists) {
        let _span = tracing::trace_span!("vrcs classify").entered();
        let [x, y] = lists.tiles;
        pass.set_bind_group(0, &lists.group, &[]);
        pass.set_pipeline(&self.reduce);
        pass.dispatch_workgroups(x, y, 1);
        if let Some(sort) = &self.sort {
            pass.set_pipeline(sort);
            pass.dispatch_workgroups(x.div_ceil(8), y.div_ceil(8), 1);
        }
        pass.set_pipeline(&self.kick);
        pass.dispatch_workgroups(1, 1, 1);
    }
}

impl Lists {
    /// Records the dispatch of a class. The caller has set the class's pipeline and its own bind groups; the lists become bind group
    /// `group`. There are as many workgroups as the class has blocks; nothing happens if it has none.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass, class: usize, group: u32) {
        pass.set_bind_group(group, &self.shading, &[]);
        pass.dispatch_workgroups_indirect(&self.arguments, class as u64 * 12);
    }

    /// The lists: width, height, tiles that each list holds and the number of classes; from word 4 on, the number of tiles in each;
    /// from word 16 on the lists one after the other, each tile `x | y << 16`.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.lists
    }

    /// The arguments of the dispatches, three words for each class.
    pub fn arguments(&self) -> &wgpu::Buffer {
        &self.arguments
    }
}

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    }
}

fn buffer(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let storage = || buffer(wgpu::BufferBindingType::Storage { read_only: false });
    let source = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("vrcs classify"),
        entries: &[
            entry(0, buffer(wgpu::BufferBindingType::Uniform)),
            entry(1, source),
            entry(2, storage()),
            entry(3, storage()),
            entry(4, storage()),
            entry(5, storage()),
        ],
    })
}

/// The kernel's text with the caller's rules in it.
fn text(options: &Options, most_groups: u32) -> String {
    // exactly this float
    let float = |v: f32| format!("bitcast<f32>({:#x}u)", v.to_bits());
    let mut rules = String::new();
    for (index, class) in options.classes.iter().enumerate() {
        let condition = match &class.rule {
            Rule::MaxBelow(v) => format!("hi < {}", float(*v)),
            Rule::MinAbove(v) => format!("lo > {}", float(*v)),
            Rule::RangeBelow(v) => format!("hi - lo < {}", float(*v)),
            Rule::Wgsl(condition) => condition.clone(),
            Rule::Rest => continue,
        };
        // writing to a string cannot fail
        let _ = writeln!(
            rules,
            "    if {condition} {{\n        return {index}u;\n    }}"
        );
    }
    let constants = format!(
        "const TILE: u32 = {}u;\nconst CLASSES: u32 = {}u;\nconst REPLICATE: u32 = {}u;\nconst MOST_GROUPS: u32 = {most_groups}u;\n\
         const HEADER: u32 = {HEADER}u;\nconst NEIGHBOURHOOD: bool = {};",
        options.tile,
        options.classes.len(),
        options.replicate(),
        options.neighbourhood,
    );
    TEXT.replace("//!CONSTANTS", &constants)
        .replace("//!USER", &options.functions)
        .replace("//!MEASURE", &format!("    return {};", options.measure))
        .replace("//!RULES\n", &rules)
}

/// Parses and validates the text: what is wrong in it is the caller's.
fn parse(text: &str) -> Result<naga::Module, ClassifyError> {
    let module = naga::front::wgsl::parse_str(text)
        .map_err(|error| ClassifyError::Wgsl(error.emit_to_string(text)))?;
    let mut validator = naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::all(),
    );
    validator
        .validate(&module)
        .map_err(|error| ClassifyError::Wgsl(error.emit_to_string(text)))?;
    Ok(module)
}
