//! A page that runs it live: the original and the rewritten shader in the browser's own WebGPU, with nothing else to load.
//!
//! *Does*: writes one HTML file that holds the scene's WGSL, the rewritten WGSL, the kernels of the analysis and of the builder as
//! WGSL, and the words of their parameters, all made here; the page's script only binds and dispatches. *Guarantees*: the page
//! proves the laws on the browser's own compiler and driver, as soon as the first picture shows, with an oracle of its own. *Needs*: a
//! browser with WebGPU, default limits; where it is not there, the page says so, and what to do.

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use serde_json::{Value, json};
use vrcs_passes::{
    Entries, Options, Source, emit, input,
    instrument::{self, Shape},
    manifest,
    options::{FullTiles, Mode},
};

use crate::{
    Rate,
    analyse::{
        Frame, Settings, params,
        settings::{Content, Stability},
    },
    build::{self, BuildOptions, CoordLayout, primary::Order},
    kernel::{self, shader},
    plan::{Binding, Plan, PlanError, Scene},
    sri::SriLayout,
    view,
};

const PAGE: &str = include_str!("page.html");
const SCRIPT: &str = include_str!("page.js");

/// The thresholds that the page's slider has: the paper's t from 0 to 0.30.
const THRESHOLDS: u32 = 31;

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WebError {
    /// The shader is not valid, or cannot be rewritten, or not for a page. The text points into it.
    #[error("{0}")]
    Shader(String),
    /// The plan cannot be.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// The page for a shader that stores a picture: `@group(0) @binding(0)` is a uniform of width, height and seconds, `@binding(1)` a
/// storage texture of `rgba8unorm`, as in `shaders/plaza.wgsl`.
///
/// # Errors
/// If the shader is not valid or is refused.
pub fn page(source: &Source, entry: &str, size: [u32; 2]) -> Result<String, WebError> {
    let data = json!({
        "size": size,
        "scene": scene(source, entry, size)?,
        "build": builder(size)?,
        "analyse": analysis(size)?,
    });
    // in a script, `</` would end it
    let data = data.to_string().replace("</", "<\\/");
    Ok(PAGE
        .replace("/*SCRIPT*/", SCRIPT)
        .replace("/*DATA*/null", &data))
}

/// How the page's coordinates are built: in one buffer, rates to 2×2.
fn options() -> BuildOptions {
    BuildOptions {
        modes: build::Modes::NONE.with(Mode::Tiled),
        ..BuildOptions::default()
    }
}

fn scene(source: &Source, entry: &str, size: [u32; 2]) -> Result<Value, WebError> {
    let (module, info) =
        input::wgsl(source).map_err(|invalid| WebError::Shader(invalid.rendered))?;
    let rewrite = Options {
        mode: Mode::Tiled,
        ..Options::default()
    };
    let rewritten = vrcs_passes::rewrite(&module, &info, Entries::Named(entry), &rewrite)
        .map_err(|refusal| WebError::Shader(refusal.render(source, vrcs_passes::Color::Never)))?;
    let text = emit::wgsl(&rewritten.module, &rewritten.info)
        .map_err(|error| WebError::Shader(error.to_string()))?;
    let Some(manifest) = rewritten.manifest.entries.first() else {
        unreachable!("a rewrite without a refusal has an entry");
    };
    let counted = json!({
        "original": counting(&module, &info, entry, size)?,
        "rewritten": counting(&rewritten.module, &rewritten.info, entry, size)?,
    });
    let group_size = fixed_size(manifest)?;
    let extent = [size[0], size[1], 1];
    let params = view::Params::new(extent, true, group_size, Mode::Tiled, size, &options());
    let original_groups = [0, 1].map(|axis| size[axis].div_ceil(group_size[axis].max(1)));
    let bindings: Vec<[u32; 2]> = manifest
        .bindings
        .iter()
        .map(|binding| [binding.group, binding.binding])
        .collect();
    Ok(json!({
        "entry": entry,
        "original": source.text(),
        "original_groups": original_groups,
        "rewritten": text,
        "groups": manifest.groups_for(extent, group_size),
        "bindings": bindings,
        "params": words(bytemuck::bytes_of(&params)),
        "counted": counted,
    }))
}

/// A build that counts the stores to each pixel, for the law of the partition.
fn counting(
    module: &naga::Module,
    info: &ModuleInfo,
    entry: &str,
    size: [u32; 2],
) -> Result<Value, WebError> {
    let own = |why: String| WebError::Shader(format!("the build that counts stores: {why}"));
    let mut entries = module.entry_points.iter();
    let index = entries.position(|point| point.name == entry);
    let index = index.ok_or_else(|| own(format!("there is no `{entry}`")))?;
    for (_, global) in module.global_variables.iter() {
        let is_buffer = matches!(global.space, naga::AddressSpace::Storage { access } if access.contains(naga::StorageAccess::STORE));
        if is_buffer {
            return Err(own("the page has no storage buffers to write".to_owned()));
        }
    }
    let shape = |_| Some(Shape::Texture([size[0], size[1], 1]));
    let counted = instrument::count_stores(module, info, index, &shape, &|_| 0);
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&counted.module)
        .map_err(|error| own(error.to_string()))?;
    let text = emit::wgsl(&counted.module, &info).map_err(|error| own(error.to_string()))?;
    Ok(json!({
        "text": text,
        "binding": [counted.binding.group, counted.binding.binding],
    }))
}

fn fixed_size(manifest: &manifest::Entry) -> Result<[u32; 3], WebError> {
    match manifest.original_workgroup_size {
        [Some(x), Some(y), Some(z)] => Ok([x, y, z]),
        _ => Err(WebError::Shader(format!(
            "the workgroup size of `{}` is an `override`: the page has no values for it",
            manifest.name
        ))),
    }
}

fn builder(size: [u32; 2]) -> Result<Value, WebError> {
    let options = options();
    let layout = CoordLayout::new(size, &options);
    let sri = SriLayout::new(size[0], size[1]);
    let params = build::gpu::params(&options, [size[0], size[1], 1], Order::Fixed);
    Ok(json!({
        "text": text(build::gpu::kernel(&options), &build::gpu::defs(&options))?,
        "entry": "build",
        "groups": build::gpu::groups(&options, size),
        "words": layout.words(),
        "params": words(&params),
        "tile": options.tile,
        // a tile with more primaries is shaded whole: the oracle's rule, too
        "full": match options.full_tiles {
            FullTiles::Promote => options.full(),
            FullTiles::Keep => options.area(),
        },
        "sri": { "width": sri.width, "height": sri.height, "pitch": sri.pitch },
        "rates": Rate::ALL
            .into_iter()
            .filter(|rate| rate.is_within(options.largest))
            .map(|rate| json!({
                "name": rate.to_string(), "code": rate.code(), "size": [rate.width(), rate.height()],
            }))
            .collect::<Vec<_>>(),
    }))
}

fn analysis(size: [u32; 2]) -> Result<Value, WebError> {
    let settings = |threshold: f64| Settings {
        content: Content {
            threshold,
            ..Content::default()
        },
        stability: Stability::None,
        ..Settings::default()
    };
    let plan = Plan::new(&Scene::default(), &settings(0.1))?;
    let frame = Frame::of_size(size);
    let thresholds: Vec<Value> = (0..THRESHOLDS)
        .map(|step| {
            let t = f64::from(step) / 100.0;
            let settings = settings(t);
            let params = params::Params::new(&settings, &frame);
            json!({
                "t": t,
                "params": words(bytemuck::bytes_of(&params)),
            })
        })
        .collect();
    let index = |binding: Binding| binding.index();
    Ok(json!({
        "text": text(shader!("analyse.wgsl"), &plan.defs())?,
        "entry": "analyse",
        "groups": [size[0].div_ceil(plan.tile()[0]), size[1].div_ceil(plan.tile()[1])],
        "bindings": {
            "params": index(Binding::Params),
            "tables": index(Binding::Tables),
            "rates": index(Binding::Rates),
            "colour": index(Binding::Colour),
        },
        "tables": params::tables(&plan.settings, false, frame.resolution_scale),
        "thresholds": thresholds,
    }))
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes
        .chunks_exact(4)
        .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
        .collect()
}

/// A kernel of ours as WGSL that stands alone.
fn text(source: kernel::Source, defs: kernel::Defs) -> Result<String, WebError> {
    let module = kernel::compose(source, defs);
    let own = |why: String| WebError::Shader(format!("{}: {why}", source.name));
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .map_err(|error| own(error.to_string()))?;
    naga::back::wgsl::write_string(&module, &info, naga::back::wgsl::WriterFlags::empty())
        .map_err(|error| own(error.to_string()))
}
