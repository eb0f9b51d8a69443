//! Why there is no view, or it cannot be used; and what is looked at before anything is made.

use crate::{
    Rate,
    build::{BuildOptions, gpu::Sizes},
    coverage::{Contradiction, Normals, Textures},
    limits::LimitError,
};

/// Why a view could not be made or changed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// There is nothing to shade.
    #[error("the extent {0:?} has no pixels")]
    Empty([u32; 3]),
    /// A buffer would be larger than the device allows.
    #[error(
        "a view of {extent:?} needs a buffer of {bytes} bytes; the device binds at most {limit}: request a higher \
         `max_storage_buffer_binding_size` and `max_buffer_size`, or ask for fewer modes in `BuildOptions::modes`"
    )]
    TooLarge {
        /// The extent.
        extent: [u32; 3],
        /// The bytes needed.
        bytes: u64,
        /// The device's limit.
        limit: u64,
    },
    /// More workgroups on one axis than the device dispatches.
    #[error(
        "a view of {extent:?} needs {groups} workgroups on one axis; the device dispatches at most {limit}"
    )]
    TooManyGroups {
        /// The extent.
        extent: [u32; 3],
        /// The workgroups needed.
        groups: u32,
        /// The device's limit.
        limit: u32,
    },
    /// The options cannot be.
    #[error("{0}")]
    Options(&'static str),
    /// What the scene is said to have cannot be.
    #[error(transparent)]
    Coverage(#[from] Contradiction),
    /// A texture that the coverage declares was not given.
    #[error("coverage is declared by a texture that was not given: {0}")]
    MissingTexture(&'static str),
    /// A texture of the coverage is smaller than the view.
    #[error("the coverage's {name} is {got:?} texels; the view needs {wanted:?}")]
    SmallTexture {
        /// Which.
        name: &'static str,
        /// Its size.
        got: [u32; 2],
        /// The least size.
        wanted: [u32; 2],
    },
    /// An origin that puts the view too far into its pictures.
    #[error("a view of {extent:?} at {origin:?} ends beyond 65536 pixels")]
    Origin {
        /// The origin.
        origin: [u32; 2],
        /// The extent.
        extent: [u32; 3],
    },
    /// wgpu does not bind a texture of the coverage: it is of another kind, lacks a usage, or belongs to another device.
    #[error("the coverage's textures cannot be bound: {0}")]
    Refused(String),
    /// Coverage is declared, and its textures are not known, or were of another extent.
    #[error(
        "the view's coverage declares textures: give them with `View::cover`, and again after each change of the extent"
    )]
    Uncovered,
    /// The device has too little for the kernels.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// The shading-rate image is of another size.
    #[error("the shading-rate image is {got:?} quads; the view is {wanted:?}")]
    WrongSri {
        /// The image's size.
        got: [u32; 2],
        /// The view's size.
        wanted: [u32; 2],
    },
}

/// Looks for options that no kernel can be made for.
fn check_options(options: &BuildOptions) -> Result<(), ViewError> {
    let [width, height] = options.tile;
    if width == 0 || height == 0 || width > 256 || height > 256 || width * height > 256 {
        return Err(ViewError::Options("a tile has 1 to 256 pixels"));
    }
    if options.for_tile(options.tile).largest != options.largest {
        return Err(ViewError::Options(
            "groups of the largest rate would lie across the edges of tiles of this size: let `BuildOptions::for_tile` choose it",
        ));
    }
    if options.is_odd() && (options.effective || options.modes.graded) {
        return Err(ViewError::Options(
            "effective rates and the graded buffer are by quads, which tiles with an odd side do not have: use another view for them",
        ));
    }
    if let Some(linear) = options.linear_depth {
        if options.coverage.depth.is_none() {
            return Err(ViewError::Options(
                "linear depth is made of the coverage's depth, which is not declared",
            ));
        }
        if !(linear.near > 0.0 && linear.far > linear.near && linear.far.is_finite()) {
            return Err(ViewError::Options(
                "the planes of linear depth have to be 0 < near < far",
            ));
        }
        let is_small = width <= 16 && height <= 16 && !options.is_odd();
        if !is_small || !options.largest.is_within(Rate::R2X2) {
            return Err(ViewError::Options(
                "entries have bits to spare for linear depth only where no group is larger than 2x2, and a tile's sides are even and at \
                 most 16",
            ));
        }
    }
    if !options.wave.is_power_of_two() || options.wave > 128 {
        return Err(ViewError::Options("a wave has 1, 2, 4 … 128 invocations"));
    }
    Ok(options.coverage.check()?)
}

pub(super) fn check(
    device: &wgpu::Device,
    extent: [u32; 3],
    options: &BuildOptions,
) -> Result<(), ViewError> {
    if extent.contains(&0) {
        return Err(ViewError::Empty(extent));
    }
    check_options(options)?;
    // what is counted in words has to stay below 2^32
    const MOST_PIXELS: u64 = 1 << 29;
    let pixels = u64::from(extent[0]) * u64::from(extent[1]);
    if pixels > MOST_PIXELS {
        return Err(ViewError::TooLarge {
            extent,
            bytes: pixels * 4,
            limit: MOST_PIXELS * 4,
        });
    }
    let limits = device.limits();
    let groups = [
        extent[0].div_ceil(options.tile[0]),
        extent[1].div_ceil(options.tile[1]),
        extent[2],
    ];
    let limit = limits.max_compute_workgroups_per_dimension;
    if let Some(&groups) = groups.iter().find(|&&groups| groups > limit) {
        return Err(ViewError::TooManyGroups {
            extent,
            groups,
            limit,
        });
    }
    let bytes = Sizes::new(options, [extent[0], extent[1]]).largest();
    let limit = limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size);
    match bytes > limit {
        true => Err(ViewError::TooLarge {
            extent,
            bytes,
            limit,
        }),
        false => Ok(()),
    }
}

/// Looks for textures of the coverage that are not there, or smaller than an extent. (Of a view of a smaller mip level only the
/// texture's own size is known.)
pub(super) fn check_textures(
    options: &BuildOptions,
    textures: &Textures,
    extent: [u32; 3],
    origin: [u32; 2],
) -> Result<(), ViewError> {
    if textures.sample.iter().any(|&at| at > textures.scale) {
        return Err(ViewError::Options(
            "the coverage's sample lies outside its pixel: `Textures::sample` is at most `Textures::scale`",
        ));
    }
    let coverage = &options.coverage;
    let octahedral = matches!(coverage.normals, Some(Normals::Octahedral { .. }));
    let all = [
        ("triangles", coverage.triangles, textures.triangles),
        ("surfaces", coverage.surfaces, textures.surfaces),
        ("depth", coverage.depth.is_some(), textures.depth),
        ("normals", octahedral, textures.normals),
    ];
    for (name, _, view) in all.into_iter().filter(|(_, is_declared, _)| *is_declared) {
        let texture = view.ok_or(ViewError::MissingTexture(name))?.texture();
        let got = [texture.width(), texture.height()];
        // an odd side's last pixel has only its first texel
        let texels = |pixels: u32| {
            (pixels - 1)
                .saturating_mul(textures.scale.saturating_add(1))
                .saturating_add(1)
        };
        let wanted = [0, 1].map(|axis| texels(origin[axis] + extent[axis]));
        if got[0] < wanted[0] || got[1] < wanted[1] {
            return Err(ViewError::SmallTexture { name, got, wanted });
        }
    }
    Ok(())
}
