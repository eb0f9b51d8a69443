//! What the analysis is told: one struct for each effect, with its source, units and ranges. `None` means that the effect
//! is not there at all: not compiled, not bound, not dispatched.

pub use super::granularity::Granularity;
use super::{half::HalfResolution, optics::Lens, own::OwnRates};
use crate::Rate;

/// How many differences become one error (§3.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", rename_all_fields = "kebab-case")
)]
pub enum Norm {
    /// Root mean square: Eq. 2.
    #[default]
    L2,
    /// Mean: what the GDC talk ships. On ramps its feedback gain is 1.
    L1,
    /// Maximum. Its feedback gain on ramps is 2 and 4.
    #[cfg_attr(feature = "cli", serde(rename = "linf"))]
    LInf,
    /// The root of the mean of halved differences: what Intel's VALAR calls a mean square. Of another unit than the threshold, so
    /// that t has to be 0.25 to 0.75.
    Root,
}

/// Which pairs of neighbours are looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", rename_all_fields = "kebab-case")
)]
pub enum Pairs {
    /// All: twelve on each axis of a quad's window. A shift by one pixel changes little (§3.1).
    #[default]
    All,
    /// GDC, pass 1: pairs across start where x + y is even, pairs down where it is odd. Six on each axis.
    Interleaved,
    /// Pairs that start at even x and even y: two on each axis.
    SubSampled,
    /// The quad's own: two on each axis (FidelityFX Variable Shading, without the diagonals of its range).
    Quad,
    /// Sobel's gradient at the quad's own pixels, as the difference from pixel to pixel: four on each axis (Monsho, Khronos' and
    /// Unreal's samples).
    Sobel,
}

/// What the difference of two pixels is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", rename_all_fields = "kebab-case")
)]
pub enum Difference {
    /// That of their luma: the paper's choice (§5.1). Edges of equal luma vanish.
    #[default]
    Luma,
    /// That of the channel that differs most.
    LargestChannel,
    /// The channels' differences, each without its sign, weighted as luma is (Eq. 25). Never below that of luma.
    Rgb,
}

/// What 8-bit codes mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", rename_all_fields = "kebab-case")
)]
pub enum Transfer {
    /// sRGB, exactly (IEC 61966-2-1).
    #[default]
    Srgb,
    /// The square: the GDC talk's approximation. Off by −48 % at 0.04, +17 % at 0.5.
    Square,
}

/// How brightness enters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", rename_all_fields = "kebab-case")
)]
pub enum Form {
    /// The threshold is t · (mean luma + l): Eq. 15.
    #[default]
    Window,
    /// Each pair is divided by its own brightness, |A − B| / (min(A, B) + BS), and the threshold is t: GDC, pass 1. BS is
    /// `sensitivity · (1 − saturate(50 L − 2.5))`, L the least luma of the window; in a tile, of the 3×3 pixels that a quad's pairs are of, in
    /// place of the talk's block of 2×4.
    Pairwise {
        /// C of the slide, in units of white; 0 to 1.
        sensitivity: f64,
    },
    /// The threshold is t, in units of white, bright or dark: FidelityFX and the Sobel filters.
    Absolute,
}

/// How much each channel counts for luma.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", rename_all_fields = "kebab-case")
)]
pub enum Weights {
    /// 0.299, 0.587 and 0.114: Eq. 25.
    #[default]
    Paper,
    /// 0.2126, 0.7152 and 0.0722: those of sRGB's primaries (ITU-R BT.709).
    Rec709,
}

impl Weights {
    /// The weights of red, green and blue, in 1/16384; their sum is 16384.
    pub const fn fixed(self) -> [u32; 3] {
        match self {
            Weights::Paper => super::fixed::WEIGHTS,
            Weights::Rec709 => [3483, 11_718, 1183],
        }
    }

    /// The weights of red, green and blue.
    pub const fn exact(self) -> [f64; 3] {
        match self {
            Weights::Paper => super::luma::WEIGHTS,
            Weights::Rec709 => [0.2126, 0.7152, 0.0722],
        }
    }
}

/// Content-adaptive shading (§3; GDC pass 1).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct Content {
    /// How differences are averaged.
    pub norm: Norm,
    /// Which differences.
    pub pairs: Pairs,
    /// Of what.
    pub difference: Difference,
    /// What 8-bit colour codes mean; linear pictures and √luma have no use for it.
    pub transfer: Transfer,
    /// How brightness enters.
    pub form: Form,
    /// What luma is.
    pub weights: Weights,
    /// t of Eq. 15, 0 to 15. The paper uses 0.15 at 76 pixels per degree; less for fewer.
    pub threshold: f64,
    /// l of Eq. 15, in units of white, 0 to 1. The paper uses 0.05.
    pub ambient: f64,
    /// k of Eq. 14, 1 to 15.
    pub k: f64,
    /// White of linear pictures as a power of two: what is brighter is in doubt, and so at full rate.
    pub white_log2: i32,
}

impl Default for Content {
    fn default() -> Content {
        Content {
            norm: Norm::L2,
            pairs: Pairs::All,
            difference: Difference::Luma,
            transfer: Transfer::Srgb,
            form: Form::Window,
            weights: Weights::Paper,
            threshold: 0.15,
            ambient: 0.05,
            k: 2.13,
            white_log2: 0,
        }
    }
}

/// What motion does to the error.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", rename_all_fields = "kebab-case")
)]
pub enum Blur {
    /// It is scaled by b_H and b_Q (Eq. 20 to 22).
    Scaled,
    /// It is scaled by straight lines, 1 − 0.0596 v and k − 0.1229 v, up to 16 pixels a frame and as there beyond: Intel's VALAR,
    /// whose lines fall below 0 at 17 pixels and make everything coarse.
    Linear,
    /// It is not looked at: b_H(v) < t / e alone decides (Eq. 23 and 24). What changes how much error is tolerated (stability, the
    /// extra half rate, transparents, foveation, overshoot, a safe area) has nothing to change then, and is refused; of materials,
    /// mirrors stay at full rate, and sensitivity does nothing.
    Standalone {
        /// e of Eq. 24: the largest relative error that the scene's materials make.
        error: f64,
    },
    /// It is not looked at: speed alone decides, by [`Ladder`] (Wicked Engine). Refuses what [`Blur::Standalone`] does.
    Ladder(Ladder),
}

/// Speeds from which on a rate is used, the larger axis deciding for both as in Wicked Engine, in pictures a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct Ladder {
    /// From this on 2x1.
    pub r2x1: f64,
    /// From this on 2x2.
    pub r2x2: f64,
    /// From this on 4x2.
    pub r4x2: f64,
    /// From this on 4x4.
    pub r4x4: f64,
}

impl Default for Ladder {
    /// Those of Wicked Engine: 0.001, 0.005, 0.01 and 0.1.
    fn default() -> Ladder {
        Ladder {
            r2x1: 0.001,
            r2x2: 0.005,
            r4x2: 0.01,
            r4x4: 0.1,
        }
    }
}

/// Motion-adaptive shading (§4). The speed is the least of the window, or tile, for each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct Motion {
    /// What it does.
    pub blur: Blur,
    /// The share of the speed that counts, 0 to 4: 1 for the paper, 0.5 for NVIDIA's sample.
    pub weight: f64,
    /// Pixels a frame for one unit of the motion vectors, on each axis. `[width, height]` for vectors in pictures,
    /// negative where they point from now to before.
    pub scale: [f64; 2],
}

impl Default for Motion {
    fn default() -> Motion {
        Motion {
            blur: Blur::Scaled,
            weight: 1.0,
            scale: [1.0, 1.0],
        }
    }
}

/// What is fetched along motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", rename_all_fields = "kebab-case")
)]
pub enum Fetch {
    /// The previous picture, for each pixel (§5.1).
    #[default]
    Pixel,
    /// What the previous picture's tiles of 16×16 pixels told, for each tile, by its furthest depth and the cameras, between the middles of
    /// four (GDC, passes 1 and 2): one rate a tile, by content, motion and materials. What a tile tells is the error and luma of its own
    /// pixels, as [`Granularity::Tile16`] has them.
    Tile,
}

/// The previous picture is fetched along motion (§5.1). Motion vectors, times their scale, point from where a surface was
/// to where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct Reprojection {
    /// What is fetched.
    pub fetch: Fetch,
    /// Where depth is had, a surface whose inverse depth differs from what was there by more than this share was hidden,
    /// and is shaded at full rate. Relative, so that the scene's scale does not matter. Infinite for no such test: then the previous depth
    /// is not bound.
    pub tolerance: f64,
    /// Whether depth 1 is near.
    pub reversed_z: bool,
    /// The near plane's distance divided by the far plane's; 0 for none.
    pub near_over_far: f64,
}

impl Default for Reprojection {
    fn default() -> Reprojection {
        Reprojection {
            fetch: Fetch::Pixel,
            tolerance: 0.1,
            reversed_z: true,
            near_over_far: 0.0,
        }
    }
}

/// Of which frame materials are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum MaterialsOf {
    /// Of this frame, where a prepass has them: looked up at the pixel.
    #[default]
    This,
    /// Of the previous frame's G-buffer, as NVIDIA has them (§5.4; GDC, pass 1): fetched along motion with its colour, by tiles
    /// ([`Fetch::Tile`]) with their data, rounded to the shinier. Of the size of the previous picture.
    Previous,
}

/// Smooth metals are more sensitive in slow motion, and mirrors always (GDC, pass 2, problems 1 and 2). A quad, or a tile, has the most
/// smoothness · Rf0 of its pixels ("Find max smoothness and specular reflectance"); of all of them, where the talk looks at four of eight.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct Materials {
    /// The tolerance at smoothness · Rf0 = 1 and no motion, as a share; 0 to 1.
    pub least: f64,
    /// Where motion is this fast, in pixels a frame, materials no longer matter.
    pub slow: f64,
    /// From this smoothness · Rf0 on, always full rate; above 1 for never.
    pub mirror: f64,
    /// Of which frame they are.
    pub of: MaterialsOf,
}

impl Default for Materials {
    fn default() -> Materials {
        Materials {
            least: 0.5,
            slow: 4.0,
            mirror: 0.8,
            of: MaterialsOf::This,
        }
    }
}

/// What keeps the loop from rates to picture to rates from swinging (§5.4).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", rename_all_fields = "kebab-case")
)]
pub enum Stability {
    /// Nothing.
    #[default]
    None,
    /// t is t (1 + ε) for a rate that the previous frame had, t (1 − ε) for a coarser one, ε from the norm and
    /// the window or tile: [`epsilon`](super::hysteresis::epsilon). An attachment of tiles beside rates of quads has the quads'.
    Hysteresis,
    /// The error is divided by what the previous frame's rate made of it on a ramp:
    /// [`swell`](super::hysteresis::swell).
    Compensate,
}

/// The extra half rate (DOOM: The Dark Ages, "Noise is from Hell!"): what is coarse on both axes is judged again, with
/// less tolerance, and may become coarse on one axis only; never 1x1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct HalfRate {
    /// The tolerance of the second look, as a share; 0 to 1. With a noise mask, this is where the mask is 1, and less
    /// of it the less the mask.
    pub tolerance: f64,
    /// In this much motion of the slowest pixel, in pixels a frame on both axes, it is left out; infinity for never.
    pub fast: f64,
}

impl Default for HalfRate {
    fn default() -> HalfRate {
        HalfRate {
            tolerance: 0.5,
            fast: f64::INFINITY,
        }
    }
}

/// Less tolerance in the middle than outside, tied to the dynamic resolution (DOOM: "Foveated Shading Rate linked to DRS"). A tile is as near as
/// the nearest of its quads.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct Foveation {
    /// Where one looks, 0 to 1 on each axis.
    pub centre: [f64; 2],
    /// Tolerance over the distance from there, in units of half the picture's height: pairs of distance and factor, in
    /// order, linear between, constant outside. At full effect.
    pub falloff: Vec<[f64; 2]>,
    /// The share of the effect over the scale of the dynamic resolution, 0 to 1: pairs as before.
    pub strength: Vec<[f64; 2]>,
}

impl Default for Foveation {
    /// As in DOOM: nothing above 75 % of the resolution, all of it at half.
    fn default() -> Foveation {
        Foveation {
            centre: [0.5, 0.5],
            falloff: vec![[0.5, 1.0], [1.75, 2.5]],
            strength: vec![[0.5, 1.0], [0.75, 0.0]],
        }
    }
}

impl Foveation {
    /// The factor at a distance from the centre, in units of half the picture's height.
    pub fn tolerance(&self, distance: f64, resolution_scale: f64) -> f64 {
        let strength = match self.strength.is_empty() {
            true => 1.0,
            false => curve(&self.strength, resolution_scale).clamp(0.0, 1.0),
        };
        1.0 + (curve(&self.falloff, distance) - 1.0) * strength
    }
}

/// More tolerance at the picture's border (DOOM: "Increased Shading Rate tolerance in 'Safe Area'"). Not forced to 2x2. A tile
/// that reaches out of the border is not in it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct SafeArea {
    /// The border's width in pixels.
    pub width: u32,
    /// The tolerance there, as a factor of 1 or more.
    pub tolerance: f64,
}

impl Default for SafeArea {
    fn default() -> SafeArea {
        SafeArea {
            width: 16,
            tolerance: 1.25,
        }
    }
}

/// Limits between neighbours (§5.4; GDC pass 3): of quads, or of tiles where rates are of tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", rename_all_fields = "kebab-case")
)]
pub enum Smoothing {
    /// None.
    #[default]
    None,
    /// On each axis, 4 next to 1 becomes 2.
    Limit,
    /// On each axis, the mean of the 3×3 quads, no quad counted as coarser than the middle one, rounded to fine: only fine
    /// spreads into coarse.
    Conservative,
}

/// All of it. The default is the paper's content-adaptive shading alone.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct Settings {
    /// Content.
    pub content: Content,
    /// Motion.
    pub motion: Option<Motion>,
    /// Whether a later blur (depth of field, motion blur) hides coarse shading as motion of its width does: Eq. 17 with the
    /// post-filter's box (DOOM, "Post Process Blurs"). Needs [`Settings::motion`], by [`Blur::Scaled`].
    pub later_blur: bool,
    /// The same by a depth of field that is worked out here, from this frame's depth: for renderers whose own is not ready in time. Needs
    /// depth, and [`Settings::motion`] by the scalers.
    pub lens: Option<Lens>,
    /// Reprojection; needs motion vectors, or cameras and depth.
    pub reprojection: Option<Reprojection>,
    /// Materials.
    pub materials: Option<Materials>,
    /// Hysteresis; needs the previous frame's rates.
    pub stability: Stability,
    /// The extra half rate.
    pub half_rate: Option<HalfRate>,
    /// Whether there are two pictures, before and after transparents. A solid takes the coarser of both rates; the
    /// attachment takes that of the second.
    pub transparents: bool,
    /// Foveation.
    pub foveation: Option<Foveation>,
    /// Quality overshoot: tolerance over the scale of the dynamic resolution, pairs as in [`Foveation::falloff`]; empty
    /// for none. DOOM raises quality above 85 %.
    pub overshoot: Vec<[f64; 2]>,
    /// The safe area.
    pub safe_area: Option<SafeArea>,
    /// Limits between neighbours.
    pub smoothing: Smoothing,
    /// The application's own rates, combined with what is found after all else.
    pub own: Option<OwnRates>,
    /// Also rates of half the resolution, for passes that run at it.
    pub half_resolution: Option<HalfResolution>,
    /// The coarsest rate. 4x4 is replaced by 2x4 or 4x2 unless this is 4x4.
    pub largest: Rate,
    /// What has one estimate and one rate.
    pub granularity: Granularity,
    /// The same of the hardware's attachment, for a scene that [wants one](crate::Scene::attachment): by default the hardware's tile, over
    /// whose own pixels the paper's estimate is. [`Granularity::Quad`] for the finest of the tile's quads, which costs nothing beside
    /// the rates and is finer. Not looked at where the rates are of tiles: then it has theirs.
    pub attachment: Granularity,
}

impl Settings {
    /// Whether the stage goes by tiles.
    pub fn is_by_tiles(&self) -> bool {
        self.reprojection
            .is_some_and(|reprojection| reprojection.fetch == Fetch::Tile)
    }

    /// What has one rate of compute passes: that of [`Fetch::Tile`], too.
    pub fn granularity_of_rates(&self) -> Granularity {
        match self.is_by_tiles() {
            true => Granularity::Tile16,
            false => self.granularity,
        }
    }

    /// What has one rate of the hardware's attachment.
    pub fn granularity_of_attachment(&self) -> Granularity {
        match self.granularity_of_rates() {
            Granularity::Quad => self.attachment,
            tile => tile,
        }
    }

    /// Whether materials are those of the frame before.
    pub(crate) fn has_materials_before(&self) -> bool {
        self.materials
            .is_some_and(|materials| materials.of == MaterialsOf::Previous)
    }

    /// Whether motion alone decides, whatever the content: [`Blur::Standalone`] or [`Blur::Ladder`].
    pub fn is_by_motion_alone(&self) -> bool {
        self.motion
            .is_some_and(|motion| matches!(motion.blur, Blur::Standalone { .. } | Blur::Ladder(_)))
    }

    /// The first effect that changes how much of the content's error is tolerated: where motion alone decides, it would change nothing.
    pub(crate) fn first_of_content(&self) -> Option<&'static str> {
        let all = [
            (self.stability != Stability::None, "stability"),
            (self.half_rate.is_some(), "the extra half rate"),
            (self.transparents, "transparents"),
            (self.foveation.is_some(), "foveation"),
            (!self.overshoot.is_empty(), "quality overshoot"),
            (self.safe_area.is_some(), "a safe area"),
        ];
        all.into_iter()
            .find(|effect| effect.0)
            .map(|effect| effect.1)
    }

    /// Whether what was hidden is told apart by depth.
    pub fn tests_depth(&self) -> bool {
        self.reprojection
            .is_some_and(|reprojection| reprojection.tolerance < f64::INFINITY)
    }

    /// The first effect that cannot be had by [`Fetch::Tile`].
    pub(crate) fn first_by_pixel(&self) -> Option<&'static str> {
        let has_own = ![Granularity::Quad, Granularity::Tile16].contains(&self.granularity);
        let all = [
            (has_own, "another granularity than 16x16"),
            (self.later_blur || self.lens.is_some(), "a later blur"),
            (self.stability != Stability::None, "stability"),
            (self.half_rate.is_some(), "the extra half rate"),
            (self.transparents, "transparents"),
            (self.foveation.is_some(), "foveation"),
            (self.safe_area.is_some(), "a safe area"),
        ];
        all.into_iter()
            .find(|effect| effect.0)
            .map(|effect| effect.1)
    }
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            content: Content::default(),
            motion: None,
            later_blur: false,
            lens: None,
            reprojection: None,
            materials: None,
            stability: Stability::None,
            half_rate: None,
            transparents: false,
            foveation: None,
            overshoot: Vec::new(),
            safe_area: None,
            smoothing: Smoothing::None,
            own: None,
            half_resolution: None,
            largest: Rate::R2X2,
            granularity: Granularity::Quad,
            attachment: Granularity::Tile16,
        }
    }
}

/// A curve of pairs at a place: linear between, constant outside; 1 for a curve without points.
pub fn curve(points: &[[f64; 2]], x: f64) -> f64 {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return 1.0;
    };
    // what is no number is at the first point
    if x.is_nan() || x <= first[0] {
        return first[1];
    }
    points
        .windows(2)
        .find(|pair| x <= pair[1][0])
        .map_or(last[1], |pair| {
            let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
            y0 + (y1 - y0) * (x - x0) / (x1 - x0)
        })
}
