//! A pass over a view: what the view has to be, and the dispatch.

use vrcs_passes::options::Mode;

use super::{Mismatch, Pass};
use crate::{build::BuildOptions, rate::Rate, view::View};

impl Pass {
    /// What a view's build has to be for this pass, other wishes being as given: its mode, its tile, a largest rate that both
    /// the pass copies and the tile has room for, and the user's own bits of each tile if its shader asks for them.
    ///
    /// A view that several passes share needs what each of them does; where their tiles differ, it takes two views.
    pub fn build_options(&self, wishes: BuildOptions) -> BuildOptions {
        let copied: Rate = self.manifest.max_rate.into();
        let mode = self.manifest.mode;
        let options = BuildOptions {
            modes: wishes.modes.with(mode),
            user: wishes.user || self.manifest.user,
            ..wishes
        };
        if mode == Mode::Graded {
            return options;
        }
        let largest = match options.largest.is_within(copied) {
            true => options.largest,
            false => copied,
        };
        BuildOptions { largest, ..options }
            .for_tile(self.manifest.tile_for(self.original_group_size))
    }

    /// Whether the pass can be dispatched over a view.
    ///
    /// # Errors
    /// What does not fit.
    pub fn check(&self, view: &View) -> Result<(), Mismatch> {
        if self.home != *view.home() {
            return Err(Mismatch::Device);
        }
        let built = view.options();
        let mode = self.manifest.mode;
        if !built.modes.has(mode) {
            return Err(Mismatch::Mode { pass: mode });
        }
        let is_deep = built.linear_depth.is_some();
        if mode != Mode::Graded && self.manifest.linear_depth != is_deep {
            return Err(Mismatch::LinearDepth {
                pass: self.manifest.linear_depth,
                view: is_deep,
            });
        }
        if self.manifest.user && !built.user {
            return Err(Mismatch::User);
        }
        let tile = self.manifest.tile_for(self.original_group_size);
        if mode != Mode::Graded && built.tile != tile {
            return Err(Mismatch::Tile {
                pass: tile,
                view: built.tile,
            });
        }
        let largest: Rate = self.manifest.max_rate.into();
        if mode != Mode::Graded && !built.largest.is_within(largest) {
            return Err(Mismatch::Rate {
                pass: largest,
                view: built.largest,
            });
        }
        let limit = view.most_groups();
        match self.groups(view).into_iter().find(|&groups| groups > limit) {
            None => Ok(()),
            Some(groups) => Err(Mismatch::TooManyGroups { groups, limit }),
        }
    }

    /// Records a dispatch over a view's extent. Sets the pipeline and this crate's own bind group, unless that is
    /// [shared](Pass::shared_group). The caller has set their own bind groups, with dynamic offsets as they need; a shader
    /// that reads immediates takes [`dispatch_with`](Pass::dispatch_with).
    ///
    /// # Errors
    /// If the pass does not [fit](Pass::check) the view; nothing is recorded then.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass, view: &View) -> Result<(), Mismatch> {
        self.dispatch_with(pass, view, |_| ())
    }

    /// The same, with what can only be set between the pipeline and the dispatch: immediates, which wgpu holds against the pipeline's
    /// layout.
    ///
    /// ```no_run
    /// # fn f(lighting: &vrcs::Pass, pass: &mut wgpu::ComputePass, view: &vrcs::View, frame: u32) -> Result<(), vrcs::Mismatch> {
    /// lighting.dispatch_with(pass, view, |pass| pass.set_immediates(0, &frame.to_le_bytes()))?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// `set` may set bind groups, too, but neither a pipeline nor the group of the added bindings.
    ///
    /// # Errors
    /// As [`dispatch`](Pass::dispatch).
    pub fn dispatch_with<'e>(
        &self,
        pass: &mut wgpu::ComputePass<'e>,
        view: &View,
        set: impl FnOnce(&mut wgpu::ComputePass<'e>),
    ) -> Result<(), Mismatch> {
        let _span = tracing::trace_span!("vrcs dispatch", entry = self.manifest.name).entered();
        self.check(view)?;
        let mode = self.manifest.mode;
        let group = match self.is_shared {
            true => None,
            false => {
                let group = view.bind_group(self.original_group_size, mode, self.added.binding);
                Some(group.ok_or(Mismatch::Mode { pass: mode })?)
            }
        };
        pass.push_debug_group(&self.label);
        pass.set_pipeline(&self.pipeline);
        if let Some(group) = &group {
            pass.set_bind_group(self.added.group, group, &[]);
        }
        set(pass);
        match view.arguments(mode, self.manifest.sky) {
            Some((arguments, at)) if view.is_enabled() => {
                pass.dispatch_workgroups_indirect(arguments, at);
            }
            _ => {
                let [x, y, z] = self.groups(view);
                pass.dispatch_workgroups(x, y, z);
            }
        }
        pass.pop_debug_group();
        Ok(())
    }

    /// The workgroups of a dispatch that is not indirect.
    fn groups(&self, view: &View) -> [u32; 3] {
        self.manifest
            .groups_for(view.extent(), self.original_group_size)
    }
}
