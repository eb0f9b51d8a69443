//! The two bindings that a rewritten shader adds, for bind groups of the caller's own.
//!
//! Most passes have a group for the two alone, and [`Pass::dispatch`] sets it. Where the shader leaves no group free, or
//! [`Options::place`](vrcs_passes::Options::place) says so, the two lie in a group of the caller's. Then the caller's layout has
//! their [entries](layout_entries), the caller's bind group the pass's [`Bindings`], and the caller sets it:
//!
//! ```no_run
//! # fn f(device: &wgpu::Device, pass: &vrcs::Pass, view: &vrcs::View, own: wgpu::BindGroupEntry<'_>) -> Option<()> {
//! let group = pass.shared_group()?;
//! let added = pass.bindings(view);
//! let [params, coords] = added.entries();
//! let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
//!     label: None,
//!     layout: pass.bind_group_layout(group)?,
//!     entries: &[own, params, coords],
//! });
//! # Some(())
//! # }
//! ```

use super::Pass;
use crate::view::View;

/// The added bindings of a pass over a view: the parameters and the coordinate buffer.
///
/// They hold until the view's extent grows past what its buffers fit: make the bind group anew after
/// [`View::set_extent`], as for any texture of the picture's size.
#[derive(Clone, Debug)]
pub struct Bindings {
    /// The parameters, a uniform buffer.
    pub params: wgpu::Buffer,
    /// The coordinate buffer of the pass's mode, a read-only storage buffer.
    pub coords: wgpu::Buffer,
    /// The parameters' binding number; the coordinate buffer has the next.
    pub first: u32,
}

impl Bindings {
    /// The entries of a bind group.
    pub fn entries(&self) -> [wgpu::BindGroupEntry<'_>; 2] {
        [(self.first, &self.params), (self.first + 1, &self.coords)].map(|(binding, buffer)| {
            wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            }
        })
    }
}

/// The entries of a bind group layout for the added bindings, the parameters' number being `first`.
pub fn layout_entries(first: u32) -> [wgpu::BindGroupLayoutEntry; 2] {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    [
        entry(first, wgpu::BufferBindingType::Uniform),
        entry(
            first + 1,
            wgpu::BufferBindingType::Storage { read_only: true },
        ),
    ]
}

impl Pass {
    /// The caller's group in which the added bindings lie; `None` if they have one for themselves, which
    /// [`dispatch`](Pass::dispatch) sets.
    pub fn shared_group(&self) -> Option<u32> {
        self.is_shared.then_some(self.added.group)
    }

    /// The added bindings over a view, for the caller's bind group where it is [shared](Pass::shared_group).
    ///
    /// # Panics
    /// If the pass does not [fit](Pass::check) the view.
    pub fn bindings(&self, view: &View) -> Bindings {
        let found = match self.check(view) {
            Ok(()) => view.bindings(self.original_group_size, self.manifest.mode),
            Err(mismatch) => panic!("{mismatch}"),
        };
        let Some((params, coords)) = found else {
            unreachable!("the build serves the mode");
        };
        Bindings {
            params,
            coords,
            first: self.added.binding,
        }
    }
}
