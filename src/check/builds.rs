//! The builds of the shader that a check runs, and the run of a case.

use vrcs_passes::{
    emit,
    instrument::{self, Shape},
    options::{FullTiles, Mode},
};

use super::{
    Route, coordinates,
    inputs::Made,
    learn::Set,
    run::{Build, Code, Extra, Outputs, Program, RunError},
    session::{Case, Session, Stop, shape_of, to_words, validated},
};
use crate::{
    build::{BuildOptions, LinearDepth, Modes},
    coverage::Coverage,
    view::Params,
};
use naga::{Module, valid::ModuleInfo};

/// The builds of the shader.
pub(super) struct Builds {
    rewritten: Program,
    counting: Program,
    counting_binding: naga::ResourceBinding,
    /// Where the counts of each output start, and how many there are.
    pub(super) counts: Vec<(u32, u32)>,
}

impl Session<'_> {
    pub(super) fn program(
        &self,
        label: &str,
        module: &Module,
        info: &ModuleInfo,
        entry: usize,
        immediates: &[u8],
    ) -> Result<Program, Stop> {
        let build = Build {
            label,
            module,
            info,
            entry,
            code: Code::Module,
            constants: &self.constants,
            immediate_size: immediates.len() as u32,
        };
        Ok(Program::new(self.gpu, build)?)
    }

    pub(super) fn run_build(
        &self,
        program: &Program,
        made: &[Made],
        extras: &[Extra],
        immediates: &[u8],
        groups: [u32; 3],
        read: &[&wgpu::Buffer],
    ) -> Result<(Outputs, Vec<Vec<u8>>), Stop> {
        let (mut outputs, read) = program.run(self.gpu, made, extras, immediates, groups, read)?;
        let written = made.iter().filter(|made| made.written);
        for (made, bytes) in written.zip(&mut outputs) {
            self.canonicalise(made, bytes);
        }
        Ok((outputs, read))
    }

    pub(super) fn canonicalise(&self, made: &Made, bytes: &mut [u8]) {
        match &made.kind {
            super::inputs::MadeKind::Buffer { .. } => {
                let ty = self.module.global_variables[made.resource.global].ty;
                super::nan::canonicalise_buffer(self.module, ty, bytes);
            }
            super::inputs::MadeKind::Texture { texture, .. } => {
                super::nan::canonicalise_texels(texture.format(), bytes)
            }
            super::inputs::MadeKind::Sampler(_) => {}
        }
    }

    /// Makes the builds of the shader; the same for every set.
    pub(super) fn build(&mut self, set: &Set) -> Result<Builds, Stop> {
        let text = match self.job.route {
            Route::Module => None,
            Route::Text => match emit::wgsl(&self.rewritten.module, &self.rewritten.info) {
                Ok(text) => Some(text),
                Err(error) => {
                    self.report
                        .notes
                        .push(format!("checked as a module: {error}"));
                    None
                }
            },
        };
        let immediates = set.immediates.len() as u32;
        let build = Build {
            label: "rewritten",
            module: &self.rewritten.module,
            info: &self.rewritten.info,
            entry: self.entry,
            code: text.as_deref().map_or(Code::Module, Code::Text),
            constants: &self.constants,
            immediate_size: immediates,
        };
        let rewritten = Program::new(self.gpu, build)?;
        let shape = |global| shape_of(&set.made, global);
        let mut counts = Vec::new();
        let mut next = 0;
        let written: Vec<&Made> = set.made.iter().filter(|made| made.written).collect();
        for made in &written {
            let units = match shape_of(&set.made, made.resource.global) {
                Some(Shape::Texture([w, h, d])) => w * h * d,
                Some(Shape::Buffer(bytes)) => bytes / 2,
                None => 0,
            };
            counts.push((next, units));
            next += units;
        }
        let base = |global| {
            let output = written
                .iter()
                .position(|made| made.resource.global == global);
            output.map_or(0, |output| counts[output].0)
        };
        let counting = instrument::count_stores(
            &self.rewritten.module,
            &self.rewritten.info,
            self.entry,
            &shape,
            &base,
        );
        let info = validated(&counting.module);
        let counting_program = self.program(
            "rewritten, counted",
            &counting.module,
            &info,
            0,
            &set.immediates,
        )?;
        self.gpu.check().map_err(RunError::from)?;
        Ok(Builds {
            rewritten,
            counting: counting_program,
            counting_binding: counting.binding,
            counts,
        })
    }

    /// The mode of the rewritten shader.
    pub(super) fn mode(&self) -> Mode {
        self.rewritten.manifest.entries[0].mode
    }

    /// Whether the shader asks for the user's own bits of its tile.
    pub(super) fn asks_user(&self) -> bool {
        self.rewritten.manifest.entries[0].user
    }

    pub(super) fn build_options(&self, full_tiles: FullTiles, coverage: Coverage) -> BuildOptions {
        BuildOptions {
            tile: self.tile,
            wave: self.job.options.wave,
            full_tiles,
            largest: self.job.largest(),
            modes: Modes::NONE.with(self.mode()),
            coverage,
            user: self.asks_user(),
            linear_depth: self.rewritten.manifest.entries[0]
                .linear_depth
                .then_some(LinearDepth {
                    near: 1.0,
                    far: 4.0,
                }),
            ..BuildOptions::default()
        }
        .for_tile(self.tile)
    }

    /// Runs the rewritten shader, and the build of it that counts; the outputs, and the counts of all outputs.
    pub(super) fn run_case(
        &self,
        builds: &Builds,
        set: &Set,
        case: &Case,
    ) -> Result<(Outputs, Vec<u32>), Stop> {
        let manifest = &self.rewritten.manifest.entries[0];
        let extent = [case.extent[0], case.extent[1], set.original.log.grid()[2]];
        let params = Params {
            groups: set.groups,
            ..Params::new(
                extent,
                case.enabled,
                [1; 3],
                self.mode(),
                case.coordinates.extent,
                &case.coordinates.options,
            )
        };
        let params = self.gpu.buffer(
            "params",
            bytemuck::bytes_of(&params),
            wgpu::BufferUsages::UNIFORM,
        );
        let mut rng = fastrand::Rng::with_seed(u64::from(case.number));
        let options = &self.job.options;
        let (words, [across, down]) =
            coordinates::words(&case.coordinates, self.mode(), options.sky, &mut rng);
        let coords = self.gpu.buffer(
            "coordinates",
            bytemuck::cast_slice(&words),
            wgpu::BufferUsages::STORAGE,
        );
        let at = |index: usize| naga::ResourceBinding {
            group: manifest.bindings[index].group,
            binding: manifest.bindings[index].binding,
        };
        let mut extras = vec![(at(0), &params), (at(1), &coords)];
        let groups = match manifest.dispatch.indirect && case.enabled {
            true => [across, down, extent[2]],
            false => manifest.groups_for(extent, self.group_size),
        };
        let (outputs, _) = self.run_build(
            &builds.rewritten,
            &set.made,
            &extras,
            &set.immediates,
            groups,
            &[],
        )?;
        let words: u32 = builds.counts.iter().map(|(_, units)| units).sum();
        let zeros = vec![0; words as usize * 4];
        let counts = self
            .gpu
            .buffer("counts", &zeros, wgpu::BufferUsages::STORAGE);
        extras.push((builds.counting_binding, &counts));
        let (_, read) = self.run_build(
            &builds.counting,
            &set.made,
            &extras,
            &set.immediates,
            groups,
            &[&counts],
        )?;
        Ok((outputs, to_words(&read[0])))
    }
}
