//! The scenes that quality and time are measured on: procedural, animated, the same for the same frame and seed.
//!
//! A frame is made by compute passes: one that stands for the rasteriser and fills a G-buffer at full rate, and several heavy
//! ones that shade it. The heavy ones are ordinary shaders in `shaders/scenes/`; the project's own rewriter makes them
//! variable-rate.
//!
//! Each scene [declares](Declared) what a renderer would have for it, and leaves the rest out.

pub mod frame;
pub mod stage;

use std::{fmt, str::FromStr};

use vrcs_passes::{Source, options::Sky};

use frame::Camera;
use glam::Vec3;

/// A scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SceneName {
    /// A hall with many lamps and shiny metal.
    Interior,
    /// Trees and grass with alpha-tested leaves: the known worst case.
    Foliage,
    /// Hills under a wide sky with fog, from a fast camera.
    Landscape,
    /// Small print that scrolls, and fine patterns, on a slanted board.
    Text,
    /// Ramps in all directions, and edges between colours of one luma.
    Ramps,
    /// Bars that uncover what was not seen before.
    Disocclusion,
}

/// A pass of a scene that is made variable-rate.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum PassName {
    /// Textures: colour, roughness, emission.
    Material,
    /// Every light on every pixel, with shadows of the first few.
    Lighting,
    /// Ambient occlusion and reflections by short ray marches.
    Rays,
    /// Clouds, and shafts of light in the haze, by ray marches.
    Atmosphere,
    /// Fog, tone curve, grain.
    Composite,
}

impl PassName {
    /// All passes that scenes have.
    pub const ALL: [PassName; 5] = [
        PassName::Material,
        PassName::Lighting,
        PassName::Rays,
        PassName::Atmosphere,
        PassName::Composite,
    ];

    /// What becomes of pixels that show nothing, if they are told: the sky's colour is made by the lighting and shown by the
    /// composite, and clouds are in it; textures and rays have nothing to do there, and nothing reads what they would leave.
    pub fn sky(self) -> Sky {
        match self {
            PassName::Material | PassName::Rays => Sky::Skip,
            PassName::Lighting | PassName::Atmosphere | PassName::Composite => Sky::Shade,
        }
    }

    /// The name of its entry point.
    pub fn entry(self) -> &'static str {
        match self {
            PassName::Material => "material",
            PassName::Lighting => "lighting",
            PassName::Rays => "rays",
            PassName::Atmosphere => "atmosphere",
            PassName::Composite => "composite",
        }
    }
}

/// What a renderer would have for a scene. What is not declared does not exist: no texture, no kernel, no dispatch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Declared {
    /// Motion vectors for each pixel.
    pub motion_vectors: bool,
    /// Motion that follows from depth and the camera's matrices.
    pub camera_motion: bool,
    /// Depth.
    pub depth: bool,
    /// Surface ids.
    pub surface_ids: bool,
    /// Triangle ids.
    pub triangle_ids: bool,
    /// Roughness and metal.
    pub materials: bool,
    /// Pixels that show nothing.
    pub sky: bool,
    /// Noise on the picture that must not become coarse blocks.
    pub grain: bool,
    /// Something to see through, laid over the finished picture: there is a picture before and one after.
    pub transparents: bool,
}

macro_rules! shader {
    ($name:literal) => {
        include_str!(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/shaders/scenes/",
            $name
        ))
    };
}

impl SceneName {
    /// All scenes.
    pub const ALL: [SceneName; 6] = [
        SceneName::Interior,
        SceneName::Foliage,
        SceneName::Landscape,
        SceneName::Text,
        SceneName::Ramps,
        SceneName::Disocclusion,
    ];

    /// Its name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            SceneName::Interior => "interior",
            SceneName::Foliage => "foliage",
            SceneName::Landscape => "landscape",
            SceneName::Text => "text",
            SceneName::Ramps => "ramps",
            SceneName::Disocclusion => "disocclusion",
        }
    }

    /// What it shows, in a sentence.
    pub fn about(self) -> &'static str {
        match self {
            SceneName::Interior => {
                "a hall with 64 lamps, polished metal, a mirror-like floor and plumes of steam"
            }
            SceneName::Foliage => "trees and grass with alpha-tested leaves in the wind",
            SceneName::Landscape => {
                "hills and towers with shafts of light in grainy haze, under a wide sky of clouds, from a fast aircraft"
            }
            SceneName::Text => {
                "print that scrolls, rulings, a fan of lines and a zone plate on a slanted board, without motion vectors"
            }
            SceneName::Ramps => {
                "ramps of many slopes across, down and aslant, and edges between colours of one luma"
            }
            SceneName::Disocclusion => "bars that sweep past a patterned wall",
        }
    }

    fn text(self) -> &'static str {
        match self {
            SceneName::Interior => shader!("interior.wgsl"),
            SceneName::Foliage => shader!("foliage.wgsl"),
            SceneName::Landscape => shader!("landscape.wgsl"),
            SceneName::Text => shader!("text.wgsl"),
            SceneName::Ramps => shader!("ramps.wgsl"),
            SceneName::Disocclusion => shader!("disocclusion.wgsl"),
        }
    }

    /// Its shader: files that make one module.
    pub fn source(self) -> Source {
        let mut source = Source::new("scenes/common.wgsl", shader!("common.wgsl"));
        source.push(format!("scenes/{}.wgsl", self.name()), self.text());
        source.push("scenes/passes.wgsl", shader!("passes.wgsl"));
        source.push("scenes/gbuffer.wgsl", shader!("gbuffer.wgsl"));
        match self.declared().motion_vectors {
            true => source.push("scenes/motion.wgsl", shader!("motion.wgsl")),
            false => source.push("scenes/nomotion.wgsl", shader!("nomotion.wgsl")),
        }
        let runs = |pass| self.passes().contains(&pass);
        match (runs(PassName::Rays), runs(PassName::Atmosphere)) {
            (true, _) => source.push("scenes/rays.wgsl", shader!("rays.wgsl")),
            (_, true) => source.push("scenes/atmosphere.wgsl", shader!("atmosphere.wgsl")),
            _ => source.push("scenes/norays.wgsl", shader!("norays.wgsl")),
        }
        if self.declared().transparents {
            source.push("scenes/transparents.wgsl", shader!("transparents.wgsl"));
        }
        source
    }

    /// The passes after `geometry`, in the order in which a frame runs them.
    pub fn passes(self) -> &'static [PassName] {
        use PassName as P;
        match self {
            SceneName::Landscape => &[P::Material, P::Lighting, P::Atmosphere, P::Composite],
            SceneName::Ramps => &[P::Material, P::Lighting, P::Composite],
            _ => &[P::Material, P::Lighting, P::Rays, P::Composite],
        }
    }

    /// The full-rate passes that make its G-buffer, in order: entry points.
    pub fn gbuffer(self) -> Vec<&'static str> {
        let declared = self.declared();
        [
            ("geometry", true),
            ("surface_ids", declared.surface_ids),
            ("material_ids", declared.materials),
            ("noise_mask", declared.grain),
        ]
        .into_iter()
        .filter(|&(_, is_there)| is_there)
        .map(|(entry, _)| entry)
        .collect()
    }

    /// What a renderer would have for it.
    pub fn declared(self) -> Declared {
        match self {
            SceneName::Interior => Declared {
                motion_vectors: true,
                depth: true,
                surface_ids: true,
                triangle_ids: true,
                materials: true,
                transparents: true,
                ..Declared::default()
            },
            SceneName::Foliage => Declared {
                motion_vectors: true,
                depth: true,
                surface_ids: true,
                sky: true,
                ..Declared::default()
            },
            SceneName::Landscape => Declared {
                camera_motion: true,
                depth: true,
                triangle_ids: true,
                sky: true,
                grain: true,
                ..Declared::default()
            },
            SceneName::Text => Declared {
                depth: true,
                surface_ids: true,
                ..Declared::default()
            },
            SceneName::Ramps => Declared::default(),
            SceneName::Disocclusion => Declared {
                motion_vectors: true,
                depth: true,
                surface_ids: true,
                ..Declared::default()
            },
        }
    }

    /// Where the camera stands at a time, in seconds.
    pub fn camera(self, time: f32) -> Camera {
        let look = |from: Vec3, at: Vec3, reach: f32| Camera::look(from, at, reach);
        match self {
            SceneName::Interior => {
                let from = Vec3::new(0.8 * (time * 0.4).sin(), 1.6, -1.5 + 0.35 * time);
                look(
                    from,
                    from + Vec3::new(0.25 * (time * 0.3).sin(), -0.06, 1.0),
                    0.55,
                )
            }
            SceneName::Foliage => {
                let from = Vec3::new(-0.6 + 0.3 * time, 1.3, -0.4);
                look(from, Vec3::new(0.2 + 0.2 * time, 1.6, 6.0), 0.5)
            }
            SceneName::Landscape => {
                let from = Vec3::new(3.0 * (time * 0.3).sin(), 17.0, 26.0 * time);
                look(
                    from,
                    from + Vec3::new(0.3 * (time * 0.5).sin(), -0.2, 1.0),
                    0.6,
                )
            }
            SceneName::Text => look(Vec3::new(0.0, 3.6, -0.2), Vec3::new(0.0, 0.0, 3.5), 0.5),
            SceneName::Ramps => look(Vec3::ZERO, Vec3::Z, 0.5),
            SceneName::Disocclusion => {
                look(Vec3::new(0.0, 0.2, 0.0), Vec3::new(0.0, 0.2, 1.0), 0.42)
            }
        }
    }
}

impl fmt::Display for SceneName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// No scene has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no scene is called `{0}`; there are interior, foliage, landscape, text, ramps and disocclusion"
)]
pub struct UnknownScene(pub String);

impl FromStr for SceneName {
    type Err = UnknownScene;

    fn from_str(name: &str) -> Result<SceneName, UnknownScene> {
        SceneName::ALL
            .into_iter()
            .find(|scene| scene.name() == name)
            .ok_or_else(|| UnknownScene(name.to_owned()))
    }
}
