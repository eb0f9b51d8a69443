//! From a setting and a scene to what runs: the analysis' plan, the build, the rewrite, the deblocker.
//!
//! *Guarantees*: what the scene does not declare, or the setting does not ask for, is not there: not compiled, not bound, not
//! dispatched. *Refuses*: a luma that nobody leaves.

use vrcs_passes::options::{MaxRate, Mode, Options as Rewrite};

use super::setting::{
    DeblockName, DerivativesName, Estimator, HysteresisName, LargestName, LumaName, ModeName,
    NormName, Quality, Setting, SharingName, SmoothingName,
};
use crate::{
    Rate,
    analyse::peers::Peer,
    analyse::settings::{
        Blur, Content, HalfRate, Ladder, Materials, Motion, Norm, Pairs, Reprojection, Settings,
        Smoothing, Stability, Transfer,
    },
    build::{BuildOptions, Modes},
    coverage::{Coverage, Depth, DepthKind, Sky},
    deblock::{self, Picture},
    plan::{ColourForm, Plan, Scene},
    scenes::{PassName, SceneName},
};

/// The format of the scenes' pictures.
const PICTURE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// What runs for a scene at a setting.
#[derive(Clone, Debug)]
pub struct Realised {
    /// The analysis; none if every rate is 1×1 anyway.
    pub analysis: Option<Plan>,
    /// Whether motion is made of depth and the camera's matrices.
    pub camera_motion: bool,
    /// Pixels across the area that shares an estimate.
    pub granularity: u32,
    /// Rates are made anew every so many frames.
    pub every: u32,
    /// How coordinates are built; nothing if the passes run as their author wrote them.
    pub build: Option<BuildOptions>,
    /// How passes are rewritten.
    pub rewrite: Rewrite,
    /// Passes that run as their author wrote them.
    pub untouched: Vec<PassName>,
    /// What smooths blocks.
    pub deblock: Option<deblock::Options>,
    /// Whether primaries move.
    pub rotate: bool,
}

/// The largest rate of a setting.
pub fn largest(name: LargestName) -> Rate {
    match name {
        LargestName::R1x1 => Rate::R1X1,
        LargestName::R2x2 => Rate::R2X2,
        LargestName::R2x4 => Rate::R2X4,
        LargestName::R4x2 => Rate::R4X2,
        LargestName::R4x4 => Rate::R4X4,
    }
}

fn max_rate(name: LargestName) -> MaxRate {
    match name {
        LargestName::R1x1 | LargestName::R2x2 => MaxRate::R2x2,
        LargestName::R2x4 => MaxRate::R2x4,
        LargestName::R4x2 => MaxRate::R4x2,
        LargestName::R4x4 => MaxRate::R4x4,
    }
}

fn mode(name: ModeName) -> Mode {
    match name {
        ModeName::Tiled => Mode::Tiled,
        ModeName::List => Mode::List,
        ModeName::Classified => Mode::Classified,
    }
}

/// The published estimator of a setting; none for the paper's, whose parts the setting itself gives.
fn peer(name: Estimator) -> Option<Peer> {
    match name {
        Estimator::Paper => None,
        Estimator::Gdc => Some(Peer::Gdc),
        Estimator::NvidiaSample => Some(Peer::NvidiaSample),
        Estimator::FidelityFx => Some(Peer::FidelityFx),
        Estimator::Valar => Some(Peer::Valar),
        Estimator::Sobel => Some(Peer::Sobel),
        Estimator::Wicked => Some(Peer::Wicked),
    }
}

/// What a setting cannot do without and a scene has not; nothing if the two suit each other.
pub fn missing(scene: SceneName, setting: &Setting) -> Option<&'static str> {
    let declared = scene.declared();
    let has_motion = declared.motion_vectors || declared.camera_motion;
    let needs_motion = setting.estimator == Estimator::Wicked;
    (needs_motion && !(has_motion && setting.motion)).then_some("motion")
}

/// The extra half rate. Noise that the scene tells of asks for it.
fn half_rate(scene: SceneName, setting: &Setting) -> Option<HalfRate> {
    let usual = HalfRate::default();
    match (setting.half_rate, has_noise(scene, setting)) {
        (0.0, false) => None,
        (0.0, true) => Some(usual),
        (tolerance, _) => Some(HalfRate { tolerance, ..usual }),
    }
}

fn has_noise(scene: SceneName, setting: &Setting) -> bool {
    scene.declared().grain && setting.grain && peer(setting.estimator).is_none()
}

/// Whether the picture after transparents is looked at. The deblocker leaves none of it.
fn sees_through(scene: SceneName, setting: &Setting) -> bool {
    let is_papers = peer(setting.estimator).is_none();
    let is_there = scene.declared().transparents && setting.transparents;
    is_there && is_papers && setting.luma != LumaName::Root
}

/// What the content of a quad is judged by, in the paper's form.
fn content(setting: &Setting) -> Content {
    Content {
        norm: match setting.norm {
            NormName::L1 => Norm::L1,
            NormName::L2 => Norm::L2,
            NormName::Max => Norm::LInf,
        },
        pairs: match setting.derivatives {
            DerivativesName::All => Pairs::All,
            DerivativesName::Interleaved => Pairs::Interleaved,
            DerivativesName::Subsampled => Pairs::SubSampled,
        },
        transfer: match setting.luma {
            LumaName::Square => Transfer::Square,
            LumaName::Colour | LumaName::Root => Transfer::Srgb,
        },
        threshold: setting.threshold * setting.tolerance,
        ambient: setting.ambient,
        ..Content::default()
    }
}

/// A published estimator's content, motion and smoothing, with a factor on its threshold.
fn published(peer: Peer, has_motion: bool, tolerance: f64) -> Settings {
    let theirs = peer.settings(has_motion);
    let motion = theirs.motion.map(|motion| match motion.blur {
        Blur::Ladder(ladder) => Motion {
            blur: Blur::Ladder(Ladder {
                r2x1: ladder.r2x1 / tolerance,
                r2x2: ladder.r2x2 / tolerance,
                r4x2: ladder.r4x2 / tolerance,
                r4x4: ladder.r4x4 / tolerance,
            }),
            ..motion
        },
        _ => motion,
    });
    // an estimator that leaves motion alone still looks at the picture before along it
    let looked_along = has_motion.then(|| Motion {
        weight: 0.0,
        ..Motion::default()
    });
    Settings {
        content: Content {
            threshold: theirs.content.threshold * tolerance,
            ..theirs.content
        },
        motion: motion.or(looked_along),
        ..theirs
    }
}

/// What tells surfaces apart at a setting.
fn coverage(scene: SceneName, setting: &Setting) -> Coverage {
    let declared = scene.declared();
    let has_sky = declared.sky && setting.sky;
    let shares = setting.sharing == SharingName::Declared && setting.quality == Quality::Adaptive;
    Coverage {
        triangles: declared.triangle_ids && shares,
        surfaces: declared.surface_ids && shares,
        depth: (declared.depth && (shares || has_sky)).then(|| Depth::new(DepthKind::Reversed)),
        normals: None,
        sky: has_sky.then_some(Sky::Depth),
    }
}

/// The analysis' settings.
fn analysis(scene: SceneName, setting: &Setting) -> Settings {
    let declared = scene.declared();
    let has_motion = setting.motion && (declared.motion_vectors || declared.camera_motion);
    let judged = match peer(setting.estimator) {
        Some(peer) => published(peer, has_motion, setting.tolerance),
        None => Settings {
            content: content(setting),
            motion: has_motion.then(Motion::default),
            smoothing: match setting.smoothing {
                SmoothingName::Off => Smoothing::None,
                SmoothingName::Limit => Smoothing::Limit,
                SmoothingName::Conservative => Smoothing::Conservative,
            },
            ..Settings::default()
        },
    };
    // what motion alone decides has no error of the content's to tolerate
    let is_of_content = !judged.is_by_motion_alone();
    Settings {
        reprojection: has_motion.then(Reprojection::default),
        materials: (setting.materials && declared.materials && peer(setting.estimator).is_none())
            .then(Materials::default),
        stability: match setting.hysteresis {
            _ if !is_of_content => Stability::None,
            HysteresisName::Off => Stability::None,
            HysteresisName::Derived => Stability::Hysteresis,
            HysteresisName::Compensated => Stability::Compensate,
        },
        half_rate: half_rate(scene, setting).filter(|_| is_of_content),
        transparents: sees_through(scene, setting),
        largest: largest(setting.largest),
        ..judged
    }
}

fn deblocker(scene: SceneName, setting: &Setting) -> Option<deblock::Options> {
    let declared = scene.declared();
    let plain = deblock::Options {
        luma: (setting.luma == LumaName::Root).then_some(deblock::Luma::SRGB),
        coverage: !coverage(scene, setting).is_empty(),
        ..deblock::Options::new(Picture::Texture(PICTURE))
    };
    match setting.deblock {
        DeblockName::Off => None,
        DeblockName::Plain => Some(plain),
        DeblockName::Guarded => Some(deblock::Options {
            depth: declared.depth.then(|| Depth::new(DepthKind::Reversed)),
            surfaces: declared.surface_ids,
            ..plain
        }),
    }
}

/// What runs for a scene at a setting. `instruments` adds what measuring alone needs: statistics and reasons.
///
/// # Errors
/// If the setting calls for what cannot be had.
pub fn realise(scene: SceneName, setting: &Setting, instruments: bool) -> Result<Realised, String> {
    let is_exact = setting.quality == Quality::Exact;
    let untouched = untouched(scene, setting);
    let is_idle = untouched.len() == scene.passes().len();
    let deblock = match is_exact || is_idle || setting.largest == LargestName::R1x1 {
        // without coarse pixels there is nothing to smooth
        true => None,
        false => deblocker(scene, setting),
    };
    let coverage = coverage(scene, setting);
    let has_machinery = !is_idle;
    let settings = analysis(scene, setting);
    let declared = scene.declared();
    let plan = match is_exact || is_idle {
        true => None,
        false => {
            let colour = match (setting.luma, &deblock) {
                (LumaName::Root, Some(_)) => ColourForm::SqrtLuma,
                (LumaName::Root, None) => {
                    return Err(
                        "luma root is what the deblocker leaves, and there is none".to_owned()
                    );
                }
                _ => ColourForm::Codes,
            };
            let has = Scene {
                colour,
                motion: declared.motion_vectors || declared.camera_motion,
                depth: declared.depth,
                previous_rates: true,
                materials: declared.materials,
                noise: has_noise(scene, setting),
                after_transparents: sees_through(scene, setting),
                reasons: instruments,
                ..Scene::default()
            };
            Some(Plan::new(&has, &settings).map_err(|error| error.to_string())?)
        }
    };
    let mode = mode(setting.mode);
    Ok(Realised {
        camera_motion: declared.camera_motion && settings.motion.is_some() && plan.is_some(),
        analysis: plan,
        granularity: setting.granularity,
        every: setting.every,
        build: has_machinery.then(|| BuildOptions {
            largest: match is_exact {
                true => Rate::R1X1,
                false => largest(setting.largest),
            },
            modes: Modes::NONE.with(mode),
            coverage,
            effective: deblock.is_some(),
            statistics: instruments,
            ..BuildOptions::default()
        }),
        rewrite: Rewrite {
            mode,
            max_rate: max_rate(setting.largest),
            ..Rewrite::default()
        },
        untouched,
        deblock,
        rotate: setting.rotate,
    })
}

/// The passes of a scene that a setting leaves as their author wrote them. If nothing may be given up, those also that can skip
/// nothing: rewritten they would only take longer.
fn untouched(scene: SceneName, setting: &Setting) -> Vec<PassName> {
    let has_sky = scene.declared().sky && setting.sky;
    let skips = |pass: PassName| has_sky && pass.sky() == vrcs_passes::options::Sky::Skip;
    let stays = |pass: &PassName| {
        setting.full_rate.contains(pass) || (setting.quality == Quality::Exact && !skips(*pass))
    };
    scene.passes().iter().copied().filter(stays).collect()
}

impl Realised {
    /// The entry points of a scene's passes that are rewritten, or of those that are not.
    pub fn passes(&self, scene: SceneName, rewritten: bool) -> Vec<&'static str> {
        let passes = scene.passes().iter();
        passes
            .filter(|pass| self.untouched.contains(pass) != rewritten)
            .map(|pass| pass.entry())
            .collect()
    }

    /// What runs and what does not, line by line.
    pub fn lines(&self, scene: SceneName) -> Vec<String> {
        let declared = scene.declared();
        let said = [
            (declared.motion_vectors, "motion vectors"),
            (declared.camera_motion, "camera motion"),
            (declared.depth, "depth"),
            (declared.surface_ids, "surface ids"),
            (declared.triangle_ids, "triangle ids"),
            (declared.materials, "materials"),
            (declared.sky, "sky"),
            (declared.grain, "grain"),
            (declared.transparents, "transparents"),
        ];
        let names = |wanted: bool| {
            let list: Vec<&str> = said
                .iter()
                .filter(|(is_there, _)| *is_there == wanted)
                .map(|&(_, name)| name)
                .collect();
            match list.is_empty() {
                true => "nothing".to_owned(),
                false => list.join(", "),
            }
        };
        let mut lines = vec![format!(
            "declares {}; has no {}",
            names(true),
            names(false).replace(", ", ", no ")
        )];
        if self.camera_motion {
            lines.push("camera motion: motion vectors from depth and two cameras".to_owned());
        }
        match &self.analysis {
            None => lines.push("no analysis: every rate is 1x1".to_owned()),
            Some(plan) => lines.extend(plan.passes.iter().map(|pass| {
                format!(
                    "{}: {}; {} bindings",
                    pass.kernel,
                    pass.effects.join(", ").to_lowercase().replace('_', " "),
                    pass.bindings
                )
            })),
        }
        if self.granularity > 2 {
            lines.push(format!(
                "granularity: one rate for {0}x{0} pixels",
                self.granularity
            ));
        }
        match &self.build {
            None => lines.push("no build: the passes run as their author wrote them".to_owned()),
            Some(build) => {
                let defs = build.coverage.defs();
                let parts: Vec<String> = defs
                    .iter()
                    .map(|(name, _)| name.to_lowercase().replace('_', " "))
                    .collect();
                lines.push(format!(
                    "build.wgsl: {}",
                    match parts.is_empty() {
                        true => "the rate alone decides".to_owned(),
                        false => parts.join(", "),
                    }
                ));
            }
        }
        let [rewritten, untouched] = [true, false].map(|wanted| self.passes(scene, wanted));
        if !rewritten.is_empty() {
            let mode = format!("{:?}", self.rewrite.mode).to_lowercase();
            lines.push(format!(
                "passes, rewritten ({mode}): {}",
                rewritten.join(", ")
            ));
        }
        if !untouched.is_empty() {
            lines.push(format!(
                "passes, as their author wrote them: {}",
                untouched.join(", ")
            ));
        }
        lines.push(match &self.deblock {
            None => "no deblocker".to_owned(),
            Some(options) => {
                let guards = [
                    (options.depth.is_some(), "depth"),
                    (options.surfaces, "surfaces"),
                ];
                let guards: Vec<&str> = guards
                    .into_iter()
                    .filter(|(is_there, _)| *is_there)
                    .map(|(_, name)| name)
                    .collect();
                match guards[..] {
                    [] => "deblock.wgsl: over all edges".to_owned(),
                    ["depth"] => "deblock.wgsl: stops where depth differs".to_owned(),
                    _ => format!("deblock.wgsl: stops where {} differ", guards.join(" or ")),
                }
            }
        });
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::{super::setting::presets, *};

    fn plan(scene: SceneName, setting: &Setting) -> Realised {
        realise(scene, setting, false).expect("a setting that can be had")
    }

    #[test]
    fn a_scene_that_declares_nothing_runs_nothing_but_the_analysis_of_content() {
        let setting = Setting {
            hysteresis: HysteresisName::Off,
            deblock: DeblockName::Off,
            ..Setting::default()
        };
        let found = plan(SceneName::Ramps, &setting);
        let analysis = found.analysis.expect("an analysis");
        assert_eq!(analysis.passes[0].effects, ["CODES"]);
        assert!(found.build.expect("a build").coverage.is_empty());
        assert!(found.deblock.is_none());
    }

    #[test]
    fn each_scene_runs_what_it_declares_and_no_more() {
        for scene in SceneName::ALL {
            let (found, declared) = (plan(scene, &Setting::default()), scene.declared());
            let effects = &found.analysis.as_ref().expect("an analysis").passes[0].effects;
            let moves = declared.motion_vectors || declared.camera_motion;
            assert_eq!(effects.contains(&"MOTION"), moves, "{scene}");
            assert_eq!(
                effects.contains(&"MATERIALS"),
                declared.materials,
                "{scene}"
            );
            assert_eq!(effects.contains(&"NOISE"), declared.grain, "{scene}");
            let sees_through = effects.contains(&"TRANSPARENTS");
            assert_eq!(sees_through, declared.transparents, "{scene}");
            assert_eq!(effects.contains(&"HALF_RATE"), declared.grain, "{scene}");
            assert_eq!(found.camera_motion, declared.camera_motion, "{scene}");
            let coverage = found.build.as_ref().expect("a build").coverage;
            assert_eq!(coverage.triangles, declared.triangle_ids, "{scene}");
            assert_eq!(coverage.surfaces, declared.surface_ids, "{scene}");
            assert_eq!(coverage.sky.is_some(), declared.sky, "{scene}");
        }
    }

    #[test]
    fn plans_differ_where_declarations_do() {
        let lines = |scene| plan(scene, &Setting::default()).lines(scene);
        for (index, scene) in SceneName::ALL.into_iter().enumerate() {
            for other in &SceneName::ALL[..index] {
                assert_ne!(lines(scene), lines(*other), "{scene} and {other}");
            }
        }
        assert!(
            lines(SceneName::Text)
                .contains(&"deblock.wgsl: stops where depth or surfaces differ".to_owned())
        );
        assert!(lines(SceneName::Ramps).contains(&"deblock.wgsl: over all edges".to_owned()));
    }

    #[test]
    fn a_published_estimator_brings_its_own_and_a_factor_moves_its_threshold() {
        for (estimator, threshold) in [
            (Estimator::Gdc, 0.15),
            (Estimator::NvidiaSample, 0.07),
            (Estimator::FidelityFx, 0.025),
            (Estimator::Valar, 0.5),
        ] {
            let setting = Setting {
                estimator,
                tolerance: 2.0,
                ..Setting::default()
            };
            let found = analysis(SceneName::Interior, &setting).content.threshold;
            assert!(
                (found - 2.0 * threshold).abs() < 1e-12,
                "{estimator:?} {found}"
            );
        }
        let wicked = Setting {
            estimator: Estimator::Wicked,
            ..Setting::default()
        };
        assert_eq!(missing(SceneName::Landscape, &wicked), None);
        assert_eq!(missing(SceneName::Text, &wicked), Some("motion"));
    }

    #[test]
    fn exact_runs_no_analysis_no_deblocker_and_where_nothing_is_empty_nothing_at_all() {
        let [exact, ..] = presets();
        for scene in SceneName::ALL {
            let found = plan(scene, &exact.setting);
            assert!(
                found.analysis.is_none() && found.deblock.is_none(),
                "{scene}"
            );
            assert_eq!(found.build.is_some(), scene.declared().sky, "{scene}");
        }
    }

    #[test]
    fn where_every_pass_is_left_alone_nothing_runs_and_where_some_are_the_rest_does() {
        let scene = SceneName::Landscape;
        for setting in [
            Setting::untouched(),
            Setting {
                full_rate: scene.passes().to_vec(),
                ..Setting::default()
            },
        ] {
            let found = plan(scene, &setting);
            assert!(found.analysis.is_none() && found.build.is_none() && found.deblock.is_none());
            assert_eq!(found.passes(scene, false).len(), scene.passes().len());
        }
        let setting = Setting {
            full_rate: vec![PassName::Composite, PassName::Rays],
            ..Setting::default()
        };
        let found = plan(scene, &setting);
        assert_eq!(
            found.passes(scene, true),
            ["material", "lighting", "atmosphere"]
        );
        assert!(found.build.is_some() && found.deblock.is_some());
    }

    #[test]
    fn exact_rewrites_only_what_can_skip_something() {
        let [exact, ..] = presets();
        let rewritten = |scene| plan(scene, &exact.setting).passes(scene, true);
        assert_eq!(rewritten(SceneName::Foliage), ["material", "rays"]);
        assert_eq!(rewritten(SceneName::Landscape), ["material"]);
        assert!(rewritten(SceneName::Interior).is_empty());
    }

    #[test]
    fn without_coarse_rates_there_is_no_deblocker() {
        let setting = Setting {
            largest: LargestName::R1x1,
            ..Setting::default()
        };
        assert!(plan(SceneName::Text, &setting).deblock.is_none());
        let setting = Setting {
            luma: LumaName::Root,
            ..setting
        };
        assert!(realise(SceneName::Text, &setting, false).is_err());
    }
}
