//! A check from beginning to end.

use std::collections::BTreeMap;

use fastrand::Rng;
use naga::{
    Handle, Module, ShaderStage,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};
use vrcs_passes::{
    Refusal, Rewritten, Source,
    graded::{self, Given},
    instrument::Shape,
    options::{FullTiles, Linear, Mode, Sky},
};

use super::{
    Failure, Job, Law, Report, Verdict,
    builds::Builds,
    compare::{Expected, Group, groups},
    coordinates::{self, build_on},
    given::Asked,
    gpu::Gpu,
    inputs::{InputError, Made, MadeKind},
    learn::{Set, Uniform},
    rates::Pattern,
    run::{Outputs, RunError},
    verdict::Seen,
};
use crate::{
    build::{
        self,
        cpu::{self, Coordinates},
        primary::Order,
    },
    coverage::{self, Coverage, Depth, DepthKind, cpu::Samples},
    sri::Sri,
};

/// Why a check could not start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckError {
    /// The shader cannot be rewritten.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// What the user said of the inputs cannot be.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The shader has no such compute entry point.
    #[error("no compute entry point is called `{0}`")]
    UnknownEntry(String),
    /// The picture is too small or too large.
    #[error("a picture of {0}x{1} cannot be checked: each side has to be 1 to 2048")]
    Size(u32, u32),
    /// The shader, or what is to be known of it, cannot be run on the device.
    #[error("{0}")]
    NotRunnable(String),
}

/// Cases that share one set of inputs.
const CASES_PER_SET: u32 = 16;
/// Sets of inputs that are made up besides, to reach stores that no other set has reached.
const MORE_SETS: u32 = 12;

/// Checks an entry point. `progress` is told the number of each case when it is done.
///
/// # Errors
/// If there is nothing to check: the shader is refused, or the job makes no sense. What the check finds, failures included,
/// is in the report.
pub fn check(
    gpu: &Gpu,
    source: &Source,
    module: &Module,
    info: &ModuleInfo,
    job: &Job,
    progress: &mut dyn FnMut(u32),
) -> Result<Report, CheckError> {
    let rewritten = vrcs_passes::rewrite(module, info, job.entry.as_str(), &job.options)?;
    check_rewritten(gpu, source, module, info, &rewritten, job, progress)
}

/// Checks what is said to be a rewrite of an entry point. [`check`] makes the rewrite itself; tests hand in broken ones.
///
/// # Errors
/// As [`check`].
pub fn check_rewritten(
    gpu: &Gpu,
    source: &Source,
    module: &Module,
    info: &ModuleInfo,
    rewritten: &Rewritten,
    job: &Job,
    progress: &mut dyn FnMut(u32),
) -> Result<Report, CheckError> {
    // what the samples of the original are is the rate's doing, too: it is held against an original that asks for its rate
    let entry = module.entry_points.iter().position(|e| e.name == job.entry);
    let asking = match entry {
        Some(entry) => vrcs_passes::detail::follow_rate(module, info, &[entry], &job.options)?,
        None => None,
    };
    let (module, info) = match &asking {
        Some((module, info)) => (module, info),
        None => (module, info),
    };
    let linear;
    let job = match &job.options.linear {
        None => job,
        Some(width) => {
            linear = with_width(job, width);
            &linear
        }
    };
    let mut session = Session::new(gpu, source, (module, info), rewritten, job)?;
    match session.run(progress) {
        Ok(()) => {}
        Err(Stop::Run(error)) => session.conclude(Verdict::NotRunnable, error.to_string()),
        Err(Stop::Input(error @ InputError::Unsupported { .. })) => {
            session.conclude(Verdict::NotRunnable, error.to_string());
        }
        Err(Stop::Input(error)) => return Err(error.into()),
        Err(Stop::Verdict(verdict, why)) => session.conclude(verdict, why),
        Err(Stop::Failed(failure)) => {
            session.report.failure = Some(*failure);
            session.conclude(Verdict::Failed, String::new());
        }
    }
    Ok(session.report)
}

/// A job whose picture is as wide as its shader takes it to be.
fn with_width(job: &Job, width: &Linear) -> Job {
    let mut job = job.clone();
    match width {
        Linear::Pixels(pixels) => job.size[0] = *pixels,
        Linear::Named(name) => {
            let own = job.size.map(f64::from).to_vec();
            // inputs are set by member, not by component
            let name = name.strip_suffix(".x").unwrap_or(name).to_owned();
            let set = job.settings.set.entry(name).or_insert(own);
            job.size[0] = set.first().map_or(job.size[0], |&width| width as u32);
        }
    }
    job
}

/// Why a check ends early.
pub(super) enum Stop {
    Run(RunError),
    Input(InputError),
    Verdict(Verdict, String),
    Failed(Box<Failure>),
}

impl<E: Into<RunError>> From<E> for Stop {
    fn from(error: E) -> Stop {
        Stop::Run(error.into())
    }
}

pub(super) fn inconclusive(why: impl Into<String>) -> Stop {
    Stop::Verdict(Verdict::Inconclusive, why.into())
}

pub(super) struct Session<'s> {
    pub(super) gpu: &'s Gpu,
    pub(super) source: &'s Source,
    pub(super) module: &'s Module,
    pub(super) info: &'s ModuleInfo,
    pub(super) entry: usize,
    pub(super) rewritten: &'s Rewritten,
    pub(super) job: &'s Job,
    pub(super) constants: Vec<(String, f64)>,
    pub(super) report: Report,
    pub(super) seen: Seen,
    /// The workgroup size of the original, its overrides resolved.
    pub(super) group_size: [u32; 3],
    /// The tile of the coordinate buffer.
    pub(super) tile: [u32; 2],
}

impl Case {
    /// The user's own bits of the tile that a pixel lies in.
    pub(super) fn user_at(&self, pixel: [u32; 2]) -> u32 {
        if !self.enabled {
            return 0;
        }
        let tile = [0, 1].map(|axis| pixel[axis] / self.coordinates.options.tile[axis]);
        let number = tile[1] * self.coordinates.layout.tiles[0] + tile[0];
        self.coordinates.header(number).user()
    }
}

/// One shading-rate image and what belongs to it.
pub(super) struct Case {
    pub(super) number: u32,
    pub(super) pattern: Pattern,
    pub(super) enabled: bool,
    pub(super) extent: [u32; 2],
    pub(super) sri: Sri,
    samples: Option<Samples>,
    pub(super) coordinates: Coordinates,
    pub(super) groups: Vec<Group>,
    /// What each invocation is told that it shares, if the shader asks.
    pub(super) answers: Vec<Given>,
}

impl<'s> Session<'s> {
    /// A check of an entry point that has not begun.
    pub(super) fn new(
        gpu: &'s Gpu,
        source: &'s Source,
        (module, info): (&'s Module, &'s ModuleInfo),
        rewritten: &'s Rewritten,
        job: &'s Job,
    ) -> Result<Session<'s>, CheckError> {
        let [width, height] = job.size;
        if !(1..=2048).contains(&width) || !(1..=2048).contains(&height) {
            return Err(CheckError::Size(width, height));
        }
        let is_entry =
            |e: &naga::EntryPoint| e.stage == ShaderStage::Compute && e.name == job.entry;
        let entry = module
            .entry_points
            .iter()
            .position(is_entry)
            .ok_or_else(|| CheckError::UnknownEntry(job.entry.clone()))?;
        Ok(Session {
            gpu,
            source,
            module,
            info,
            entry,
            rewritten,
            job,
            constants: super::inputs::constants(module, &job.settings),
            report: Report {
                entry: job.entry.clone(),
                adapter: gpu.info.name.clone(),
                verdict: Verdict::Passed,
                why: None,
                held: BTreeMap::new(),
                failure: None,
                notes: Vec::new(),
                targets: rewritten.manifest.entries[0]
                    .targets
                    .iter()
                    .map(|target| target.name.clone())
                    .collect(),
            },
            seen: Seen::default(),
            group_size: [1; 3],
            tile: job.options.tile,
        })
    }

    /// Finds out the group's size, with its overrides resolved, and the tile that goes with it.
    pub(super) fn find_sizes(&mut self) -> Result<(), Stop> {
        let keyed: Vec<(&str, f64)> = self
            .constants
            .iter()
            .map(|(name, value)| (name.as_str(), *value))
            .collect();
        let group_size =
            crate::dispatch::group_size(self.module, self.info, &self.job.entry, &keyed)
                .map_err(|error| Stop::Verdict(Verdict::NotRunnable, error.to_string()))?;
        self.group_size = group_size;
        self.tile = self.rewritten.manifest.entries[0].tile_for(group_size);
        Ok(())
    }
}

impl Session<'_> {
    fn conclude(&mut self, verdict: Verdict, why: String) {
        self.report.verdict = verdict;
        self.report.why = (!why.is_empty()).then_some(why);
    }

    fn hold(&mut self, law: Law) {
        *self.report.held.entry(law).or_default() += 1;
    }

    fn run(&mut self, progress: &mut dyn FnMut(u32)) -> Result<(), Stop> {
        if graded::asks_depth(self.module, self.entry) {
            return Err(inconclusive(
                "what `vrcs_depth()` tells is the renderer's depth, which a check does not have",
            ));
        }
        self.find_sizes()?;
        let sets = self.job.cases.div_ceil(CASES_PER_SET).max(1);
        let mut watch = self.watch(self.group_size)?;
        let mut builds = None;
        let mut asked = Asked::of(self);
        let mut strict = [0, 0];
        for number in 0..sets + MORE_SETS {
            // more sets are made up, ever more varied, as long as there is a store that none has reached
            let cases = match number < sets {
                true => CASES_PER_SET.min(self.job.cases - number * CASES_PER_SET),
                false if self.is_all_seen() => break,
                false => CASES_PER_SET / 2,
            };
            let mut set = self.learn(&mut watch, number, number.saturating_sub(sets - 1))?;
            let builds = match &mut builds {
                Some(builds) => builds,
                none => none.insert(self.build(&set)?),
            };
            for case in number * CASES_PER_SET..number * CASES_PER_SET + cases {
                let (all, sure) = self.try_case(builds, asked.as_mut(), &mut set, case)?;
                strict[0] += all;
                strict[1] += sure;
                progress(case);
            }
        }
        if strict[0] > strict[1] {
            self.report.notes.push(format!(
                "{:.1} % of the places are written only for some data, and were allowed to stay as they were",
                100.0 * (strict[0] - strict[1]) as f64 / strict[0] as f64
            ));
        }
        self.check_seen()
    }

    /// The shading rates, extent and rule of a case.
    fn case(&self, set: &Set, number: u32) -> Case {
        let mut rng = Rng::with_seed(self.job.seed ^ u64::from(number).wrapping_mul(0x51_7cc1));
        let grid = set.original.log.grid();
        let uniform = crate::Rate::ALL
            .iter()
            .filter(|rate| rate.is_within(self.job.largest()))
            .count() as u32;
        let in_set = number % CASES_PER_SET;
        // each set starts with every uniform rate at the whole extent, then one with shading rates switched off, then full
        // tiles that reach beyond a smaller extent
        let is_cut = in_set == uniform + 1;
        let pattern = match in_set {
            n if n <= uniform => Pattern::of_case(n.min(uniform - 1), self.job.largest()),
            _ if is_cut => Pattern::Uniform(crate::Rate::R1X1),
            _ => Pattern::of_case(number + uniform, self.job.largest()),
        };
        // in graded mode what lies outside the extent is the shader's own affair
        let is_graded = self.mode() == Mode::Graded;
        let is_part = !is_graded && (is_cut || in_set > uniform && rng.u8(0..3) == 0);
        let is_mixed = in_set > uniform && !is_cut;
        let order = match is_mixed && rng.bool() {
            true => Order::Rotating(rng.u32(0..4)),
            false => Order::Fixed,
        };
        let is_covered = is_mixed && rng.u8(0..3) == 0;
        // the first pixel of a block lies in the picture if any other does; another primary may lie beyond it, where a shader
        // without a guard reads nothing
        let whole = match is_graded || order == Order::Fixed && !is_covered {
            true => [grid[0], grid[1]],
            false => [0, 1].map(|axis| grid[axis].min(self.job.size[axis])),
        };
        let extent = match is_part {
            true => whole.map(|side| rng.u32(1..=side)),
            false => whole,
        };
        let full_tiles = match in_set <= uniform || is_cut || rng.bool() {
            true => self.job.options.full_tiles,
            false => FullTiles::Keep,
        };
        // a list that was built for a larger extent is harmless: what lies outside is dropped
        let built_for = match is_part && rng.bool() {
            true => [grid[0], grid[1]],
            false => extent,
        };
        let sri = pattern.image(built_for[0], built_for[1], &mut rng);
        let (mut coverage, mut samples) = match is_covered {
            true => surfaces(built_for, &mut rng),
            false => (Coverage::default(), None),
        };
        if self.rewritten.manifest.entries[0].linear_depth {
            // a plane, on which everything shares; what the entries carry of it, nothing may take for anything else
            coverage.depth = Some(Depth::new(DepthKind::Linear));
            let samples = samples.get_or_insert_with(|| Samples {
                size: built_for,
                ..Samples::default()
            });
            samples.depth = vec![rng.f32() * 4.0 + 0.5; (built_for[0] * built_for[1]) as usize];
        }
        // few tiles have none of their own; each bit by itself, and all of them
        let user: Vec<u32> = match self.asks_user() {
            true => {
                let mut bits = || [0, 1, 2, 8, 15][rng.usize(0..5)];
                build::user_words((0..1 << 16).map(|_| bits()))
            }
            false => Vec::new(),
        };
        let frame = cpu::Frame {
            order,
            samples: samples.as_ref(),
            user: &user,
        };
        let options = self.build_options(full_tiles, coverage);
        let coordinates = cpu::build_frame(&sri, built_for, &options, &frame);
        let skips_sky = !is_graded && self.job.options.sky == Sky::Skip;
        Case {
            number,
            pattern,
            enabled: in_set != uniform,
            extent,
            groups: groups(&coordinates, extent, skips_sky),
            coordinates,
            samples,
            sri,
            answers: Vec::new(),
        }
    }

    /// Tries a case; the places that were due, and how many of them for sure.
    fn try_case(
        &mut self,
        builds: &Builds,
        asked: Option<&mut Asked>,
        set: &mut Set,
        number: u32,
    ) -> Result<(usize, usize), Stop> {
        let mut case = self.case(set, number);
        if !case.enabled {
            let [width, height] = case.extent;
            case.groups = (0..width * height)
                .map(|i| Group::lone([i % width, i / width]))
                .collect();
        }
        let Some(asked) = asked else {
            return self.hold_case(builds, set, &case);
        };
        let plain = self.answer(asked, set, &mut case)?;
        let held = self.hold_case(builds, set, &case);
        set.original = plain;
        held
    }

    /// Holds the laws in a case; the places that were due, and how many of them for sure.
    fn hold_case(
        &mut self,
        builds: &Builds,
        set: &mut Set,
        case: &Case,
    ) -> Result<(usize, usize), Stop> {
        self.check_builder(case)?;
        let expected = set.original.expected(&case.groups, case.extent);
        let (outputs, counts) = self.run_case(builds, set, case)?;

        let is_full = case.extent == [0, 1].map(|axis| set.original.log.grid()[axis]);
        let law = match (case.pattern, case.enabled) {
            (_, false) => Law::Off,
            (Pattern::Uniform(crate::Rate::R1X1), _) => Law::Identity,
            (Pattern::Uniform(_), _) => Law::Replication,
            _ => Law::Contract,
        };
        if let Some(difference) = set.original.compare(&expected, &outputs) {
            return Err(self.failed(set, case, law, &difference, &outputs));
        }
        self.hold(law);
        let of_output: Vec<&[u32]> = builds
            .counts
            .iter()
            .map(|&(base, units)| &counts[base as usize..(base + units) as usize])
            .collect();
        if let Some(difference) = set.original.compare_counts(&expected, &of_output) {
            return Err(self.failed(set, case, Law::Partition, &difference, &outputs));
        }
        self.hold(Law::Partition);
        self.check_locality(set, case, &expected, &outputs)?;
        if matches!(case.pattern, Pattern::Uniform(_)) && case.enabled && is_full {
            set.uniform.push(Uniform {
                map: case.coordinates.map(),
                extent: case.extent,
                answers: case.answers.clone(),
                outputs,
            });
        }
        Ok(set.original.strictness(&expected))
    }

    fn check_builder(&mut self, case: &Case) -> Result<(), Stop> {
        let twin = &case.coordinates;
        let builder = self.gpu.builder(twin.options).map_err(RunError::from)?;
        let built = build_on(
            self.gpu,
            &builder,
            &case.sri,
            case.samples.as_ref(),
            twin,
            1,
        )
        .map_err(RunError::from)?;
        if let Err(difference) = coordinates::compare(twin, &built) {
            return Err(Stop::Failed(Box::new(Failure {
                law: Law::Builder,
                case: case.number,
                pattern: format!("{:?}", case.pattern),
                extent: case.extent,
                target: "coordinate buffer".to_owned(),
                place: difference.place,
                pixel: None,
                tile: None,
                primary: None,
                expected: difference.expected,
                got: difference.got,
                picture: Vec::new(),
            })));
        }
        self.hold(Law::Builder);
        Ok(())
    }

    /// Holds a mixed case against the uniform ones: a group that is the same in both is written the same.
    fn check_locality(
        &mut self,
        set: &Set,
        case: &Case,
        expected: &[Expected],
        outputs: &Outputs,
    ) -> Result<(), Stop> {
        if matches!(case.pattern, Pattern::Uniform(_)) || set.uniform.is_empty() {
            return Ok(());
        }
        let map = case.coordinates.map();
        let width = case.coordinates.extent[0];
        let grid = set.original.log.grid();
        for uniform in &set.uniform {
            let extent = uniform.extent;
            let difference = set.original.compare_where(
                expected,
                outputs,
                &uniform.outputs,
                &|pixel: [u32; 3], primary: [u32; 3]| {
                    let here = map[(pixel[1] * width + pixel[0]) as usize];
                    let there = uniform.map[(pixel[1] * extent[0] + pixel[0]) as usize];
                    let [x, y, z] = primary;
                    let invocation = ((z * grid[1] + y) * grid[0] + x) as usize;
                    [here % width, here / width] == [there % extent[0], there / extent[0]]
                        && [x, y] == [here % width, here / width]
                        && case.answers.get(invocation) == uniform.answers.get(invocation)
                },
            );
            if let Some(difference) = difference {
                return Err(self.failed(set, case, Law::Locality, &difference, outputs));
            }
        }
        self.hold(Law::Locality);
        Ok(())
    }
}

/// Random surfaces, a third of them sky: patches, so that tiles throughout of one kind occur, and lone pixels.
pub(super) fn surfaces([width, height]: [u32; 2], rng: &mut Rng) -> (Coverage, Option<Samples>) {
    let coverage = Coverage {
        surfaces: true,
        sky: Some(coverage::Sky::Surface(0)),
        ..Coverage::default()
    };
    let size = [1, 2, 5, 40][rng.usize(..4)];
    let key = rng.u64(..);
    let surface = |at: u32| {
        let patch = u64::from(at % width / size) << 32 | u64::from(at / width / size);
        Rng::with_seed(key ^ patch.wrapping_mul(0x9e37_79b9_7f4a_7c15)).u32(0..3)
    };
    let samples = Samples {
        size: [width, height],
        surfaces: (0..width * height).map(surface).collect(),
        ..Samples::default()
    };
    (coverage, Some(samples))
}

pub(super) fn shape_of(made: &[Made], global: Handle<naga::GlobalVariable>) -> Option<Shape> {
    let made = made.iter().find(|made| made.resource.global == global)?;
    match &made.kind {
        MadeKind::Buffer { initial, .. } => Some(Shape::Buffer(initial.len() as u32)),
        MadeKind::Texture { texture, .. } => {
            let size = texture.size();
            Some(Shape::Texture([
                size.width,
                size.height,
                size.depth_or_array_layers,
            ]))
        }
        MadeKind::Sampler(_) => None,
    }
}

pub(super) fn initial_bytes(made: &Made) -> Vec<u8> {
    match &made.kind {
        MadeKind::Buffer { initial, .. } => {
            let mut bytes = initial.clone();
            bytes.resize(bytes.len().next_multiple_of(4).max(4), 0);
            bytes
        }
        MadeKind::Texture { initial, .. } => initial.clone(),
        MadeKind::Sampler(_) => Vec::new(),
    }
}

/// Bytes of a texel; `None` for a buffer.
pub(super) fn texel_bytes(made: &Made) -> Option<usize> {
    match &made.kind {
        MadeKind::Texture { texture, .. } => {
            Some(texture.format().block_copy_size(None).unwrap_or(4) as usize)
        }
        _ => None,
    }
}

pub(super) fn to_words(bytes: &[u8]) -> Vec<u32> {
    bytes
        .chunks_exact(4)
        .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect()
}

/// What naga knows of a module that this crate made.
pub(super) fn validated(module: &Module) -> ModuleInfo {
    match Validator::new(ValidationFlags::all(), Capabilities::all()).validate(module) {
        Ok(info) => info,
        Err(error) => unreachable!("an instrumented module: {:?}", error.into_inner()),
    }
}
