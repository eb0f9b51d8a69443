//! Why a quad is as fine as it is, for an overlay: one byte for each quad.

/// The reason with the last word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Reason {
    /// It is as coarse as is allowed.
    None = 0,
    /// The content's error.
    Content = 1,
    /// There is no previous frame.
    NoHistory = 2,
    /// A value that is no luma: no number, infinite, negative, above white.
    Invalid = 3,
    /// The surface was outside the previous picture, or further away than positions reach.
    OffScreen = 4,
    /// The surface was hidden.
    Disoccluded = 5,
    /// A mirror-like material.
    Material = 6,
    /// Flagged for full rate.
    Mask = 7,
    /// The extra half rate.
    HalfRate = 8,
    /// A finer neighbour.
    Neighbour = 9,
    /// Too slow for the rate, where motion alone decides.
    Motion = 10,
    /// The application's own rate.
    Own = 11,
    /// A pixel whose motion is missing: no number for a vector, no depth or no camera to work one out. Where the past is fetched along
    /// motion that is full rate; elsewhere the pixel counts as standing still.
    NoMotion = 12,
}

impl Reason {
    /// All, in order of their bytes.
    pub const ALL: [Reason; 13] = [
        Reason::None,
        Reason::Content,
        Reason::NoHistory,
        Reason::Invalid,
        Reason::OffScreen,
        Reason::Disoccluded,
        Reason::Material,
        Reason::Mask,
        Reason::HalfRate,
        Reason::Neighbour,
        Reason::Motion,
        Reason::Own,
        Reason::NoMotion,
    ];

    /// The reason of a byte.
    pub fn from_byte(byte: u8) -> Option<Reason> {
        Reason::ALL.get(usize::from(byte)).copied()
    }
}
