//! The parameters of a rewritten shader, which each pass over a view binds.

use bytemuck::{Pod, Zeroable};
use vrcs_passes::options::Mode;

use crate::build::{BuildOptions, CoordLayout, LIST_HEADER, ListLayout};

/// The parameters of a rewritten shader, as in its `VrcsParams`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Params {
    /// The logical extent, in invocations.
    pub extent: [u32; 3],
    /// [`Params::ENABLED`].
    pub flags: u32,
    /// What `num_workgroups` would be in the original dispatch.
    pub groups: [u32; 3],
    /// Tiles in a row of the picture; quads in a row of the graded buffer.
    pub tiles_per_row: u32,
    /// The word at which the entries start.
    pub entries: u32,
    /// Words for each tile's entries; in the classified lists, room for tiles in each class; in graded mode the tile's width, and its
    /// height from bit 16 on.
    pub entries_per_tile: u32,
    /// Room for entries in a list; words of the graded buffer's quads.
    pub capacity: u32,
    /// Words of an entry of a list.
    pub stride: u32,
}

impl Params {
    /// Variable-rate shading is on; without this flag every invocation shades its own pixel.
    pub const ENABLED: u32 = 1;

    /// The parameters of a dispatch over what a build made for `built`, which may be larger than the extent.
    pub fn new(
        extent: [u32; 3],
        enabled: bool,
        original_group_size: [u32; 3],
        mode: Mode,
        built: [u32; 2],
        options: &BuildOptions,
    ) -> Params {
        let layout = CoordLayout::new(built, options);
        let lists = ListLayout::new(built, options);
        let (tiles_per_row, entries, entries_per_tile) = match mode {
            Mode::Tiled => (layout.tiles[0], layout.entries, layout.entries_per_tile),
            Mode::List => (layout.tiles[0], LIST_HEADER, 0),
            Mode::Classified => (layout.tiles[0], lists.mixed(), lists.tiles),
            Mode::Graded | Mode::Auto => {
                let [width, height] = options.tile;
                (lists.graded_pitch, 0, width | height << 16)
            }
        };
        let capacity = match mode {
            Mode::Graded => lists.graded_words(),
            _ => lists.capacity,
        };
        Params {
            extent,
            flags: match enabled {
                true => Params::ENABLED,
                false => 0,
            },
            groups: std::array::from_fn(|axis| {
                extent[axis].div_ceil(original_group_size[axis].max(1))
            }),
            tiles_per_row,
            entries,
            entries_per_tile,
            capacity,
            stride: lists.stride,
        }
    }
}
