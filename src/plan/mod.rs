//! The plan: which passes, kernels and bindings the analysis has, from what the scene has and what is asked for.
//!
//! *Guarantees*: what is not called for is not there: not compiled, not bound, not dispatched. *Refuses*: settings that call for
//! what the scene has not.
//!
//! - `scene`: what a scene may declare, and what is bound for it;
//! - `refusals`: what settings need of a scene, and why there may be no plan;
//! - `effects`: what is compiled into which kernel;
//! - here: the passes, in order.

mod effects;
mod refusals;
mod scene;
#[cfg(test)]
mod tests;

use std::fmt;

use crate::{
    analyse::{
        half::HalfResolution,
        own::OwnRates,
        settings::{Granularity, Settings, Smoothing},
    },
    kernel::{self, shader},
};

use effects::{
    LINES, effects, effects_of_attachment, has_attachment_of_its_own, is_by_lines, own_pass,
};
use refusals::refuse;

pub(crate) use effects::REGION;
pub use refusals::{MOST_STORAGE_BUFFERS, PlanError};
pub use scene::{Binding, ColourForm, Scene};

/// A compute pass of the analysis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannedPass {
    /// The kernel's file.
    pub kernel: &'static str,
    /// What is compiled into it.
    pub effects: Vec<&'static str>,
    /// The number of its bindings.
    pub bindings: usize,
}

/// What is compiled, bound and dispatched.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The scene.
    pub scene: Scene,
    /// The settings.
    pub settings: Settings,
    /// The passes, in order.
    pub passes: Vec<PlannedPass>,
    /// The first pass's bindings, in order.
    pub bindings: Vec<Binding>,
    /// What passes after the first bind beside its bindings.
    pub later: Vec<Binding>,
}

impl Plan {
    /// Plans the analysis.
    ///
    /// # Errors
    /// If the settings call for what the scene has not.
    pub fn new(scene: &Scene, settings: &Settings) -> Result<Plan, PlanError> {
        refuse(scene, settings)?;
        let effects = effects(scene, settings);
        let bindings = bindings(scene, settings, &effects);
        let (passes, mut later) = passes(scene, settings, &bindings, effects);
        later.retain(|binding| !bindings.contains(binding));
        let plan = Plan {
            scene: *scene,
            settings: settings.clone(),
            passes,
            bindings,
            later,
        };
        plan.within(MOST_STORAGE_BUFFERS)?;
        Ok(plan)
    }

    /// Whether the rates are made by the kernel that has room for √luma's content alone.
    pub(crate) fn is_by_lines(&self) -> bool {
        self.passes[0].kernel == LINES
    }

    /// The kernel of rates of quads by pixels.
    pub(crate) fn kernel(&self) -> kernel::Source {
        match self.is_by_lines() {
            true => shader!("luma_lines.wgsl"),
            false => shader!("analyse.wgsl"),
        }
    }

    /// Whether the attachment is made by a pass of its own.
    pub(crate) fn has_attachment_of_its_own(&self) -> bool {
        has_attachment_of_its_own(&self.scene, &self.settings)
    }

    /// The pass of a kernel.
    pub(crate) fn pass(&self, kernel: &str) -> Option<&PlannedPass> {
        self.passes.iter().find(|pass| pass.kernel == kernel)
    }

    /// Whether a device that binds so many storage buffers to a stage can run it; [`new`](Plan::new) has asked for
    /// [`MOST_STORAGE_BUFFERS`].
    ///
    /// # Errors
    /// If the plan binds more.
    pub fn within(&self, most: u32) -> Result<(), PlanError> {
        let buffers = self
            .bindings
            .iter()
            .filter(|b| b.is_storage_buffer(self.scene.colour));
        let names: Vec<&str> = buffers.map(|binding| binding.name()).collect();
        match names.len() as u32 <= most {
            true => Ok(()),
            false => Err(PlanError::TooManyBuffers { names, most }),
        }
    }

    /// As JSON.
    pub fn to_json(&self) -> serde_json::Value {
        let passes: Vec<serde_json::Value> = self
            .passes
            .iter()
            .map(|pass| serde_json::json!({ "kernel": pass.kernel, "effects": pass.effects, "bindings": pass.bindings }))
            .collect();
        let bindings: Vec<serde_json::Value> = self
            .bindings
            .iter()
            .map(|binding| serde_json::json!({ "index": binding.index(), "name": binding.name() }))
            .collect();
        let later: Vec<&str> = self.later.iter().map(|binding| binding.name()).collect();
        serde_json::json!({ "passes": passes, "bindings": bindings, "later": later })
    }
}

/// What the first pass binds, in order.
fn bindings(scene: &Scene, settings: &Settings, effects: &[&'static str]) -> Vec<Binding> {
    let has = |name: &str| effects.contains(&name);
    let is_by_tiles = settings.is_by_tiles();
    Binding::ALL
        .into_iter()
        .filter(|binding| match binding {
            Binding::Params | Binding::Tables | Binding::Rates | Binding::Colour => true,
            Binding::After => has("TRANSPARENTS"),
            Binding::Attachment => scene.attachment,
            Binding::Reasons => has("REASONS"),
            Binding::Motion => has("VECTORS"),
            Binding::Depth => has("DEPTH") || has("CAMERA") || has("LENS"),
            Binding::PreviousDepth => has("DEPTH"),
            Binding::Optics => has("CAMERA") || has("LENS"),
            Binding::TileData => is_by_tiles,
            Binding::PlainRates => has("PLAIN"),
            Binding::PreviousRates => has("PREVIOUS_RATES"),
            Binding::Materials => has("MATERIALS"),
            Binding::Noise => has("NOISE"),
            Binding::Flags => has("FLAGS"),
            Binding::SqrtLuma => has("WRITE_LUMA"),
            Binding::Blur => has("BLUR"),
            Binding::Ids | Binding::HalfRates => false,
        })
        .collect()
}

/// The passes, in order, and what those after the first bind.
fn passes(
    scene: &Scene,
    settings: &Settings,
    bindings: &[Binding],
    effects: Vec<&'static str>,
) -> (Vec<PlannedPass>, Vec<Binding>) {
    let own = settings.own.clone().unwrap_or_default();
    let is_by_tiles = settings.is_by_tiles();
    let mut passes = vec![PlannedPass {
        kernel: match (is_by_tiles, settings.granularity) {
            (true, _) => "tile_rates.wgsl",
            (false, Granularity::Quad) if is_by_lines(&effects, settings) => LINES,
            (false, Granularity::Quad) => "analyse.wgsl",
            (false, _) => "tiles.wgsl",
        },
        bindings: bindings.len(),
        effects,
    }];
    if is_by_tiles {
        // its data first; one group serves both
        let mut data = passes[0].clone();
        data.kernel = "tile_data.wgsl";
        passes.insert(0, data);
    }
    if has_attachment_of_its_own(scene, settings) {
        // by tiles beside quads; the same group
        passes.push(PlannedPass {
            kernel: "tiles.wgsl",
            bindings: bindings.len(),
            effects: effects_of_attachment(&passes[0].effects, settings),
        });
    }
    if passes[0].effects.contains(&"WRITE_LUMA") {
        let mut luma = passes[0].clone();
        luma.kernel = "write_luma.wgsl";
        passes.push(luma);
    }
    let smooth = |effect| {
        let mut effects = vec![effect];
        effects.extend(scene.reasons.then_some("REASONS"));
        PlannedPass {
            kernel: "smooth.wgsl",
            bindings: 3 + usize::from(scene.reasons),
            effects,
        }
    };
    match settings.smoothing {
        Smoothing::None => {}
        Smoothing::Limit => passes.push(smooth("LIMIT")),
        Smoothing::Conservative => passes.push(smooth("CONSERVATIVE")),
    }
    let mut later = Vec::new();
    // a stage by tiles looks at no flags itself
    if own != OwnRates::default() || is_by_tiles && scene.flags {
        let (pass, bound) = own_pass(scene, &own);
        passes.push(pass);
        later.extend(bound);
    }
    if let Some(kind) = settings.half_resolution {
        passes.push(PlannedPass {
            kernel: "half.wgsl",
            effects: match kind {
                HalfResolution::Code => Vec::new(),
                HalfResolution::Footprint => vec!["FOOTPRINT"],
            },
            bindings: 3,
        });
        later.push(Binding::HalfRates);
    }
    (passes, later)
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, pass) in self.passes.iter().enumerate() {
            writeln!(
                f,
                "pass {}: {}, {} bindings",
                index + 1,
                pass.kernel,
                pass.bindings
            )?;
            writeln!(
                f,
                "  compiled in: {}",
                pass.effects.join(", ").to_lowercase()
            )?;
        }
        for binding in &self.bindings {
            writeln!(f, "  @binding({}) {}", binding.index(), binding.name())?;
        }
        for binding in &self.later {
            writeln!(f, "  later: {}", binding.name())?;
        }
        Ok(())
    }
}
