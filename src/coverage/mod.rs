//! Coverage: which pixels of a block may share one result, from whatever the scene has.
//!
//! A low shading rate alone would smear one surface over another. DOOM: The Dark Ages shares where the visible triangle is
//! the same, lets ~coplanar neighbours share ("Remove Overshading of ~Co-planar Triangle Edges"), and proposes surfaces in
//! place of triangles: `shareShading = lowRate && zClose && (surfID == adjSurfID)` ("Not Co-planar Triangles, but 'Same
//! Surface' Triangles"). Here a scene [declares](Coverage) what it has, and the rule is made of that; nothing is compiled
//! or bound for what it has not. If nothing is declared, the rate alone decides.
//!
//! | declared | two pixels share if |
//! |---|---|
//! | triangles | the triangle is the same |
//! | triangles, depth, normals | the triangle is the same, or both lie in one plane: normals and depth are close |
//! | triangles, surfaces | the triangle is the same, or the surface |
//! | surfaces | the surface is the same |
//! | depth | each lies in the plane through the other |
//! | normals | the normals are close |
//! | sky | both are sky, or neither |
//!
//! All that are declared have to agree, but for pixels of one triangle, which always share.
//!
//! **Depth** is compared as inverse depth, in which a plane stays a plane on the screen: a floor that recedes steeply is one
//! plane, not a row of steps. The slope at a pixel is the smaller of its differences to either side, so a silhouette does not
//! tilt the plane. The tolerance is relative (`|Δ(1/z)| ≤ 2⁻ᵗ / z`), so a scene may be of any scale.
//!
//! **Exactness.** Inverse depth is cut to 16 significant bits when it is loaded, tolerances are powers of two, and normals are
//! compared as integers; so what is compared is exact on every driver, but for the division that linear depth needs and for
//! rebuilt normals, which may differ by one step. [`cpu`] is the twin.

pub mod cpu;

/// What a scene has that tells surfaces apart. The default has nothing: the rate alone decides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// A texture of triangle numbers (`r32uint`): a visibility buffer.
    pub triangles: bool,
    /// A texture of surface numbers (any unsigned integers).
    pub surfaces: bool,
    /// A texture of depth.
    pub depth: Option<Depth>,
    /// Normals.
    pub normals: Option<Normals>,
    /// What is sky; nothing is if not given.
    pub sky: Option<Sky>,
}

/// A depth texture: its meaning, and how close is close.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depth {
    /// What its values mean.
    pub kind: DepthKind,
    /// The tolerance: 2 to the minus this, relative to inverse depth. 1 to 20; 7 is about 1 %.
    pub tolerance: u32,
}

impl Depth {
    /// Depth of a kind, with a tolerance of 2⁻⁷.
    pub fn new(kind: DepthKind) -> Depth {
        Depth { kind, tolerance: 7 }
    }

    /// Why it makes no sense, if it does not.
    pub(crate) fn check(&self) -> Result<(), &'static str> {
        if !(1..=20).contains(&self.tolerance) {
            return Err("the depth tolerance has to be 1 to 20");
        }
        if let DepthKind::ReversedFinite { near, far } | DepthKind::Standard { near, far } =
            self.kind
            && !(near > 0.0 && far > near && far.is_finite())
        {
            return Err("the planes of depth have to be 0 < near < far");
        }
        Ok(())
    }
}

/// What a depth texture's values mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DepthKind {
    /// 1 at the near plane, 0 at an infinite far plane; sky is 0.
    Reversed,
    /// 1 at the near plane, 0 at the far plane; sky is 0.
    ReversedFinite {
        /// The near plane's distance.
        near: f32,
        /// The far plane's distance.
        far: f32,
    },
    /// 0 at the near plane, 1 at the far plane; sky is 1.
    Standard {
        /// The near plane's distance.
        near: f32,
        /// The far plane's distance.
        far: f32,
    },
    /// The distance itself; sky is what is no further than 0, or not finite.
    Linear,
}

impl DepthKind {
    /// The factor and the summand that make a value proportional to inverse depth; `None` if it has to be inverted.
    pub(crate) fn to_inverse(self) -> Option<[f32; 2]> {
        match self {
            DepthKind::Reversed => Some([1.0, 0.0]),
            DepthKind::ReversedFinite { near, far } => Some([1.0, near / (far - near)]),
            DepthKind::Standard { near, far } => Some([-1.0, far / (far - near)]),
            DepthKind::Linear => None,
        }
    }
}

/// Where normals come from, and how close is close: two normals are close if the square of the sine between them is at most
/// 2 to the minus `tolerance` (1 to 14; 4 is 14.5°, 6 is 7.2°).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Normals {
    /// A texture of octahedral normals, two components of 0 to 1.
    Octahedral {
        /// The tolerance.
        tolerance: u32,
    },
    /// Rebuilt from triangles and depth: the plane through three pixels of one triangle, not in a line, among a pixel and its
    /// eight neighbours; none if there are no three, and then the pixel is in no plane (the slides' way, "not great, not
    /// terrible"). Needs both.
    Rebuilt {
        /// The tolerance.
        tolerance: u32,
        /// The tangents of half the angles of view, across and down.
        tangents: [f32; 2],
    },
}

impl Normals {
    pub(crate) fn tolerance(self) -> u32 {
        match self {
            Normals::Octahedral { tolerance } | Normals::Rebuilt { tolerance, .. } => tolerance,
        }
    }
}

/// What is sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sky {
    /// Where the depth is that of sky, see [`DepthKind`].
    Depth,
    /// Where the triangle has this number.
    Triangle(u32),
    /// Where the surface has this number.
    Surface(u32),
}

/// Why a declaration makes no sense.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("coverage: {0}")]
pub struct Contradiction(pub(crate) &'static str);

impl Coverage {
    /// Whether the rate alone decides.
    pub fn is_empty(&self) -> bool {
        *self == Coverage::default()
    }

    /// Looks for what cannot be.
    ///
    /// # Errors
    /// If something needs what is not declared, or a tolerance is out of range.
    pub fn check(&self) -> Result<(), Contradiction> {
        let err = |what| Err(Contradiction(what));
        match self.sky {
            Some(Sky::Depth) if self.depth.is_none() => {
                return err("sky is told by depth, which is not declared");
            }
            Some(Sky::Triangle(_)) if !self.triangles => {
                return err("sky is told by triangles, which are not declared");
            }
            Some(Sky::Surface(_)) if !self.surfaces => {
                return err("sky is told by surfaces, which are not declared");
            }
            _ => {}
        }
        if let Some(depth) = self.depth {
            depth.check().map_err(Contradiction)?;
        }
        if let Some(normals) = self.normals {
            if !(1..=14).contains(&normals.tolerance()) {
                return err("the normals' tolerance has to be 1 to 14");
            }
            if let Normals::Rebuilt { tangents, .. } = normals {
                if !self.triangles || self.depth.is_none() {
                    return err("normals are rebuilt from triangles and depth; declare both");
                }
                if !tangents.iter().all(|t| *t > 0.0 && t.is_finite()) {
                    return err("the tangents of the angles of view have to be positive");
                }
            }
        }
        Ok(())
    }

    /// The names that the kernel's text is composed with.
    pub(crate) fn defs(&self) -> Vec<(&'static str, u32)> {
        let mut defs = Vec::new();
        let mut def = |name, on| {
            if on {
                defs.push((name, 1));
            }
        };
        def("COVERAGE", !self.is_empty());
        def("TRIANGLES", self.triangles);
        def("SURFACES", self.surfaces);
        def("DEPTH", self.depth.is_some());
        def(
            "LINEAR",
            self.depth
                .is_some_and(|depth| depth.kind == DepthKind::Linear),
        );
        def(
            "STANDARD",
            self.depth
                .is_some_and(|depth| matches!(depth.kind, DepthKind::Standard { .. })),
        );
        def("NORMALS", self.normals.is_some());
        def(
            "REBUILT",
            matches!(self.normals, Some(Normals::Rebuilt { .. })),
        );
        def(
            "OCTAHEDRAL",
            matches!(self.normals, Some(Normals::Octahedral { .. })),
        );
        def("SKY", self.sky.is_some());
        def("SKY_DEPTH", self.sky == Some(Sky::Depth));
        def("SKY_TRIANGLE", matches!(self.sky, Some(Sky::Triangle(_))));
        def("SKY_SURFACE", matches!(self.sky, Some(Sky::Surface(_))));
        defs
    }
}

/// The textures that were declared, of the view's size (or [`scale`](Textures::scale) times that).
#[derive(Clone, Copy, Debug, Default)]
pub struct Textures<'t> {
    /// Triangle numbers: an integer texture.
    pub triangles: Option<&'t wgpu::TextureView>,
    /// Surface numbers: an integer texture.
    pub surfaces: Option<&'t wgpu::TextureView>,
    /// Depth: a depth texture (its depth aspect) or one of 32-bit floats.
    pub depth: Option<&'t wgpu::TextureView>,
    /// Octahedral normals.
    pub normals: Option<&'t wgpu::TextureView>,
    /// Texels a pixel on each axis, less 1: 0 for textures of the view's own size, 1 for a view of half their size.
    pub scale: u32,
    /// Which texel stands for a pixel, on each axis at most `scale`: the sample that a half-size pass shades. Where a side is odd, the
    /// last pixel has only its first.
    pub sample: [u32; 2],
}
