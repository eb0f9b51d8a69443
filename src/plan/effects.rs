//! What is compiled into which kernel: an effect that is not called for is not there.

use super::{Binding, ColourForm, Plan, PlannedPass, Scene};
use crate::{
    Rate,
    analyse::{
        integer::count,
        own::OwnRates,
        params::has_fixed_limits,
        settings::{
            Blur, Content, Difference, Form, Granularity, Norm, Pairs, Settings, Stability, Weights,
        },
        tiles::SIDE,
    },
};

/// The pixels that a workgroup of the kernels of tiles makes.
pub(crate) const REGION: [u32; 2] = [32; 2];

/// The kernel of √luma's content alone.
pub(super) const LINES: &str = "luma_lines.wgsl";

impl Plan {
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
            // a side of four is allowed at all
            (
                "QUARTERS",
                ![Rate::R1X1, Rate::R2X1, Rate::R1X2, Rate::R2X2].contains(&self.settings.largest),
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
}

/// Whether the attachment's rates are of tiles and the others of quads.
pub(super) fn has_attachment_of_its_own(scene: &Scene, settings: &Settings) -> bool {
    scene.attachment
        && settings.granularity_of_rates() == Granularity::Quad
        && settings.attachment.is_tile()
}

/// What is compiled into the kernel that makes the attachment alone, given what is compiled into the first: no extra half rate, and none
/// of the other outputs.
pub(super) fn effects_of_attachment(
    first: &[&'static str],
    settings: &Settings,
) -> Vec<&'static str> {
    let others = ["HALF_RATE", "NOISE", "PLAIN", "REASONS", "WRITE_LUMA"];
    let kept = first.iter().copied().filter(|name| !others.contains(name));
    kept.chain(["ATTACHMENT", "ATTACHMENT_ALONE"])
        .chain(name_of(settings.granularity_of_attachment()))
        .collect()
}

/// The pass of the application's own rates, and what it binds.
pub(super) fn own_pass(scene: &Scene, own: &OwnRates) -> (PlannedPass, Vec<Binding>) {
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

/// Whether sums of neighbouring windows are made together.
fn has_shared_sums(effects: &[&str], content: &Content) -> bool {
    let has = |name: &str| effects.contains(&name);
    content.pairs == Pairs::All
        && content.norm != Norm::LInf
        && !has("CHANNELS")
        && !has("PAIRWISE")
}

/// Whether nothing is asked for but what the kernel of √luma's content has.
pub(super) fn is_by_lines(effects: &[&str], settings: &Settings) -> bool {
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
pub(super) fn effects(scene: &Scene, settings: &Settings) -> Vec<&'static str> {
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
