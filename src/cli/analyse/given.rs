//! What a picture is analysed with: everything that the library can be given, each from a file of its own.
//!
//! Does: reads the files, and turns on the effect that a file is for, with its default parameters, where the settings have it not.
//! Guarantees: each has its picture's size. Motion that comes from matrices is worked out here, so that a driver and the CPU are given
//! the same vectors, unless the stage goes by tiles.
//! Refuses: files that nothing would look at, and effects whose file is not named.

use std::path::PathBuf;

use super::{
    layers,
    picture::{Picture, Pixels},
};
use crate::{
    analyse::{
        Cameras, Inputs, Settings, reproject,
        settings::{HalfRate, Materials, MaterialsOf, Motion, Reprojection, Stability},
        written,
    },
    cli::Failure,
    sri::Sri,
};

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "What is known of the picture")]
pub(super) struct GivenFiles {
    /// The picture of the frame before.
    ///
    /// It is what is analysed, along motion; without, IMAGE itself is.
    #[arg(long, value_name = "IMAGE")]
    pub(super) previous: Option<PathBuf>,
    /// What is analysed after its transparents; it itself is then before them.
    #[arg(long, value_name = "IMAGE", hide_short_help = true)]
    after: Option<PathBuf>,
    /// IMAGE's motion vectors.
    #[arg(long, value_name = "FILE.exr", conflicts_with = "matrices")]
    motion: Option<PathBuf>,
    /// IMAGE's depth.
    ///
    /// With --previous and motion it finds what was hidden, with --matrices it gives the motion; a lens and rates by distance look at
    /// it, too.
    #[arg(long, value_name = "FILE.exr")]
    depth: Option<PathBuf>,
    /// The depth of the frame before.
    ///
    /// Without, it is put together from IMAGE's, which knows of what hides and can still be seen.
    #[arg(
        long,
        value_name = "FILE.exr",
        requires = "depth",
        hide_short_help = true
    )]
    previous_depth: Option<PathBuf>,
    /// The cameras of both frames, where there are no vectors.
    #[arg(long, value_name = "FILE.json", requires = "depth")]
    matrices: Option<PathBuf>,
    /// How wide a later blur is at each pixel, in pixels.
    #[arg(long, value_name = "FILE.exr", hide_short_help = true)]
    blur: Option<PathBuf>,
    /// Smoothness in red and Rf0 in green, 255 for 1.
    #[arg(long, value_name = "FILE.png")]
    materials: Option<PathBuf>,
    /// The same of the frame before, from its G-buffer: fetched along motion, of that frame's size.
    #[arg(
        long,
        value_name = "FILE.png",
        conflicts_with = "materials",
        hide_short_help = true
    )]
    previous_materials: Option<PathBuf>,
    /// Where noise is, 255 for most: there the extra half rate is.
    #[arg(long, value_name = "FILE.png", hide_short_help = true)]
    noise: Option<PathBuf>,
    /// The material or object of each pixel, 0 to 255, for the rates that the settings state.
    #[arg(long, value_name = "FILE.png", hide_short_help = true)]
    ids: Option<PathBuf>,
    /// Where the rate is full whatever is found: what is not black.
    ///
    /// Alpha-tested surfaces, a HUD.
    #[arg(long, value_name = "FILE.png")]
    mask: Option<PathBuf>,
    /// Bits of each pixel: 1 does not move with the world, 2 no extra half rate, 4 full rate, 8 a particle.
    #[arg(long, value_name = "FILE.png", hide_short_help = true)]
    flags: Option<PathBuf>,
    /// The rates that the frame before had, as -o writes them: for stability.
    #[arg(long, value_name = "SRI.png", hide_short_help = true)]
    previous_rates: Option<PathBuf>,
}

/// What is in the files.
pub(super) struct Given {
    pub(super) previous: Option<Picture>,
    after: Option<Picture>,
    motion: Option<Vec<[f32; 2]>>,
    depth: Option<Vec<f32>>,
    previous_depth: Option<Vec<f32>>,
    cameras: Option<Cameras>,
    blur: Option<Vec<f32>>,
    materials: Option<Vec<[u8; 2]>>,
    noise: Option<Vec<u8>>,
    ids: Option<Vec<u8>>,
    flags: Option<Vec<u8>>,
    previous_rates: Option<Sri>,
}

impl GivenFiles {
    /// Whether there is motion.
    pub(super) fn has_motion(&self) -> bool {
        self.motion.is_some() || self.matrices.is_some()
    }

    /// All that are named.
    pub(super) fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        [
            &self.previous,
            &self.after,
            &self.motion,
            &self.depth,
            &self.previous_depth,
            &self.matrices,
            &self.blur,
            &self.materials,
            &self.previous_materials,
            &self.noise,
            &self.ids,
            &self.mask,
            &self.flags,
            &self.previous_rates,
        ]
        .into_iter()
        .flatten()
    }

    /// Turns on what the files are for.
    pub(super) fn turn_on(&self, settings: &mut Settings) {
        if self.has_motion() {
            settings.motion.get_or_insert_with(Motion::default);
            if self.previous.is_some() {
                settings
                    .reprojection
                    .get_or_insert_with(Reprojection::default);
            }
        }
        settings.transparents |= self.after.is_some();
        settings.later_blur |= self.blur.is_some();
        if settings.later_blur || settings.lens.is_some() {
            // a blur hides what motion of its width does; without motion, nothing moves
            settings.motion.get_or_insert_with(Motion::default);
        }
        if self.materials.is_some() {
            settings.materials.get_or_insert_with(Materials::default);
        }
        if self.previous_materials.is_some() {
            let materials = settings.materials.get_or_insert_with(Materials::default);
            materials.of = MaterialsOf::Previous;
        }
        if self.noise.is_some() {
            settings.half_rate.get_or_insert_with(HalfRate::default);
        }
        if self.previous_rates.is_some() && settings.stability == Stability::None {
            settings.stability = Stability::Hysteresis;
        }
    }

    /// Refuses what would be read and not be looked at, and what is looked at and not named.
    pub(super) fn check(&self, settings: &Settings) -> Result<(), Failure> {
        let own = settings.own.clone().unwrap_or_default();
        let has_blur = settings.later_blur || settings.lens.is_some();
        let is_past = self.has_motion() && self.previous.is_some();
        let looks_at_depth =
            self.matrices.is_some() || is_past || settings.lens.is_some() || own.distance.is_some();
        let states_ids = written::states_ids(own.ids.as_ref());
        let cases = [
            (
                self.depth.is_some() && !looks_at_depth,
                "--depth alone tells nothing: with --previous and --motion it finds what was hidden, with --matrices it gives the motion; a lens or rates by distance in --settings look at it",
            ),
            (
                self.previous_depth.is_some() && !is_past,
                "--previous-depth needs --previous, and --motion or --matrices: it is looked up along motion",
            ),
            (
                settings.motion.is_some() && !self.has_motion() && !has_blur,
                "the settings have motion: --motion, or --depth and --matrices, give it",
            ),
            (
                settings.reprojection.is_some() && !is_past,
                "the settings have a reprojection: it needs --previous, and --motion or --matrices",
            ),
            (
                settings.is_by_tiles() && self.matrices.is_none(),
                "a stage by tiles moves them by depth and cameras: it needs --matrices in place of --motion",
            ),
            (
                settings.later_blur && self.blur.is_none(),
                "the settings have a later blur: --blur gives its width",
            ),
            (
                settings.lens.is_some() && self.depth.is_none(),
                "the settings have a lens: it needs --depth",
            ),
            (
                settings.materials.is_some()
                    && self.materials.is_none()
                    && self.previous_materials.is_none(),
                "the settings have materials: --materials gives them, or --previous-materials",
            ),
            (
                settings.has_materials_before() && self.previous_materials.is_none(),
                "the settings have materials of the frame before: --previous-materials gives them",
            ),
            (
                settings.transparents && self.after.is_none(),
                "the settings have transparents: --after gives the picture after them",
            ),
            (
                settings.stability != Stability::None && self.previous_rates.is_none(),
                "the settings have stability: --previous-rates gives the rates of the frame before",
            ),
            (
                states_ids && self.ids.is_none(),
                "the settings have rates by id: --ids gives the ids",
            ),
            (
                self.ids.is_some() && !states_ids,
                "--ids needs rates for them: [own.ids] in --settings",
            ),
            (
                own.distance.is_some() && self.depth.is_none(),
                "the settings have rates by distance: they need --depth",
            ),
            (
                own.particles.is_some() && self.flags.is_none(),
                "the settings have a rate of particles: --flags says where they are",
            ),
        ];
        match cases.into_iter().find(|&(is_wrong, _)| is_wrong) {
            Some((_, why)) => Err(Failure::Misused(why.to_owned())),
            None => Ok(()),
        }
    }

    /// Reads the files for a picture of a size.
    pub(super) fn read(&self, settings: &Settings, size: [u32; 2]) -> Result<Given, Failure> {
        let previous = self.previous.as_deref().map(Picture::read).transpose()?;
        let before = previous.as_ref().map_or(size, Picture::size);
        let number = |path: &Option<PathBuf>, size| {
            path.as_deref()
                .map(|path| layers::number(path, size))
                .transpose()
        };
        let bytes = |path: &Option<PathBuf>| {
            path.as_deref()
                .map(|path| layers::bytes(path, size))
                .transpose()
        };
        let after = self.after.as_deref().map(Picture::read).transpose()?;
        let flags = marks(bytes(&self.flags)?, bytes(&self.mask)?);
        let depth = number(&self.depth, size)?;
        let cameras = self.matrices.as_deref().map(layers::matrices).transpose()?;
        let is_still = settings.motion.is_some() && !self.has_motion();
        let motion = match (&self.motion, &cameras, &depth) {
            (Some(path), ..) => Some(layers::motion(path, size)?),
            (None, Some(cameras), Some(depth)) if !settings.is_by_tiles() => {
                Some(still_where(flags.as_deref(), {
                    reproject::camera_motions(size, depth, &cameras.now, &cameras.before)
                }))
            }
            _ if is_still => Some(vec![[0.0; 2]; size[0] as usize * size[1] as usize]),
            _ => None,
        };
        Ok(Given {
            previous_depth: number(&self.previous_depth, before)?,
            blur: number(&self.blur, size)?,
            materials: match (&self.materials, &self.previous_materials) {
                (Some(path), _) => Some(layers::materials(path, size)?),
                (None, Some(path)) => Some(layers::materials(path, before)?),
                (None, None) => None,
            },
            noise: bytes(&self.noise)?,
            ids: bytes(&self.ids)?,
            previous_rates: self
                .previous_rates
                .as_deref()
                .map(|path| layers::rates(path, before))
                .transpose()?,
            cameras: cameras.filter(|_| settings.is_by_tiles()),
            previous,
            after,
            motion,
            depth,
            flags,
        })
    }
}

/// Vectors of a camera, but for what does not move with the world.
fn still_where(flags: Option<&[u8]>, mut vectors: Vec<[f32; 2]>) -> Vec<[f32; 2]> {
    for (vector, mark) in vectors.iter_mut().zip(flags.unwrap_or_default()) {
        if mark & crate::analyse::inputs::flags::STATIC != 0 {
            *vector = [0.0; 2];
        }
    }
    vectors
}

/// Flags with what a mask keeps at full rate.
fn marks(flags: Option<Vec<u8>>, mask: Option<Vec<u8>>) -> Option<Vec<u8>> {
    let full = |mask: u8| match mask {
        0 => 0,
        _ => crate::analyse::inputs::flags::FULL,
    };
    match (flags, mask) {
        (flags, None) => flags,
        (None, Some(mask)) => Some(mask.into_iter().map(full).collect()),
        (Some(flags), Some(mask)) => {
            let both = flags.into_iter().zip(mask);
            Some(both.map(|(flags, mask)| flags | full(mask)).collect())
        }
    }
}

impl Given {
    /// The picture after transparents, which has the size of what is analysed, as that is before them.
    pub(super) fn after(&self) -> Option<&Picture> {
        self.after.as_ref()
    }

    /// Puts together the depth of the frame before, where there is none and it is looked at.
    pub(super) fn complete(&mut self, settings: &Settings, pixels: &Pixels, sizes: [[u32; 2]; 2]) {
        if settings.tests_depth() && self.depth.is_some() && self.previous_depth.is_none() {
            let inputs = self.inputs(sizes, pixels, None);
            self.previous_depth = Some(reproject::depth_before(&inputs, settings));
        }
    }

    /// The inputs of a picture of the first size; what is analysed has the second.
    pub(super) fn inputs<'a>(
        &'a self,
        [size, previous_size]: [[u32; 2]; 2],
        pixels: &'a Pixels,
        after: Option<&'a Pixels>,
    ) -> Inputs<'a> {
        Inputs {
            size,
            after: after.map(Pixels::colour),
            motion: self.motion.as_deref(),
            depth: self.depth.as_deref(),
            previous_depth: self.previous_depth.as_deref(),
            cameras: self.cameras,
            blur: self.blur.as_deref(),
            materials: self.materials.as_deref(),
            noise: self.noise.as_deref(),
            ids: self.ids.as_deref(),
            flags: self.flags.as_deref(),
            previous_rates: self.previous_rates.as_ref(),
            ..Inputs::of_colour(previous_size, pixels.colour())
        }
    }
}
