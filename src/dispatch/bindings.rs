//! The two bindings that a rewritten shader adds, for bind groups of the caller's own.
//!
//! Most passes have a group for the two alone, and [`Pass::dispatch`] sets it. Where the shader leaves no group free, or
//! [`Options::place`](vrcs_passes::Options::place) says so, the two lie in a group of the caller's. Then the caller's layout has
//! their [entries](layout_entries), the caller's bind group the pass's [`Bindings`], and the caller sets it:
//!
//! ```no_run
//! # use vrcs::{Mismatch, Pass, View};
//! # fn f(device: &wgpu::Device, pass: &Pass, view: &View, own: wgpu::BindGroupEntry<'_>) -> Result<Option<()>, Mismatch> {
//! let added = pass.bindings(view)?;
//! # let layout = pass.shared_group().and_then(|group| pass.bind_group_layout(group));
//! # let Some(layout) = layout else { return Ok(None) };
//! let [params, coords] = added.entries();
//! let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
//!     label: None,
//!     layout, // the caller's own, of `pass.shared_group()`
//!     entries: &[own, params, coords],
//! });
//! # Ok(Some(()))
//! # }
//! ```

use super::{Mismatch, Pass};
use crate::view::View;

/// The added bindings of a pass over a view: the parameters and the coordinate buffer.
///
/// They hold until the view's extent grows past what its buffers fit: make the bind group anew when [`View::generation`] is another
/// than it was, as for any texture of the picture's size that is made anew.
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
    /// # Errors
    /// If the pass does not [fit](Pass::check) the view.
    pub fn bindings(&self, view: &View) -> Result<Bindings, Mismatch> {
        self.check(view)?;
        let mode = self.manifest.mode;
        let found = view.bindings(self.original_group_size, mode);
        let (params, coords) = found.ok_or(Mismatch::Mode { pass: mode })?;
        Ok(Bindings {
            params,
            coords,
            first: self.added.binding,
        })
    }
}
