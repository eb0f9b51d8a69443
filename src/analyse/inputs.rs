//! What the analysis is given and what it gives, in memory.

use super::{optics::Cameras, settings::Settings};
use crate::sri::Sri;

/// A picture's colour, row by row.
#[derive(Clone, Copy, Debug)]
pub enum Colour<'a> {
    /// 8-bit codes; [`Transfer`](super::settings::Transfer) says of what.
    Codes(&'a [[u8; 4]]),
    /// Linear light.
    Linear(&'a [[f32; 4]]),
    /// 8-bit √luma, `round(255 √luma)`, as the analysis itself and the deblocker write it.
    SqrtLuma(&'a [u8]),
}

impl Colour<'_> {
    /// The number of pixels.
    pub fn len(&self) -> usize {
        match self {
            Colour::Codes(pixels) => pixels.len(),
            Colour::Linear(pixels) => pixels.len(),
            Colour::SqrtLuma(pixels) => pixels.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Bits of a pixel's flags.
pub mod flags {
    /// The pixel does not move with the world (a hand weapon): its motion does not count (§5.2).
    pub const STATIC: u8 = 1;
    /// No extra half rate here (foliage).
    pub const NO_HALF_RATE: u8 = 2;
    /// Full rate, whatever is found (alpha-tested surfaces, a HUD).
    pub const FULL: u8 = 4;
    /// A particle: its rate is stated by [`OwnRates`](crate::analyse::OwnRates).
    pub const PARTICLE: u8 = 8;
}

/// What changes from frame to frame beside pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The size of the picture to shade.
    pub size: [u32; 2],
    /// The size of the previous frame's pictures.
    pub previous_size: [u32; 2],
    /// Whether there is a previous frame that shows the same scene: not at first, and not after a cut.
    pub has_history: bool,
    /// The scale of the dynamic resolution, above 0 to 1.
    pub resolution_scale: f64,
    /// Both frames' cameras, for a scene whose motion is the camera's; without, that scene is in doubt.
    pub cameras: Option<Cameras>,
    /// Where the view's first pixel lies in this frame's pictures (motion, depth, materials, masks), for a scene that
    /// [declares](crate::Scene::origin) it: of a split screen, say. What the analysis writes starts at the view's first pixel.
    pub origin: [u32; 2],
    /// The same in the previous frame's pictures. Previous rates and √luma are the view's own, and have no origin.
    pub previous_origin: [u32; 2],
}

impl Frame {
    /// A frame whose predecessor had its size.
    pub fn of_size(size: [u32; 2]) -> Frame {
        Frame {
            size,
            previous_size: size,
            has_history: true,
            resolution_scale: 1.0,
            cameras: None,
            origin: [0; 2],
            previous_origin: [0; 2],
        }
    }

    /// A frame of a [view](crate::View): of its extent, at its [origin](crate::View::origin), both as they were in the frame before.
    pub fn of_view(view: &crate::View) -> Frame {
        let [width, height, _] = view.extent();
        Frame {
            origin: view.origin(),
            previous_origin: view.origin(),
            ..Frame::of_size([width, height])
        }
    }

    /// Frame `number` of a sequence in which the size stays and nothing is cut: there is history but at frame 0.
    pub fn numbered(size: [u32; 2], number: u32) -> Frame {
        Frame {
            has_history: number > 0,
            ..Frame::of_size(size)
        }
    }
}

/// One frame's inputs. What the settings do not call for is not looked at. All are row by row.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// The picture to shade: width and height.
    pub size: [u32; 2],
    /// The size of the pictures of the previous frame: `colour`, `after`, `previous_depth` and `previous_rates`.
    pub previous_size: [u32; 2],
    /// Whether there is a previous frame that shows the same scene. Without, all is at full rate.
    pub has_history: bool,
    /// The previous frame's final colour; before transparents, if `after` is had.
    pub colour: Colour<'a>,
    /// The previous frame's final colour after transparents.
    pub after: Option<Colour<'a>>,
    /// This frame's motion vectors.
    pub motion: Option<&'a [[f32; 2]]>,
    /// This frame's depth, 0 to 1.
    pub depth: Option<&'a [f32]>,
    /// How wide a later blur is at each pixel, in pixels: a circle of confusion, or an engine's motion blur.
    pub blur: Option<&'a [f32]>,
    /// The previous frame's depth.
    pub previous_depth: Option<&'a [f32]>,
    /// The previous frame's rates.
    pub previous_rates: Option<&'a Sri>,
    /// Smoothness and Rf0 of surfaces, 255 for 1: of this frame's, or of the previous frame's, as
    /// [`Materials::of`](super::settings::Materials::of) says.
    pub materials: Option<&'a [[u8; 2]]>,
    /// Where noise is, 255 for most.
    pub noise: Option<&'a [u8]>,
    /// The material or object of each pixel, for rates that the application states.
    pub ids: Option<&'a [u8]>,
    /// [`flags`] of each pixel.
    pub flags: Option<&'a [u8]>,
    /// The scale of the dynamic resolution, above 0 to 1.
    pub resolution_scale: f64,
    /// Both frames' cameras: with `depth`, the motion where there are no vectors.
    pub cameras: Option<Cameras>,
}

impl<'a> Inputs<'a> {
    /// A frame of which only the colour is known.
    pub fn of_colour(size: [u32; 2], colour: Colour<'a>) -> Inputs<'a> {
        Inputs {
            size,
            previous_size: size,
            has_history: true,
            colour,
            after: None,
            motion: None,
            depth: None,
            blur: None,
            previous_depth: None,
            previous_rates: None,
            materials: None,
            noise: None,
            ids: None,
            flags: None,
            resolution_scale: 1.0,
            cameras: None,
        }
    }

    /// The frame.
    pub fn frame(&self) -> Frame {
        Frame {
            size: self.size,
            previous_size: self.previous_size,
            has_history: self.has_history,
            resolution_scale: self.resolution_scale,
            cameras: self.cameras.filter(|_| self.motion.is_none()),
            origin: [0; 2],
            previous_origin: [0; 2],
        }
    }

    /// Whether every input has its size; materials, that of this frame.
    ///
    /// # Errors
    /// The first that has not.
    pub fn check(&self) -> Result<(), WrongInput> {
        self.check_for(&Settings::default())
    }

    /// The same under settings, which say of which frame materials are.
    pub(crate) fn check_for(&self, settings: &Settings) -> Result<(), WrongInput> {
        let count = |[w, h]: [u32; 2]| w as usize * h as usize;
        let (now, before) = (count(self.size), count(self.previous_size));
        let found = [
            ("colour", Some(self.colour.len()), before),
            (
                "colour after transparents",
                self.after.map(|c| c.len()),
                before,
            ),
            ("motion", self.motion.map(<[_]>::len), now),
            ("blur", self.blur.map(<[_]>::len), now),
            ("depth", self.depth.map(<[_]>::len), now),
            (
                "previous depth",
                self.previous_depth.map(<[_]>::len),
                before,
            ),
            (
                "materials",
                self.materials.map(<[_]>::len),
                match settings.has_materials_before() {
                    true => before,
                    false => now,
                },
            ),
            ("noise", self.noise.map(<[_]>::len), now),
            ("ids", self.ids.map(<[_]>::len), now),
            ("flags", self.flags.map(<[_]>::len), now),
        ];
        if now == 0 || before == 0 {
            return Err(WrongInput::Empty);
        }
        if self
            .size
            .iter()
            .chain(&self.previous_size)
            .any(|&side| side > 16_384)
        {
            return Err(WrongInput::TooLarge);
        }
        match found
            .into_iter()
            .find(|(_, got, want)| got.is_some_and(|got| got != *want))
        {
            Some((name, got, wanted)) => Err(WrongInput::Length {
                name,
                got: got.unwrap_or_default(),
                wanted,
            }),
            None => Ok(()),
        }
    }
}

/// Inputs that do not fit together.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WrongInput {
    /// A picture without pixels.
    #[error("a picture has no pixels")]
    Empty,
    /// A side above 16384.
    #[error("a picture has a side above 16384 pixels")]
    TooLarge,
    /// An input of the wrong length.
    #[error("{name} has {got} pixels; its picture has {wanted}")]
    Length {
        /// Which.
        name: &'static str,
        /// Its pixels.
        got: usize,
        /// The picture's.
        wanted: usize,
    },
    /// An effect that a stage by tiles has not.
    #[error("{0} cannot be had where the previous picture is fetched by tiles of 16x16 pixels")]
    ByTiles(&'static str),
    /// An effect that changes how much of the content's error is tolerated, where motion alone decides.
    #[error("{0} changes how much of the content's error is tolerated, and motion alone decides")]
    MotionAlone(&'static str),
    /// The settings call for an input that is not there.
    #[error("the settings call for {0}, which is not given")]
    Missing(&'static str),
}

/// A frame that cannot be analysed with what is bound.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// A picture without pixels, or with a side above 16384.
    #[error("the frame's {what} is {size:?} pixels; a side has 1 to 16384")]
    Size {
        /// Which size.
        what: &'static str,
        /// What it is.
        size: [u32; 2],
    },
    /// The frame is of another size than the view whose rates are written.
    #[error("the frame is {frame:?} pixels and the view {view:?}: give `Frame` the view's size")]
    View {
        /// The frame's size.
        frame: [u32; 2],
        /// The view's.
        view: [u32; 2],
    },
    /// The frame lies at another place in its pictures than the view.
    #[error(
        "the frame's origin in its pictures is {frame:?} and the view's {view:?}: make it by `Frame::of_view`, or set `View::set_origin`"
    )]
    Origin {
        /// The frame's origin.
        frame: [u32; 2],
        /// The view's.
        view: [u32; 2],
    },
    /// The frame has an origin, and the analysis was planned without.
    #[error(
        "the frame lies at {0:?} in its pictures, and the analysis was planned for pictures of the view's own: declare `Scene::origin`"
    )]
    NoOrigin([u32; 2]),
    /// The view has made its buffers anew, or is another one.
    #[error(
        "the analyser is bound to rates that are not this view's: call `Analyser::bind` after `View::set_extent`, with this frame's pictures"
    )]
    Stale,
    /// The scale of the dynamic resolution is no number above 0, up to 1.
    #[error("the resolution's scale is {0}; it is above 0 and at most 1")]
    Scale(f64),
    /// A texture is smaller than the frame says.
    #[error(
        "the texture of {what} is {got:?} texels, and the frame needs {wanted:?}: bind the one that was made for its size"
    )]
    Texture {
        /// Which.
        what: &'static str,
        /// Its size.
        got: [u32; 2],
        /// The least size.
        wanted: [u32; 2],
    },
    /// A buffer is smaller than the frame needs.
    #[error(
        "the buffer of {what} has {got} bytes, and the frame needs {wanted}: bind one that was made for its size"
    )]
    Buffer {
        /// Which.
        what: &'static str,
        /// Its bytes.
        got: u64,
        /// The least.
        wanted: u64,
    },
}

impl Frame {
    /// Whether the frame makes sense by itself.
    ///
    /// # Errors
    /// A size or the scale.
    pub fn check(&self) -> Result<(), FrameError> {
        for (what, size) in [("size", self.size), ("previous size", self.previous_size)] {
            if size.iter().any(|side| !(1..=16_384).contains(side)) {
                return Err(FrameError::Size { what, size });
            }
        }
        match self.resolution_scale > 0.0 && self.resolution_scale <= 1.0 {
            true => Ok(()),
            false => Err(FrameError::Scale(self.resolution_scale)),
        }
    }
}

/// What the analysis finds.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// The rates for compute passes.
    pub sri: Sri,
    /// The rates for the hardware attachment: from the luma after transparents, without the extra half rate.
    pub attachment: Sri,
    /// The rates without the extra half rate, otherwise as `sri`: for passes that add no noise, as DOOM's deferred texturing.
    pub plain: Sri,
    /// The rates of half the resolution, if they are asked for.
    pub half: Option<Sri>,
    /// √luma of the previous picture (after transparents, if told apart), four pixels to a word, rows padded to 256 bytes.
    pub sqrt_luma: Vec<u8>,
    /// Why each quad is as fine as it is: [`Reason`](super::reasons::Reason)s, in the form of `sri`.
    pub reasons: Vec<u8>,
}
