//! Why there may be no plan: settings that call for what the scene has not, or that contradict one another.

use super::Scene;
use crate::analyse::settings::{Blur, Settings, Stability};

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

/// Holds settings against a scene.
///
/// # Errors
/// The first that the scene has nothing for, or that another makes void.
pub(super) fn refuse(scene: &Scene, settings: &Settings) -> Result<(), PlanError> {
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
    Ok(())
}
