//! The deblock stage: removes the half-pixel offset that copies leave.
//!
//! *Does*: gives every duplicate the value that lies between its own group's primary and the neighbouring groups'. *Needs*: the picture
//! after all passes that copy, before transparency (slides, "Activision's Deblocker"); the effective rates; optionally depth and surface
//! numbers. *Guarantees*: no race, so the same picture in every run; every result lies between the values that it was made of;
//! full-rate quads and all primaries keep their bits. *Refuses*: formats that it cannot store.
//!
//! # Where the taps lie
//!
//! A group of W×H pixels holds the value f(s) of one sample s, its primary; the copy puts it at every pixel p of the group. On a
//! ramp f(x) = x that is wrong by s − p: at 2x1 with the first pixel as primary by 0 and −1, half a pixel in the mean. (The
//! hardware samples the middle and is wrong by ½ and −½: no offset. Hence the slides' "half pixel offset".) All members of a group
//! are equal, so an average *within* it does nothing: a useful filter reads the neighbouring group. The value that belongs at p
//! lies between s and the next sample n on p's side of s; linearly, it is
//!
//! `f(p) ≈ f(s) + (f(n) − f(s)) · |p − s| / |n − s|`
//!
//! For groups of equal rate |n − s| = W. At 2x1 that is the mean of a pixel and its right neighbour: "average two pixels
//! horizontally". At 1x2 it is the mean of two vertically. At 2x2, bilinear, the pixel opposite to the primary gets the mean of
//! the four pixels around its corner, and its neighbours the mean of two. 4 wide, the weights are ¼, ½ and ¾. Where the
//! neighbour has another rate its sample is nearer or farther; both samples' places are known, so the weight is right there
//! too. If primaries rotate from frame to frame, s moves to the group's last pixel, and the same formula reads the neighbour on the
//! other side.
//!
//! # Why nothing races
//!
//! The slides read and write one picture and accept the race ("pixels changing value which have yet to be used as
//! inputs"). Here p = s has weight 0: **samples are never written, and nothing but samples is read across groups.** What is read
//! and what is written are disjoint, so the filter may run in place in one dispatch, without a copy, halo or schedule, and
//! is bit-identical in every run.
//!
//! Core WebGPU reads and writes a texture in one shader only in formats of one 32-bit channel. [`Way`] tells what was chosen: in
//! place in a storage buffer, an `r32uint` texture, or any format for which the adapter has read-write storage; else the
//! filter writes a scratch texture and a second dispatch returns what it wrote. In either way only coarse quads and
//! their taps are touched, and the result is in the caller's picture.
//!
//! # What may blend
//!
//! The slides let the filter spill over all edges: right inside a surface ("deblock spec highlight across triangle edge"), wrong
//! at its silhouette, and name the fix: "dissimilar depth". Here a tap counts if it has the pixel's surface number and each of
//! the two lies in the plane through the other; what was not declared is not compiled. A tap that does not count is replaced by
//! the pixel's own value. Triangle numbers are not asked for: edges inside a surface do blend. Where coverage split a
//! block, a pixel's group is told by equality with its neighbour in the quad.
//!
//! A tap that is not finite (or is 2¹²⁶ or more) never counts, and a pixel that is not finite keeps its value: NaN and
//! infinity do not spread at all, and [`Counters`] report them. Alpha is not filtered.
//!
//! # What is stored
//!
//! Packed pixels are rounded by the filter itself, to the nearest. In a texture the driver rounds: for `rgba8unorm`, Vulkan asks
//! for one of the two nearest codes, and D3D12 for one within 0.6 of a code; an H100 was seen to take 2 for 2.55. So
//! pictures in textures may differ between drivers by one code where a value was filtered, and are the same in every run of one.

pub mod cpu;
pub mod gpu;
mod pack;

pub use crate::{
    analyse::{
        params::luma_pitch,
        settings::{Transfer, Weights},
    },
    coverage::{Depth, DepthKind},
};
pub use gpu::{Bound, Deblocker, Inputs, PictureInput};
pub use pack::Packing;

/// What to deblock, and with what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Where the picture is.
    pub picture: Picture,
    /// Depth, to tell surfaces apart.
    pub depth: Option<Depth>,
    /// Whether there are surface numbers, to tell surfaces apart.
    pub surfaces: bool,
    /// Whether the coordinates were built with [coverage](crate::coverage::Coverage), so that groups may be [split](crate::build::effective::SPLIT).
    /// Without it quads that are marked so are left as they are, and the pass is a tenth faster: what split quads need is not compiled.
    pub coverage: bool,
    /// Whether the luma for the next frame's analysis is written in the same pass, and from what.
    pub luma: Option<Luma>,
    /// Whether [`Counters`] are kept.
    pub counters: bool,
}

impl Options {
    /// Nothing but the picture and the rates, whatever they were built with: the slides' filter, which spills over silhouettes.
    pub fn new(picture: Picture) -> Options {
        Options {
            picture,
            depth: None,
            surfaces: false,
            coverage: true,
            luma: None,
            counters: false,
        }
    }
}

/// Where the picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Picture {
    /// A texture: `rgba8unorm`, `rgba16float`, `rgba32float` or, where the device stores it, `rg11b10ufloat`.
    Texture(wgpu::TextureFormat),
    /// An `r32uint` texture whose texels are [`Packing::Rgba8Unorm`] or [`Packing::Rg11b10Ufloat`].
    R32Uint(Packing),
    /// A storage buffer of packed pixels, row by row.
    Buffer(Packing),
}

/// The luma that is written for the next frame's analysis: √I with I of Eq. 25 (Yang et al., I3D 2019) in units of white, rounded to
/// 8 bits. The square root spends the codes where the eye does; a linear byte would have steps larger than the threshold
/// in the dark.
///
/// It is counted in integers, as the [analysis](crate::analyse) does: for the same settings and a quad whose colors are finite, both write
/// the same bytes. What is negative or above white gets 255, as there.
///
/// Four pixels to a word, the first in the low byte; rows padded to 256 bytes, see [`luma_pitch`]. Every pixel is written, not
/// only those of coarse quads. A quad with a pixel that is not finite gets 0, 255, 255 and 0, like the fields of a chessboard: whatever
/// lies around it, it asks for full rate, and no other quad's codes change. (The analysis, which sees the color itself and
/// takes doubt for full rate, writes 255 for such a pixel.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Luma {
    /// How the picture's values are display-encoded, each rounded to 8 bits; `None` if they are linear.
    pub transfer: Option<Transfer>,
    /// The weights of red, green and blue.
    pub weights: Weights,
    /// White, as a power of two; for linear values.
    pub white_log2: i32,
}

impl Luma {
    /// Of sRGB-encoded values.
    pub const SRGB: Luma = Luma {
        transfer: Some(Transfer::Srgb),
        ..Luma::linear(0)
    };

    /// Of linear values, given white as a power of two.
    pub const fn linear(white_log2: i32) -> Luma {
        Luma {
            transfer: None,
            weights: Weights::Paper,
            white_log2,
        }
    }
}

/// How the picture is read and written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// In one dispatch, in place.
    InPlace,
    /// Through a scratch texture, in two dispatches.
    Scratch,
}

impl std::fmt::Display for Way {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Way::InPlace => "in place: the picture can be read and written in one shader",
            Way::Scratch => {
                "through a scratch texture: the adapter does not read and write this format in one shader"
            }
        })
    }
}

/// What was counted; sums, so the same in every run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Counters {
    /// Pixels of coarse quads whose red, green or blue is NaN or infinite.
    pub not_finite: u32,
    /// Pixels that were filtered.
    pub filtered: u32,
    /// Taps that did not count: another surface, or no usable value.
    pub refused: u32,
}

/// Why there is no deblocker, or it cannot be bound.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DeblockError {
    /// A texture format that is not known to the filter, or that the device does not store.
    #[error("deblock: {format:?} {why}")]
    Format {
        /// The format.
        format: wgpu::TextureFormat,
        /// Why not.
        why: &'static str,
    },
    /// Options that contradict themselves.
    #[error("deblock: {0}")]
    Options(&'static str),
    /// An input that was declared is missing or too small, or one was given that was not declared.
    #[error("deblock: {0}")]
    Inputs(String),
    /// A view that keeps no effective rates.
    #[error(
        "deblock: the view keeps no effective rates: make it with `BuildOptions {{ effective: true, .. }}`, or give rates of your own"
    )]
    NoEffectiveRates,
    /// The view has made its buffers anew since the picture was bound, or is another one.
    #[error(
        "deblock: the picture is bound to rates that are not this view's: call `Deblocker::bind` again after `View::set_extent`, with the \
         pictures that were made for it"
    )]
    Stale,
    /// No frame was set: nothing would be filtered.
    #[error(
        "deblock: no frame is set: call `Deblocker::set_frame`, or `Deblocker::record_view` if the rates are a view's"
    )]
    NoFrame,
    /// What is given belongs to another device than the deblocker.
    #[error("deblock: the deblocker and what it is given belong to different devices")]
    Device,
    /// wgpu does not bind an input: it lacks a usage, or is of another kind.
    #[error("deblock: wgpu does not bind what was given: {0}")]
    Refused(String),
    /// The device has too little for the kernel.
    #[error(transparent)]
    Limit(#[from] crate::limits::LimitError),
}
