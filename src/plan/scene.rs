//! What a scene may declare, and what is bound for it.

/// The form in which the previous picture is had.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColourForm {
    /// A texture of 8-bit codes, viewed without sRGB decoding.
    #[default]
    Codes,
    /// A texture of linear light, 16 or 32 bits a channel.
    Linear,
    /// A buffer of √luma: four pixels to a word, rows padded to 256 bytes.
    SqrtLuma,
}

/// What the renderer has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Scene {
    /// The previous picture.
    pub colour: ColourForm,
    /// The same after transparents.
    pub after_transparents: bool,
    /// Motion vectors of this frame.
    pub motion: bool,
    /// Depth of this frame and the previous.
    pub depth: bool,
    /// The matrices of both frames' cameras, for a scene that has depth and no motion vectors.
    pub cameras: bool,
    /// The previous frame's rates.
    pub previous_rates: bool,
    /// Smoothness and Rf0, of the frame that [`Materials::of`](crate::analyse::settings::Materials::of) says.
    pub materials: bool,
    /// A mask of where noise is.
    pub noise: bool,
    /// Ids of materials or objects.
    pub ids: bool,
    /// Flags of pixels.
    pub flags: bool,
    /// Widths of a later blur.
    pub blur: bool,
    /// Whether rates for a hardware attachment are wanted: of the tiles of [`Settings::attachment`](crate::analyse::Settings::attachment).
    pub attachment: bool,
    /// Whether rates without the extra half rate are wanted as well, for passes that add no noise.
    pub plain_rates: bool,
    /// Whether reasons are wanted.
    pub reasons: bool,
    /// Whether the previous picture's √luma is wanted, for later frames to use instead of its colour. A deblocker that
    /// writes it already makes this needless; so does a scene that has it.
    pub sqrt_luma: bool,
    /// Whether the pictures hold more than the view, which then has an [origin](crate::analyse::Frame::origin) in them: of a split
    /// screen, say.
    pub origin: bool,
}

/// A binding of the analysis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Binding {
    /// Parameters, a uniform buffer.
    Params,
    /// Tables, a storage buffer.
    Tables,
    /// The rates, written.
    Rates,
    /// The previous picture.
    Colour,
    /// The same after transparents.
    After,
    /// The attachment's rates, written.
    Attachment,
    /// Reasons, written.
    Reasons,
    /// Motion vectors.
    Motion,
    /// Depth.
    Depth,
    /// The previous depth.
    PreviousDepth,
    /// The previous rates.
    PreviousRates,
    /// Smoothness and Rf0.
    Materials,
    /// The noise mask.
    Noise,
    /// Flags.
    Flags,
    /// √luma, written.
    SqrtLuma,
    /// Widths of a later blur.
    Blur,
    /// Ids of materials or objects.
    Ids,
    /// The rates of half the resolution, written.
    HalfRates,
    /// Camera and lens, a uniform buffer.
    Optics,
    /// What the previous picture's tiles tell, a storage buffer of [`tiles::data_bytes`](crate::analyse::tiles::data_bytes) that is
    /// written and read here.
    TileData,
    /// The rates without the extra half rate, written.
    PlainRates,
}

impl Binding {
    pub(super) const ALL: [Binding; 21] = [
        Binding::Params,
        Binding::Tables,
        Binding::Rates,
        Binding::Colour,
        Binding::After,
        Binding::Attachment,
        Binding::Reasons,
        Binding::Motion,
        Binding::Depth,
        Binding::PreviousDepth,
        Binding::PreviousRates,
        Binding::Materials,
        Binding::Noise,
        Binding::Flags,
        Binding::SqrtLuma,
        Binding::Blur,
        Binding::Ids,
        Binding::HalfRates,
        Binding::Optics,
        Binding::TileData,
        Binding::PlainRates,
    ];

    /// Its index in the kernel's group.
    pub fn index(self) -> u32 {
        self as u32
    }

    /// Whether it is a storage buffer, given the form of the colour.
    pub fn is_storage_buffer(self, colour: ColourForm) -> bool {
        match self {
            Binding::Tables
            | Binding::Rates
            | Binding::Attachment
            | Binding::Reasons
            | Binding::PreviousRates
            | Binding::HalfRates
            | Binding::TileData
            | Binding::PlainRates
            | Binding::SqrtLuma => true,
            Binding::Colour | Binding::After => colour == ColourForm::SqrtLuma,
            _ => false,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Binding::Params => "parameters",
            Binding::Tables => "tables",
            Binding::Rates => "rates",
            Binding::Colour => "colour",
            Binding::After => "colour after transparents",
            Binding::Attachment => "attachment rates",
            Binding::Reasons => "reasons",
            Binding::Motion => "motion vectors",
            Binding::Depth => "depth",
            Binding::PreviousDepth => "previous depth",
            Binding::PreviousRates => "previous rates",
            Binding::Materials => "materials",
            Binding::Noise => "noise mask",
            Binding::Flags => "flags",
            Binding::SqrtLuma => "√luma",
            Binding::Blur => "later blur",
            Binding::Ids => "ids",
            Binding::HalfRates => "rates of half the resolution",
            Binding::Optics => "camera and lens",
            Binding::TileData => "data of tiles",
            Binding::PlainRates => "rates without the extra half rate",
        }
    }
}
