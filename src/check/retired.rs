//! Counts the subgroups that retire in a shader whose invocations work together, against what the shading rates promise.
//!
//! *Does*: runs an [instrumented build](vrcs_passes::instrument::subgroups) of the rewritten shader over made-up inputs and
//! shading rates, and sets what its atomic counters say beside what the rates alone [say](crate::build::subgroups).
//! *Needs*: a device with subgroup operations and subgroups of one size; a shader all of whose workgroups walk through the same
//! regions equally often, and whose domain is the picture; a picture of whole tiles.
//! *Guarantees*: what is predicted comes from the shading rates and the CPU twin, never from the shader.

use vrcs_passes::{
    Source,
    instrument::subgroups::{self, WorkKind},
    options::Sky,
};

use super::{
    CheckError, Job, Verdict, coordinates,
    gpu::Gpu,
    rates::Pattern,
    run::RunError,
    session::{Session, Stop, surfaces, to_words, validated},
};
use crate::{
    build::{
        cpu::{self, Coordinates},
        primary::Order,
        subgroups::Subgroups,
    },
    coverage::Coverage,
    view::Params,
};

/// What was counted with one shading-rate image.
#[derive(Clone, Debug, PartialEq)]
pub struct Counted {
    /// The shading rates.
    pub pattern: String,
    /// The share of pixels that are primaries.
    pub primaries: f64,
    /// What the shading rates promise.
    pub predicted: Subgroups,
    /// What the counters say, for each piece of work in the order of the text.
    pub works: Vec<Work>,
}

/// What the counters say of a piece of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Work {
    /// What waits for a primary there.
    pub kind: WorkKind,
    /// Subgroups that came by, each time.
    pub came: u64,
    /// Subgroups that had a primary and went in, each time.
    pub went_in: u64,
}

impl Counted {
    /// How often a subgroup comes by a piece of work: once, or once in each turn of a loop. `None` if what was counted is no
    /// multiple of what was started.
    pub fn turns(&self, work: &Work) -> Option<u64> {
        match self.predicted.started {
            0 => (work.came == 0).then_some(0),
            started => work
                .came
                .is_multiple_of(started)
                .then(|| work.came / started),
        }
    }

    /// Whether a piece of work was come by and skipped just as predicted.
    pub fn holds(&self, work: &Work) -> bool {
        let Some(turns) = self.turns(work) else {
            return false;
        };
        match work.kind {
            WorkKind::Region => work.went_in == turns * self.predicted.busy,
            // the work in front of a masked store is everybody's
            WorkKind::MaskedStore => work.went_in <= work.came,
        }
    }
}

/// The invocations of a subgroup, if the device has such operations and only one size.
pub fn subgroup_size(gpu: &Gpu) -> Option<u32> {
    let has = gpu.device.features().contains(wgpu::Features::SUBGROUP);
    let (least, most) = (gpu.info.subgroup_min_size, gpu.info.subgroup_max_size);
    (has && least == most).then_some(least)
}

/// Counts the subgroups of an entry point, with `job.cases` shading-rate images, a third of them with sky.
///
/// # Errors
/// If the shader is refused or cannot be run.
pub fn count(gpu: &Gpu, source: &Source, job: &Job) -> Result<Vec<Counted>, CheckError> {
    let (module, info) = vrcs_passes::input::wgsl(source)
        .map_err(|invalid| CheckError::NotRunnable(invalid.rendered))?;
    let rewritten = vrcs_passes::rewrite(&module, &info, job.entry.as_str(), &job.options)?;
    let mut session = Session::new(gpu, source, (&module, &info), &rewritten, job)?;
    match session.count_subgroups() {
        Ok(counted) => Ok(counted),
        Err(Stop::Run(error)) => Err(CheckError::NotRunnable(error.to_string())),
        Err(Stop::Input(error)) => Err(error.into()),
        Err(Stop::Verdict(_, why)) => Err(CheckError::NotRunnable(why)),
        Err(Stop::Failed(failure)) => Err(CheckError::NotRunnable(format!("{failure:?}"))),
    }
}

impl Session<'_> {
    fn count_subgroups(&mut self) -> Result<Vec<Counted>, Stop> {
        self.find_sizes()?;
        let Some(size) = subgroup_size(self.gpu) else {
            return Err(Stop::Verdict(
                Verdict::NotRunnable,
                "the device has no subgroups of one known size".to_owned(),
            ));
        };
        let mut watch = self.watch(self.group_size)?;
        let set = self.learn(&mut watch, 0, 0)?;
        let counting = subgroups::count_subgroups(&self.rewritten.module, 0);
        let info = validated(&counting.module);
        let program = self.program(
            "rewritten, subgroups counted",
            &counting.module,
            &info,
            0,
            &set.immediates,
        )?;
        let extent = self.job.size;
        let skips_sky = self.job.options.sky == Sky::Skip;
        let mut rng = fastrand::Rng::with_seed(self.job.seed);
        let mut all = Vec::new();
        for case in 0..self.job.cases {
            let pattern = Pattern::of_case(case, self.job.largest());
            let sri = pattern.image(extent[0], extent[1], &mut rng);
            let (coverage, samples) = match case % 3 {
                2 => surfaces(extent, &mut rng),
                _ => (Coverage::default(), None),
            };
            let options = self.build_options(self.job.options.full_tiles, coverage);
            let frame = cpu::Frame {
                order: Order::Rotating(case),
                samples: samples.as_ref(),
                ..cpu::Frame::default()
            };
            let coordinates = cpu::build_frame(&sri, extent, &options, &frame);
            let statistics = coordinates.statistics();
            let (words, _) =
                coordinates::words(&coordinates, self.mode(), self.job.options.sky, &mut rng);
            let counts = self.run_counting(&program, &counting, &set, &coordinates, &words)?;
            let works = counting.works.iter().zip(counts.chunks(2));
            all.push(Counted {
                pattern: match samples {
                    Some(_) => format!("{pattern:?}, sky"),
                    None => format!("{pattern:?}"),
                },
                primaries: statistics.primary_share(),
                predicted: coordinates.subgroups(size, skips_sky),
                works: works
                    .map(|(work, counts)| Work {
                        kind: work.kind,
                        came: u64::from(counts[0]),
                        went_in: u64::from(counts[1]),
                    })
                    .collect(),
            });
        }
        Ok(all)
    }

    fn run_counting(
        &self,
        program: &super::run::Program,
        counting: &subgroups::Counted,
        set: &super::learn::Set,
        built: &Coordinates,
        words: &[u32],
    ) -> Result<Vec<u32>, Stop> {
        let manifest = &self.rewritten.manifest.entries[0];
        let extent = [built.extent[0], built.extent[1], 1];
        let params = Params {
            groups: set.groups,
            ..Params::new(
                extent,
                true,
                [1; 3],
                self.mode(),
                built.extent,
                &built.options,
            )
        };
        let params = bytemuck::bytes_of(&params);
        let params = self
            .gpu
            .buffer("params", params, wgpu::BufferUsages::UNIFORM);
        let storage = wgpu::BufferUsages::STORAGE;
        let coords = self
            .gpu
            .buffer("coordinates", bytemuck::cast_slice(words), storage);
        let zeros = vec![0; counting.words() as usize * 4];
        let counts = self.gpu.buffer("subgroups", &zeros, storage);
        let at = |index: usize| naga::ResourceBinding {
            group: manifest.bindings[index].group,
            binding: manifest.bindings[index].binding,
        };
        let extras = [
            (at(0), &params),
            (at(1), &coords),
            (counting.binding, &counts),
        ];
        let groups = manifest.groups_for(extent, self.group_size);
        let (_, read) = program
            .run(
                self.gpu,
                &set.made,
                &extras,
                &set.immediates,
                groups,
                &[&counts],
            )
            .map_err(Stop::from)?;
        self.gpu.check().map_err(RunError::from)?;
        Ok(to_words(&read[0]))
    }
}
