//! The buffers of a build, and what of them is needed for what is asked.
//!
//! *Guarantees*: what the options do not ask for does not exist; buffers grow with the extent, never shrink.

use super::{BuildOptions, CoordLayout, ListLayout, statistics::Statistics};
use crate::{object::ObjectOptions, sri::SriLayout};

/// The counters' bytes.
const COUNTERS: u64 = 256;
/// The bytes of the arguments of indirect dispatches: of the list without sky, with sky, of the classified lists without
/// sky, with sky; twelve bytes each.
const ARGUMENTS: u64 = 48;

/// What a kernel binds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Resource {
    Params,
    Sri,
    Coords,
    Counters,
    List,
    Classified,
    Effective,
    Graded,
    Arguments,
    Statistics,
    User,
    Triangles,
    Surfaces,
    Depth,
    Normals,
}

/// The buffers of a build. Those that its options do not ask for do not exist.
#[derive(Clone, Debug)]
pub struct Buffers {
    /// The shading-rate image, in the form of [`SriLayout`].
    pub sri: wgpu::Buffer,
    /// The tiled buffer.
    pub coords: Option<wgpu::Buffer>,
    /// The list.
    pub list: Option<wgpu::Buffer>,
    /// The classified lists.
    pub classified: Option<wgpu::Buffer>,
    /// The graded buffer.
    pub graded: Option<wgpu::Buffer>,
    /// The effective rates, in the form of [`SriLayout`].
    pub effective: Option<wgpu::Buffer>,
    /// The arguments of indirect dispatches.
    pub arguments: Option<wgpu::Buffer>,
    /// The [statistics](Statistics::read).
    pub statistics: Option<wgpu::Buffer>,
    /// The user's own bits of each tile, in the form of [`user_words`](super::user_words): written before the build.
    pub user: Option<wgpu::Buffer>,
    counters: Option<wgpu::Buffer>,
}

impl Buffers {
    /// Makes the buffers for an extent.
    pub fn new(
        device: &wgpu::Device,
        options: &BuildOptions,
        extent: [u32; 2],
        objects: &ObjectOptions,
    ) -> Buffers {
        let buffer = |part, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(&objects.name(part)),
                size,
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_DST
                    | wgpu::BufferUsages::COPY_SRC
                    | usage,
                mapped_at_creation: false,
            })
        };
        let none = wgpu::BufferUsages::empty();
        let sizes = Sizes::new(options, extent);
        let optional = |label, size: Option<u64>| size.map(|size| buffer(label, size, none));
        Buffers {
            sri: buffer("shading rates", sizes.sri, none),
            coords: optional("coordinates", sizes.coords),
            list: optional("list", sizes.list),
            classified: optional("classified lists", sizes.classified),
            graded: optional("graded", sizes.graded),
            effective: optional("effective rates", sizes.effective),
            arguments: has_lists(options)
                .then(|| buffer("arguments", ARGUMENTS, wgpu::BufferUsages::INDIRECT)),
            statistics: optional(
                "statistics",
                options.statistics.then_some(Statistics::BYTES),
            ),
            user: optional("user bits", sizes.user),
            counters: optional("counters", has_counters(options).then_some(COUNTERS)),
        }
    }

    /// Whether the buffers hold what an extent needs.
    pub fn fit(&self, options: &BuildOptions, extent: [u32; 2]) -> bool {
        let sizes = Sizes::new(options, extent);
        let fits = |buffer: &Option<wgpu::Buffer>, size: Option<u64>| {
            buffer.as_ref().map_or(0, wgpu::Buffer::size) >= size.unwrap_or(0)
        };
        self.sri.size() >= sizes.sri
            && fits(&self.coords, sizes.coords)
            && fits(&self.list, sizes.list)
            && fits(&self.classified, sizes.classified)
            && fits(&self.graded, sizes.graded)
            && fits(&self.effective, sizes.effective)
            && fits(&self.user, sizes.user)
    }

    pub(super) fn get(&self, resource: Resource) -> Option<&wgpu::Buffer> {
        match resource {
            Resource::Sri => Some(&self.sri),
            Resource::Coords => self.coords.as_ref(),
            Resource::Counters => self.counters.as_ref(),
            Resource::List => self.list.as_ref(),
            Resource::Classified => self.classified.as_ref(),
            Resource::Effective => self.effective.as_ref(),
            Resource::Graded => self.graded.as_ref(),
            Resource::Arguments => self.arguments.as_ref(),
            Resource::Statistics => self.statistics.as_ref(),
            Resource::User => self.user.as_ref(),
            _ => None,
        }
    }
}

/// The bytes of the buffers that options ask for.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    sri: u64,
    coords: Option<u64>,
    list: Option<u64>,
    classified: Option<u64>,
    graded: Option<u64>,
    effective: Option<u64>,
    user: Option<u64>,
}

impl Sizes {
    /// The sizes for an extent.
    pub fn new(options: &BuildOptions, extent: [u32; 2]) -> Sizes {
        let coords = CoordLayout::new(extent, options);
        let lists = ListLayout::new(extent, options);
        let sri = SriLayout::new(extent[0], extent[1]).bytes();
        let modes = options.modes;
        Sizes {
            sri,
            coords: modes.tiled.then_some(u64::from(coords.words()) * 4),
            list: modes.list.then_some(lists.list_bytes()),
            classified: modes.classified.then_some(lists.classified_bytes()),
            graded: modes.graded.then_some(lists.graded_bytes()),
            effective: options.effective.then_some(sri),
            user: options
                .user
                .then_some(u64::from(coords.tile_count().div_ceil(8)) * 4),
        }
    }

    /// The largest.
    pub fn largest(&self) -> u64 {
        [
            Some(self.sri),
            self.coords,
            self.list,
            self.classified,
            self.graded,
        ]
        .into_iter()
        .flatten()
        .max()
        .unwrap_or(0)
    }
}

pub(super) fn has_lists(options: &BuildOptions) -> bool {
    options.modes.list || options.modes.classified
}

pub(super) fn has_counters(options: &BuildOptions) -> bool {
    has_lists(options) || options.statistics
}
