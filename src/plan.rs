//! The plan: which passes, kernels and bindings the analysis has, from what the scene has and what is asked for.
//!
//! *Guarantees*: what is not called for is not there: not compiled, not bound, not dispatched. *Refuses*: settings that call for
//! what the scene has not.

use std::fmt;

use crate::{
    Rate,
    analyse::{
        half::HalfResolution,
        integer::count,
        own::OwnRates,
        params::has_fixed_limits,
        settings::{
            Blur, Content, Difference, Form, Granularity, Norm, Pairs, Settings, Smoothing,
            Stability, Weights,
        },
        tiles::SIDE,
    },
    kernel::{self, shader},
};

/// The form in which the previous picture is had.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColourForm {
    /// A texture of 8-bit codes, viewed without sRGB decoding.
    #[default]
    Codes,
    /// A texture of linear light, 16 or 32 bits a channel.
    Linear,
    /// A buffer of √luma: four pixels to a word, rows padded to 256 bytes.
    SqrtLuma,
}

/// What the renderer has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Scene {
    /// The previous picture.
    pub colour: ColourForm,
    /// The same after transparents.
    pub after_transparents: bool,
    /// Motion vectors of this frame.
    pub motion: bool,
    /// Depth of this frame and the previous.
    pub depth: bool,
    /// The matrices of both frames' cameras, for a scene that has depth and no motion vectors.
    pub cameras: bool,
    /// The previous frame's rates.
    pub previous_rates: bool,
    /// Smoothness and Rf0, of the frame that [`Materials::of`](crate::analyse::settings::Materials::of) says.
    pub materials: bool,
    /// A mask of where noise is.
    pub noise: bool,
    /// Ids of materials or objects.
    pub ids: bool,
    /// Flags of pixels.
    pub flags: bool,
    /// Widths of a later blur.
    pub blur: bool,
    /// Whether rates for a hardware attachment are wanted: of the tiles of [`Settings::attachment`].
    pub attachment: bool,
    /// Whether rates without the extra half rate are wanted as well, for passes that add no noise.
    pub plain_rates: bool,
    /// Whether reasons are wanted.
    pub reasons: bool,
    /// Whether the previous picture's √luma is wanted, for later frames to use instead of its colour. A deblocker that
    /// writes it already makes this needless; so does a scene that has it.
    pub sqrt_luma: bool,
    /// Whether the pictures hold more than the view, which then has an [origin](crate::analyse::Frame::origin) in them: of a split
    /// screen, say.
    pub origin: bool,
}

/// A binding of the analysis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Binding {
    /// Parameters, a uniform buffer.
    Params,
    /// Tables, a storage buffer.
    Tables,
    /// The rates, written.
    Rates,
    /// The previous picture.
    Colour,
    /// The same after transparents.
    After,
    /// The attachment's rates, written.
    Attachment,
    /// Reasons, written.
    Reasons,
    /// Motion vectors.
    Motion,
    /// Depth.
    Depth,
    /// The previous depth.
    PreviousDepth,
    /// The previous rates.
    PreviousRates,
    /// Smoothness and Rf0.
    Materials,
    /// The noise mask.
    Noise,
    /// Flags.
    Flags,
    /// √luma, written.
    SqrtLuma,
    /// Widths of a later blur.
    Blur,
    /// Ids of materials or objects.
    Ids,
    /// The rates of half the resolution, written.
    HalfRates,
    /// Camera and lens, a uniform buffer.
    Optics,
    /// What the previous picture's tiles tell, a storage buffer of [`tiles::data_bytes`](crate::analyse::tiles::data_bytes) that is
    /// written and read here.
    TileData,
    /// The rates without the extra half rate, written.
    PlainRates,
}

impl Binding {
    const ALL: [Binding; 21] = [
        Binding::Params,
        Binding::Tables,
        Binding::Rates,
        Binding::Colour,
        Binding::After,
        Binding::Attachment,
        Binding::Reasons,
        Binding::Motion,
        Binding::Depth,
        Binding::PreviousDepth,
        Binding::PreviousRates,
        Binding::Materials,
        Binding::Noise,
        Binding::Flags,
        Binding::SqrtLuma,
        Binding::Blur,
        Binding::Ids,
        Binding::HalfRates,
        Binding::Optics,
        Binding::TileData,
        Binding::PlainRates,
    ];

    /// Its index in the kernel's group.
    pub fn index(self) -> u32 {
        self as u32
    }

    /// Whether it is a storage buffer, given the form of the colour.
    pub fn is_storage_buffer(self, colour: ColourForm) -> bool {
        match self {
            Binding::Tables
            | Binding::Rates
            | Binding::Attachment
            | Binding::Reasons
            | Binding::PreviousRates
            | Binding::HalfRates
            | Binding::TileData
            | Binding::PlainRates
            | Binding::SqrtLuma => true,
            Binding::Colour | Binding::After => colour == ColourForm::SqrtLuma,
            _ => false,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Binding::Params => "parameters",
            Binding::Tables => "tables",
            Binding::Rates => "rates",
            Binding::Colour => "colour",
            Binding::After => "colour after transparents",
            Binding::Attachment => "attachment rates",
            Binding::Reasons => "reasons",
            Binding::Motion => "motion vectors",
            Binding::Depth => "depth",
            Binding::PreviousDepth => "previous depth",
            Binding::PreviousRates => "previous rates",
            Binding::Materials => "materials",
            Binding::Noise => "noise mask",
            Binding::Flags => "flags",
            Binding::SqrtLuma => "√luma",
            Binding::Blur => "later blur",
            Binding::Ids => "ids",
            Binding::HalfRates => "rates of half the resolution",
            Binding::Optics => "camera and lens",
            Binding::TileData => "data of tiles",
            Binding::PlainRates => "rates without the extra half rate",
        }
    }
}

/// The pixels that a workgroup of the kernels of tiles makes.
pub(crate) const REGION: [u32; 2] = [32; 2];

/// Storage buffers that wgpu's default limits let a stage bind, `max_storage_buffers_per_shader_stage`.
pub const MOST_STORAGE_BUFFERS: u32 = 8;

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// Settings that call for what the scene has not.
    #[error("{effect} needs {what}, which the scene does not declare")]
    Missing {
        /// The effect.
        effect: &'static str,
        /// What it needs.
        what: &'static str,
    },
    /// An effect that a stage by tiles has not.
    #[error(
        "{0} cannot be had where the previous picture is fetched by tiles of 16x16 pixels: fetch it by pixel (Fetch::Pixel)"
    )]
    ByTiles(&'static str),
    /// An effect that changes how much of the content's error is tolerated, where motion alone decides.
    #[error(
        "{0} changes how much of the content's error is tolerated, and here motion alone decides, whatever the content \
         (Blur::Standalone, Blur::Ladder): leave one of the two out"
    )]
    MotionAlone(&'static str),
    /// Tiles move by cameras and depth, not by vectors.
    #[error(
        "a stage by tiles moves them by depth and cameras; the scene declares motion vectors, which it would not look at"
    )]
    TilesOfVectors,
    /// More storage buffers than a device binds.
    #[error(
        "the plan binds {} storage buffers ({}), and a stage binds {most}; leave out an output that is not used",
        .names.len(), .names.join(", ")
    )]
    TooManyBuffers {
        /// Which.
        names: Vec<&'static str>,
        /// How many a device binds.
        most: u32,
    },
}

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
        let own = settings.own.clone().unwrap_or_default();
        let has_motion = scene.motion || scene.cameras && scene.depth;
        let is_scaled = matches!(
            settings.motion,
            Some(motion) if matches!(motion.blur, Blur::Scaled | Blur::Linear)
        );
        let needs = [
            (
                settings.motion.is_some(),
                has_motion,
                "motion-adaptive shading",
                "motion vectors, or depth and cameras",
            ),
            (
                settings.later_blur,
                scene.blur && is_scaled,
                "a later blur",
                "its width and motion-adaptive shading by the scalers",
            ),
            (
                settings.lens.is_some(),
                scene.depth && is_scaled,
                "a lens",
                "depth and motion-adaptive shading by the scalers",
            ),
            (
                settings.reprojection.is_some(),
                has_motion && settings.motion.is_some(),
                "reprojection",
                "motion vectors",
            ),
            (
                settings.materials.is_some(),
                scene.materials,
                "material sensitivity",
                "materials",
            ),
            (
                settings.transparents,
                scene.after_transparents,
                "transparents",
                "the colour after transparents",
            ),
            (
                settings.stability != Stability::None,
                scene.previous_rates,
                "stability",
                "the previous frame's rates",
            ),
            (
                settings.half_rate.is_some_and(|half| half.fast.is_finite()),
                settings.motion.is_some(),
                "an extra half rate that is left out in fast motion",
                "motion-adaptive shading",
            ),
            (
                scene.plain_rates,
                settings.half_rate.is_some(),
                "a second image of rates",
                "the extra half rate, without which it would be the first",
            ),
            (own.ids.is_some(), scene.ids, "rates by id", "ids"),
            (
                own.distance.is_some(),
                scene.depth,
                "rates by distance",
                "depth",
            ),
            (
                own.particles.is_some(),
                scene.flags,
                "rates of particles",
                "flags",
            ),
        ];
        if let Some((_, _, effect, what)) = needs.into_iter().find(|&(on, had, ..)| on && !had) {
            return Err(PlanError::Missing { effect, what });
        }
        let is_by_tiles = settings.is_by_tiles();
        if let (true, Some(effect)) = (is_by_tiles, settings.first_by_pixel()) {
            return Err(PlanError::ByTiles(effect));
        }
        if let (true, Some(effect)) = (settings.is_by_motion_alone(), settings.first_of_content()) {
            return Err(PlanError::MotionAlone(effect));
        }
        if is_by_tiles && scene.motion {
            return Err(PlanError::TilesOfVectors);
        }
        let effects = effects(scene, settings);
        let has = |name: &str| effects.contains(&name);
        let bindings: Vec<Binding> = Binding::ALL
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
            .collect();
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
    fn is_by_lines(&self) -> bool {
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

    /// The definitions of the first kernel.
    pub(crate) fn defs(&self) -> Vec<(&'static str, u32)> {
        let side = self.settings.granularity_of_rates();
        self.defs_with(&self.passes[0].effects, side)
    }

    /// The definitions of the kernel that makes the attachment alone.
    pub(crate) fn defs_of_attachment(&self) -> Vec<(&'static str, u32)> {
        let effects = effects_of_attachment(&self.passes[0].effects, &self.settings);
        self.defs_with(&effects, self.settings.granularity_of_attachment())
    }

    fn defs_with(
        &self,
        effects: &[&'static str],
        granularity: Granularity,
    ) -> Vec<(&'static str, u32)> {
        let mut defs: Vec<(&'static str, u32)> = effects.iter().map(|&name| (name, 1)).collect();
        let content = &self.settings.content;
        let has = |name: &str| effects.contains(&name);
        let has_doubt = has("REPROJECTION") || self.scene.colour == ColourForm::Linear;
        let has_asides = has_doubt || has("MOTION");
        let has_shared_sums = has_shared_sums(effects, content);
        let is_by_lines = granularity == Granularity::Quad && self.is_by_lines();
        // √luma that is read where it lies
        let is_direct = has_shared_sums && has("SQRT_LUMA") && !has_doubt;
        let derived = [
            // the sums of four quads are made together
            ("SHARED_SUMS", has_shared_sums),
            ("DIRECT", is_direct),
            // pixels, or what squares of them have beside lumas, are shared in workgroup memory
            ("SHARED", has_asides || !is_direct),
            // a pixel may have no source, or no luma
            ("DOUBT", has_doubt),
            // a quad may be at full rate whatever its content
            ("FULL_RATES", has_doubt || has("FLAGS") || has("MATERIALS")),
            // squares of pixels have more than their lumas
            ("ASIDES", has_asides),
            (
                "LOCAL_TOLERANCE",
                has("SAFE_AREA") || has("FOVEATION") || has("MATERIALS"),
            ),
            ("OPTICS", has("CAMERA") || has("LENS")),
            ("DEPTH_NOW", has("DEPTH") || has("CAMERA") || has("LENS")),
            ("BLURRED", has("BLUR") || has("LENS")),
            ("FIXED_LIMITS", has_fixed_limits(&self.settings)),
            ("SQUARED", matches!(content.norm, Norm::L2 | Norm::Root)),
            // where a pixel was is asked for beside its colour
            ("PAST", has("PREVIOUS_RATES") || has("MATERIALS_BEFORE")),
            ("LINES", is_by_lines),
            (
                "QUARTERS",
                is_by_lines
                    && ![Rate::R1X1, Rate::R2X1, Rate::R1X2, Rate::R2X2]
                        .contains(&self.settings.largest),
            ),
        ];
        defs.extend(derived.iter().filter(|d| d.1).map(|&(name, _)| (name, 1)));
        defs.push(("PAIRS", count(content.pairs)));
        let [width, height] = match granularity {
            Granularity::Quad => self.tile(),
            // not their memory
            _ => [4; 2],
        };
        defs.push(("TILE_WIDTH", width));
        defs.push(("TILE_HEIGHT", height));
        defs.push(("PLANES", self.planes()));
        if granularity.is_tile() {
            defs.push(("SIDE", granularity.side()));
            let has_two = has("TRANSPARENTS");
            defs.push(("PICTURES", 1 + u32::from(has_two)));
        }
        defs
    }

    /// Halves of a word that workgroup memory holds for a pixel.
    fn planes(&self) -> u32 {
        let has = |name: &str| self.passes[0].effects.contains(&name);
        let channels = if has("CHANNELS") { 4 } else { 1 };
        channels * if has("TRANSPARENTS") { 2 } else { 1 }
    }

    /// The width and height of a workgroup's pixels: what fits into 16 KiB of workgroup memory and 256 invocations.
    pub(crate) fn tile(&self) -> [u32; 2] {
        if self.settings.is_by_tiles() {
            return [SIDE; 2];
        }
        if self.settings.granularity.is_tile() {
            return REGION;
        }
        if self.is_by_lines() {
            // a wave
            return [256, 8];
        }
        let height = match self.planes() {
            1 | 2 => 16,
            4 => 8,
            _ => 4,
        };
        [128, height]
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

/// Whether the attachment's rates are of tiles and the others of quads.
fn has_attachment_of_its_own(scene: &Scene, settings: &Settings) -> bool {
    scene.attachment
        && settings.granularity_of_rates() == Granularity::Quad
        && settings.attachment.is_tile()
}

/// What is compiled into the kernel that makes the attachment alone, given what is compiled into the first: no extra half rate, and none
/// of the other outputs.
fn effects_of_attachment(first: &[&'static str], settings: &Settings) -> Vec<&'static str> {
    let others = ["HALF_RATE", "NOISE", "PLAIN", "REASONS", "WRITE_LUMA"];
    let kept = first.iter().copied().filter(|name| !others.contains(name));
    kept.chain(["ATTACHMENT", "ATTACHMENT_ALONE"])
        .chain(name_of(settings.granularity_of_attachment()))
        .collect()
}

/// The pass of the application's own rates, and what it binds.
fn own_pass(scene: &Scene, own: &OwnRates) -> (PlannedPass, Vec<Binding>) {
    let all = [
        ("IDS", own.ids.is_some(), Some(Binding::Ids)),
        ("DISTANCE", own.distance.is_some(), Some(Binding::Depth)),
        ("FLAGS", scene.flags, Some(Binding::Flags)),
        ("PARTICLES", own.particles.is_some(), None),
        ("REASONS", scene.reasons, Some(Binding::Reasons)),
    ];
    let there = all.into_iter().filter(|&(_, is_there, _)| is_there);
    let (effects, bound): (Vec<_>, Vec<_>) = there.map(|(name, _, bound)| (name, bound)).unzip();
    let bound: Vec<Binding> = bound.into_iter().flatten().collect();
    let pass = PlannedPass {
        kernel: "own.wgsl",
        effects,
        bindings: 2 + bound.len(),
    };
    (pass, bound)
}

/// The kernel of √luma's content alone.
const LINES: &str = "luma_lines.wgsl";

/// Whether sums of neighbouring windows are made together.
fn has_shared_sums(effects: &[&str], content: &Content) -> bool {
    let has = |name: &str| effects.contains(&name);
    content.pairs == Pairs::All
        && content.norm != Norm::LInf
        && !has("CHANNELS")
        && !has("PAIRWISE")
}

/// Whether nothing is asked for but what the kernel of √luma's content has.
fn is_by_lines(effects: &[&str], settings: &Settings) -> bool {
    const KNOWN: [&str; 7] = [
        "SQRT_LUMA",
        "ABSOLUTE",
        "REC709",
        "MEAN",
        "NORM_L1",
        "ATTACHMENT",
        "ORIGIN",
    ];
    effects.contains(&"SQRT_LUMA")
        && effects.iter().all(|name| KNOWN.contains(name))
        && has_shared_sums(effects, &settings.content)
}

/// The first kernel's definitions without a value.
fn effects(scene: &Scene, settings: &Settings) -> Vec<&'static str> {
    let content = &settings.content;
    let blur = settings.motion.map(|motion| motion.blur);
    let motion_only = matches!(blur, Some(Blur::Standalone { .. } | Blur::Ladder(_)));
    let all = [
        ("CODES", scene.colour == ColourForm::Codes),
        ("SQRT_LUMA", scene.colour == ColourForm::SqrtLuma),
        (
            "CHANNELS",
            content.difference != Difference::Luma && scene.colour != ColourForm::SqrtLuma,
        ),
        (
            "LARGEST_CHANNEL",
            content.difference == Difference::LargestChannel,
        ),
        ("RGB", content.difference == Difference::Rgb),
        ("PAIRWISE", matches!(content.form, Form::Pairwise { .. })),
        ("ABSOLUTE", content.form == Form::Absolute),
        ("REC709", content.weights == Weights::Rec709),
        ("MEAN", matches!(content.norm, Norm::L1 | Norm::Root)),
        ("NORM_L1", content.norm == Norm::L1),
        ("NORM_LINF", content.norm == Norm::LInf),
        ("INTERLEAVED", content.pairs == Pairs::Interleaved),
        ("SUB_SAMPLED", content.pairs == Pairs::SubSampled),
        ("QUAD", content.pairs == Pairs::Quad),
        ("SOBEL", content.pairs == Pairs::Sobel),
        ("MOTION", settings.motion.is_some()),
        ("VECTORS", settings.motion.is_some() && scene.motion),
        ("CAMERA", settings.motion.is_some() && !scene.motion),
        ("STANDALONE", matches!(blur, Some(Blur::Standalone { .. }))),
        ("LADDER", matches!(blur, Some(Blur::Ladder(_)))),
        ("MOTION_ONLY", motion_only),
        ("REPROJECTION", settings.reprojection.is_some()),
        ("DEPTH", settings.tests_depth() && scene.depth),
        ("MATERIALS", settings.materials.is_some()),
        ("MATERIALS_BEFORE", settings.has_materials_before()),
        (
            "MATERIALS_NOW",
            settings.materials.is_some()
                && settings.is_by_tiles()
                && !settings.has_materials_before(),
        ),
        ("PREVIOUS_RATES", settings.stability != Stability::None),
        ("HALF_RATE", settings.half_rate.is_some() && !motion_only),
        (
            "NOISE",
            settings.half_rate.is_some() && scene.noise && !motion_only,
        ),
        ("TRANSPARENTS", settings.transparents),
        ("FOVEATION", settings.foveation.is_some()),
        ("SAFE_AREA", settings.safe_area.is_some()),
        ("FLAGS", scene.flags && !settings.is_by_tiles()),
        (
            "ATTACHMENT",
            scene.attachment && !has_attachment_of_its_own(scene, settings),
        ),
        ("BLUR", settings.later_blur),
        ("LENS", settings.lens.is_some()),
        ("PLAIN", scene.plain_rates),
        ("ORIGIN", scene.origin),
        ("REASONS", scene.reasons),
        (
            "WRITE_LUMA",
            scene.sqrt_luma && scene.colour != ColourForm::SqrtLuma,
        ),
    ];
    let there = all.into_iter().filter(|&(_, on)| on);
    there
        .map(|(name, _)| name)
        .chain(name_of(settings.granularity_of_rates()))
        .collect()
}

/// What a plan calls a tile.
fn name_of(granularity: Granularity) -> Option<&'static str> {
    match granularity {
        Granularity::Quad => None,
        Granularity::Tile4 => Some("TILES_OF_4"),
        Granularity::Tile8 => Some("TILES_OF_8"),
        Granularity::Tile16 => Some("TILES_OF_16"),
        Granularity::Tile32 => Some("TILES_OF_32"),
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyse::settings::{Foveation, HalfRate, Ladder, Motion, Reprojection, SafeArea};

    #[test]
    fn nothing_that_is_not_called_for_is_there() {
        let everything = Scene {
            motion: true,
            depth: true,
            materials: true,
            noise: true,
            previous_rates: true,
            after_transparents: true,
            ..Scene::default()
        };
        for scene in [Scene::default(), everything] {
            let plan = Plan::new(&scene, &Settings::default()).expect("a plan");
            assert_eq!((plan.passes.len(), plan.bindings.len()), (1, 4), "{plan}");
            assert_eq!(plan.passes[0].effects, ["CODES"]);
        }
    }

    #[test]
    fn an_effect_adds_its_own_bindings_and_no_others() {
        let scene = Scene {
            motion: true,
            depth: true,
            flags: true,
            ..Scene::default()
        };
        let settings = Settings {
            motion: Some(Motion::default()),
            reprojection: Some(Reprojection::default()),
            smoothing: Smoothing::Limit,
            ..Settings::default()
        };
        let plan = Plan::new(&scene, &settings).expect("a plan");
        let names: Vec<&str> = plan.bindings[4..].iter().map(|b| b.name()).collect();
        assert_eq!(
            names,
            ["motion vectors", "depth", "previous depth", "flags"]
        );
        assert_eq!(plan.passes.len(), 2);
        assert_eq!(plan.to_json()["passes"][1]["kernel"], "smooth.wgsl");
    }

    #[test]
    fn more_storage_buffers_than_a_device_binds_are_refused_by_name() {
        let everything = Scene {
            colour: ColourForm::SqrtLuma,
            after_transparents: true,
            previous_rates: true,
            attachment: true,
            reasons: true,
            ..Scene::default()
        };
        let settings = Settings {
            transparents: true,
            stability: Stability::Hysteresis,
            ..Settings::default()
        };
        let plan = Plan::new(&everything, &settings).expect("the most there is fits");
        let error = plan.within(6).expect_err("seven").to_string();
        assert!(
            error.starts_with("the plan binds 7 storage buffers (tables, rates, colour"),
            "{error}"
        );
        let least = Plan::new(&Scene::default(), &Settings::default()).expect("a plan");
        assert_eq!(least.within(2), Ok(()), "tables and rates");
        assert!(least.within(1).is_err());
    }

    #[test]
    fn settings_that_the_scene_cannot_serve_are_refused_by_name() {
        let settings = Settings {
            transparents: true,
            ..Settings::default()
        };
        let error =
            Plan::new(&Scene::default(), &settings).expect_err("no picture after transparents");
        assert_eq!(
            error.to_string(),
            "transparents needs the colour after transparents, which the scene does not declare"
        );
    }

    #[test]
    fn what_content_tolerates_is_refused_where_motion_alone_decides() {
        let scene = Scene {
            motion: true,
            after_transparents: true,
            previous_rates: true,
            noise: true,
            ..Scene::default()
        };
        type Effect = (&'static str, fn(&mut Settings));
        let effects: [Effect; 6] = [
            ("stability", |s| s.stability = Stability::Hysteresis),
            ("the extra half rate", |s| {
                s.half_rate = Some(HalfRate::default())
            }),
            ("transparents", |s| s.transparents = true),
            ("foveation", |s| s.foveation = Some(Foveation::default())),
            ("quality overshoot", |s| s.overshoot = vec![[1.0, 0.5]]),
            ("a safe area", |s| s.safe_area = Some(SafeArea::default())),
        ];
        for blur in [
            Blur::Standalone { error: 0.1 },
            Blur::Ladder(Ladder::default()),
        ] {
            for (name, set) in effects {
                let mut settings = Settings {
                    motion: Some(Motion {
                        blur,
                        ..Motion::default()
                    }),
                    ..Settings::default()
                };
                assert!(Plan::new(&scene, &settings).is_ok());
                set(&mut settings);
                assert_eq!(
                    Plan::new(&scene, &settings),
                    Err(PlanError::MotionAlone(name))
                );
                settings.motion = Some(Motion::default());
                assert!(Plan::new(&scene, &settings).is_ok(), "{name} by content");
            }
        }
    }
}
