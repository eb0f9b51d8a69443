//! Tile classification on the GPU: `shaders/classify.wgsl` with the caller's rules in it, recorded into the caller's encoder.

use std::fmt::Write;

use bytemuck::{Pod, Zeroable};

use super::{ClassifyError, MOST_CLASSES, Options, Rule};
use crate::{home::Home, kernel, limits::Needs, object::ObjectOptions, scope};

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
    home: Home,
    label: String,
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
    home: Home,
    label: String,
    /// Of how many classes there are lists, and bind groups that a dispatch may use.
    classes: usize,
    most_bind_groups: u32,
    /// The tiles of the extent; none until it is set.
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
    /// If the options contradict themselves, what they say in WGSL does not compile, or the device has too little.
    pub fn new(device: &wgpu::Device, options: Options) -> Result<Classifier, ClassifyError> {
        Classifier::with(device, options, &ObjectOptions::default())
    }

    /// The same, with a name for captures and the caller's cache of pipelines.
    ///
    /// # Errors
    /// As [`Classifier::new`].
    pub fn with(
        device: &wgpu::Device,
        options: Options,
        objects: &ObjectOptions,
    ) -> Result<Classifier, ClassifyError> {
        options.check()?;
        let most_groups = device
            .limits()
            .max_compute_workgroups_per_dimension
            .min(65_535);
        let text = text(&options, most_groups);
        let module = parse(&text)?;
        Needs::of_kernel(&module).check(device, "the kernel `classify.wgsl`")?;
        let label = objects.name("classify");
        // the caller's rules are in it: what wgpu's own check of features has against them comes back
        scope::caught(device, || {
            let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(&label),
                source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
            });
            let layout = layout(device);
            let pipeline = |entry| {
                let zeroed = wgpu::PipelineCompilationOptions::default();
                kernel::pipeline(device, &layout, &shader, entry, zeroed, objects)
            };
            Classifier {
                reduce: pipeline("reduce_tiles"),
                sort: options.neighbourhood.then(|| pipeline("sort_tiles")),
                kick: pipeline("kick"),
                lists_layout: Classifier::lists_layout(device),
                layout,
                most_groups,
                options,
                home: Home::of(device),
                label: label.clone(),
            }
        })
        .map_err(|error| ClassifyError::Refused(scope::in_words(&error)))
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
        classes.position(|class| class.name == name).ok_or_else(|| {
            let classes = self.options.classes.iter();
            let names = classes.map(|class| class.name.clone()).collect();
            ClassifyError::NoClass(name.to_owned(), names)
        })
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

    /// Makes lists for a texture of floats that shaders may read. [`Classifier::set_extent`] has to follow.
    ///
    /// # Errors
    /// If the device is another than the classifier's, the texture has more tiles than it dispatches, or wgpu does not bind the texture.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        source: &wgpu::TextureView,
    ) -> Result<Lists, ClassifyError> {
        if self.home != Home::of(device) {
            return Err(ClassifyError::Device);
        }
        let room = [source.texture().width(), source.texture().height()];
        let tiles = self.options.tiles(room);
        if tiles.iter().any(|&tiles| tiles > self.most_groups) {
            return Err(ClassifyError::Extent(format!(
                "the texture has {}x{} tiles; the device dispatches at most {} on an axis: choose larger tiles",
                tiles[0], tiles[1], self.most_groups
            )));
        }
        scope::caught(device, || self.bound(device, source, room))
            .map_err(|error| ClassifyError::Refused(scope::in_words(&error)))
    }

    fn bound(&self, device: &wgpu::Device, source: &wgpu::TextureView, room: [u32; 2]) -> Lists {
        let tiles = self.options.tiles(room);
        let count = u64::from(tiles[0]) * u64::from(tiles[1]);
        let make = |part, words: u64, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(&format!("{} {part}", self.label)),
                size: words.max(1) * 4,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        let params = make("params", 4, Usage::UNIFORM | Usage::COPY_DST);
        let classes = self.options.classes.len();
        let bounds = match self.sort {
            Some(_) => count * 2,
            None => 2,
        };
        let bounds = make("tile bounds", bounds, Usage::STORAGE);
        let lists = make(
            "tile lists",
            u64::from(HEADER) + classes as u64 * count,
            Usage::STORAGE | Usage::COPY_SRC,
        );
        let counters = make("tile counters", MOST_CLASSES as u64, Usage::STORAGE);
        let arguments = make(
            "tile arguments",
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
            label: Some(&self.label),
            layout: &self.layout,
            entries: &entries,
        });
        let shading = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&format!("{} tile lists", self.label)),
            layout: &self.lists_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: lists.as_entire_binding(),
            }],
        });
        Lists {
            home: self.home.clone(),
            label: self.label.clone(),
            classes,
            most_bind_groups: device.limits().max_bind_groups,
            tiles: [0, 0],
            room,
            params,
            arguments,
            lists,
            group,
            shading,
        }
    }

    /// Sets the extent of the picture for dispatches that are submitted from now on.
    ///
    /// # Errors
    /// If it is empty, the texture is smaller, or the lists are another classifier's.
    pub fn set_extent(
        &self,
        queue: &wgpu::Queue,
        lists: &mut Lists,
        extent: [u32; 2],
    ) -> Result<(), ClassifyError> {
        self.check(lists)?;
        if extent.contains(&0) {
            return Err(ClassifyError::Extent(format!(
                "an extent of {}x{} has no pixels",
                extent[0], extent[1]
            )));
        }
        if extent[0] > lists.room[0] || extent[1] > lists.room[1] {
            return Err(ClassifyError::Extent(format!(
                "an extent of {}x{} in a texture of {}x{}: bind the texture that was made for it",
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

    /// Whether lists were made by this classifier, or one with as many classes on its device.
    fn check(&self, lists: &Lists) -> Result<(), ClassifyError> {
        if self.home != lists.home {
            return Err(ClassifyError::Device);
        }
        match lists.classes == self.options.classes.len() {
            true => Ok(()),
            false => Err(ClassifyError::OtherLists),
        }
    }

    fn ready(&self, lists: &Lists) -> Result<(), ClassifyError> {
        self.check(lists)?;
        match lists.tiles[0] {
            0 => Err(ClassifyError::NoExtent),
            _ => Ok(()),
        }
    }

    /// Records the classification, with a pass of its own.
    ///
    /// # Errors
    /// If no extent was set, or the lists are another classifier's; nothing is recorded then.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        lists: &Lists,
    ) -> Result<(), ClassifyError> {
        self.ready(lists)?;
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(&self.label),
            timestamp_writes: None,
        });
        self.record_in(&mut pass, lists)
    }

    /// Records the classification into a compute pass of the caller's. Sets pipelines and bind group 0.
    ///
    /// # Errors
    /// As [`Classifier::record`].
    pub fn record_in(
        &self,
        pass: &mut wgpu::ComputePass,
        lists: &Lists,
    ) -> Result<(), ClassifyError> {
        let _span = tracing::trace_span!("vrcs classify").entered();
        self.ready(lists)?;
        let [x, y] = lists.tiles;
        pass.push_debug_group(&self.label);
        pass.set_bind_group(0, &lists.group, &[]);
        pass.set_pipeline(&self.reduce);
        pass.dispatch_workgroups(x, y, 1);
        if let Some(sort) = &self.sort {
            pass.set_pipeline(sort);
            pass.dispatch_workgroups(x.div_ceil(8), y.div_ceil(8), 1);
        }
        pass.set_pipeline(&self.kick);
        pass.dispatch_workgroups(1, 1, 1);
        pass.pop_debug_group();
        Ok(())
    }
}

impl Lists {
    /// Records the dispatch of a class, by its [index](Classifier::class). The caller has set the class's pipeline and its own bind
    /// groups; the lists become bind group `group`. There are as many workgroups as the class has blocks; nothing happens if it has
    /// none.
    ///
    /// # Errors
    /// If there is no such class, the device has no such bind group, or no extent was set; nothing is recorded then.
    pub fn dispatch(
        &self,
        pass: &mut wgpu::ComputePass,
        class: usize,
        group: u32,
    ) -> Result<(), ClassifyError> {
        if class >= self.classes {
            return Err(ClassifyError::NoClassAt {
                index: class,
                classes: self.classes,
            });
        }
        if group >= self.most_bind_groups {
            return Err(ClassifyError::NoGroup {
                group,
                most: self.most_bind_groups,
            });
        }
        if self.tiles[0] == 0 {
            return Err(ClassifyError::NoExtent);
        }
        pass.push_debug_group(&self.label);
        pass.set_bind_group(group, &self.shading, &[]);
        pass.dispatch_workgroups_indirect(&self.arguments, class as u64 * 12);
        pass.pop_debug_group();
        Ok(())
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
