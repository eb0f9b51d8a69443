//! Times of contenders, by the GPU's own clock, beside a control of constant work.
//!
//! *Guarantees*: each sample is a submission of its own, so that no two overlap; contenders take turns, each round starting with another,
//! so that a clock that drifts meets all alike; the first rounds are not counted. Before each sample the control runs, which does nothing
//! but arithmetic, always the same: it keeps the GPU awake, and where it took longer than the fastest of the run by more than [`DRIFT`]
//! the clock was down and the round is not counted, but made up for; if too few are left, times are scaled by the control's, and that is
//! said. *Needs*: timestamp queries.

use std::{
    cell::Cell,
    time::{Duration, Instant},
};

use serde::Serialize;

use super::{BenchError, Part, stage};
use crate::check::gpu::Gpu;

/// Rounds that are not counted.
const WARM_UP: usize = 8;
/// How much longer than the fastest a control may take.
const DRIFT: f64 = 0.03;
/// How often rounds that are not counted are made up for.
const TRIES: usize = 4;
/// Timestamps of a query set: wgpu's limit.
const MOST_QUERIES: usize = 4096;
/// What the control should take on a GPU, in milliseconds.
const CONTROL: f64 = 0.05;
/// The control's workgroups.
const CONTROL_GROUPS: u32 = 1056;

const TEXT: &str = include_str!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/shaders/bench/control.wgsl"
));

/// What a contender records.
type Record<'c> = dyn Fn(&mut wgpu::ComputePass, usize) + 'c;

/// Something that is timed: records its work for a round, whose number chooses among inputs.
pub(super) struct Contender<'c> {
    /// What it is called.
    pub(super) name: String,
    record: Box<Record<'c>>,
}

impl<'c> Contender<'c> {
    pub(super) fn new(
        name: impl Into<String>,
        record: impl Fn(&mut wgpu::ComputePass, usize) + 'c,
    ) -> Contender<'c> {
        Contender {
            name: name.into(),
            record: Box::new(record),
        }
    }
}

/// Milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Times {
    /// The median.
    pub median: f64,
    /// The 95th percentile.
    pub p95: f64,
}

impl Times {
    /// Of samples, at least one.
    pub(super) fn of(mut samples: Vec<f64>) -> Times {
        samples.sort_by(f64::total_cmp);
        let last = samples.len().saturating_sub(1);
        let at = |index: usize| samples.get(index.min(last)).copied().unwrap_or_default();
        Times {
            median: at(samples.len() / 2),
            p95: at(samples.len() * 95 / 100),
        }
    }
}

/// How steady the clock was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Drift {
    /// The control's time in the rounds that count, the median, over the fastest of the run.
    pub control: f64,
    /// Rounds that count.
    pub counted: usize,
    /// Rounds that do not, since the clock was down.
    pub rejected: usize,
    /// Whether too few counted, and all were scaled by the control.
    pub is_scaled: bool,
}

/// What contenders took.
#[derive(Clone)]
pub(super) struct Measured {
    pub(super) parts: Vec<Part>,
    pub(super) drift: Option<Drift>,
}

impl Measured {
    /// The time of a contender, the median in milliseconds.
    pub(super) fn of(&self, index: usize) -> f64 {
        self.parts[index].milliseconds
    }

    /// Both, and the less steady clock.
    pub(super) fn and(mut self, other: Measured) -> Measured {
        self.parts.extend(other.parts);
        self.drift = match (self.drift, other.drift) {
            (Some(a), Some(b)) => Some(Drift {
                control: a.control.max(b.control),
                counted: a.counted.min(b.counted),
                rejected: a.rejected + b.rejected,
                is_scaled: a.is_scaled || b.is_scaled,
            }),
            (a, b) => a.or(b),
        };
        self
    }

    /// The shortest time of some contenders, and who took it.
    pub(super) fn shortest(&self, of: std::ops::Range<usize>) -> (usize, f64) {
        let times = of.map(|index| (index, self.of(index)));
        times.fold((0, f64::INFINITY), |best, next| match next.1 < best.1 {
            true => next,
            false => best,
        })
    }
}

/// The clock of a run.
pub(super) struct Timer {
    control: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    /// The shortest control so far, in milliseconds.
    fastest: Cell<f64>,
    /// The last round's number: inputs go on rotating.
    round: Cell<usize>,
}

/// A round: for each contender what the control before it took, and what it took, in milliseconds.
type Round = Vec<[f64; 2]>;

impl Timer {
    /// Makes a control that takes some 50 µs, and waits until the clock is up.
    pub(super) fn new(gpu: &Gpu) -> Result<Timer, BenchError> {
        let stage::Original { pipeline, layout } = stage::original(gpu, TEXT, "control");
        let out = gpu.buffer("control", &[0; 16], wgpu::BufferUsages::STORAGE);
        let mut rounds = 1u32;
        loop {
            let count = gpu.buffer(
                "control",
                bytemuck::cast_slice(&[rounds, 0, 0, 0]),
                wgpu::BufferUsages::UNIFORM,
            );
            let resources = [(0, count.as_entire_binding()), (1, out.as_entire_binding())];
            let timer = Timer {
                control: pipeline.clone(),
                group: stage::group(gpu, &layout, &resources),
                fastest: Cell::new(f64::INFINITY),
                round: Cell::new(0),
            };
            timer.settle(gpu)?;
            if timer.fastest.get() >= CONTROL || rounds >= 1 << 20 {
                return Ok(timer);
            }
            let more = CONTROL / timer.fastest.get().max(CONTROL / 16.0);
            rounds = (f64::from(rounds) * more * 1.2).ceil() as u32 + 1;
        }
    }

    /// Times contenders over `rounds` counted rounds.
    pub(super) fn measure(
        &self,
        gpu: &Gpu,
        rounds: usize,
        contenders: &[Contender],
    ) -> Result<Measured, BenchError> {
        let mut all: Vec<Round> = Vec::new();
        let mut counted = Vec::new();
        for _ in 0..TRIES {
            self.settle(gpu)?;
            let wanted = rounds - counted.len();
            all.extend(self.rounds(gpu, wanted, contenders)?);
            counted = self.steady(gpu, &all);
            if counted.len() >= rounds {
                break;
            }
        }
        let is_scaled = counted.len() < rounds.div_ceil(2);
        let fastest = self.fastest.get();
        let taken: Vec<Round> = match is_scaled {
            false => counted.iter().map(|&round| all[round].clone()).collect(),
            true => {
                let scaled = |[control, time]: [f64; 2]| [control, time * fastest / control];
                all.iter()
                    .map(|round| round.iter().copied().map(scaled).collect())
                    .collect()
            }
        };
        let parts = contenders.iter().enumerate().map(|(index, contender)| {
            let times = taken.iter().map(|round| round[index][1]).collect();
            Part::new(&contender.name, Times::of(times))
        });
        let controls = taken.iter().flatten().map(|sample| sample[0]).collect();
        Ok(Measured {
            parts: parts.collect(),
            drift: Some(Drift {
                control: Times::of(controls).median / fastest,
                counted: taken.len(),
                rejected: all.len() - taken.len(),
                is_scaled,
            }),
        })
    }

    /// The rounds whose controls were all as fast as ever; of a software driver all, whose threads have no one clock.
    fn steady(&self, gpu: &Gpu, all: &[Round]) -> Vec<usize> {
        let most = self.fastest.get() * (1.0 + DRIFT);
        let is_steady = |round: &Round| round.iter().all(|sample| sample[0] <= most);
        let steady = |&index: &usize| gpu.is_software() || is_steady(&all[index]);
        (0..all.len()).filter(steady).collect()
    }

    /// Runs the control until it is as fast as it ever was, or for two seconds.
    fn settle(&self, gpu: &Gpu) -> Result<(), BenchError> {
        let start = Instant::now();
        // a first look at the clock takes longer: nobody knows yet how fast it can be
        let least = match self.fastest.get().is_finite() || gpu.is_software() {
            true => Duration::ZERO,
            false => Duration::from_millis(400),
        };
        loop {
            if !gpu.is_software() {
                for _ in 0..200 {
                    let mut encoder = gpu.encoder();
                    self.control_pass(&mut encoder, None);
                    gpu.queue.submit([encoder.finish()]);
                }
                gpu.wait()?;
            }
            let before = self.fastest.get();
            let rounds = self.rounds_of(gpu, 0, 4, &[])?;
            let taken = rounds.iter().flatten().map(|sample| sample[0]);
            let slowest = taken.fold(0.0, f64::max);
            let is_up = slowest <= before.min(self.fastest.get()) * (1.0 + DRIFT / 2.0);
            let waited = start.elapsed();
            if (is_up && waited >= least) || gpu.is_software() || waited > Duration::from_secs(2) {
                return Ok(());
            }
        }
    }

    fn control_pass(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stamps: Option<wgpu::ComputePassTimestampWrites>,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("control"),
            timestamp_writes: stamps,
        });
        pass.set_pipeline(&self.control);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(CONTROL_GROUPS, 1, 1);
    }

    /// Rounds, after those that are not counted, in as many query sets as they need.
    fn rounds(
        &self,
        gpu: &Gpu,
        rounds: usize,
        contenders: &[Contender],
    ) -> Result<Vec<Round>, BenchError> {
        let most = (MOST_QUERIES / (4 * contenders.len().max(1))).max(1);
        let mut all = Vec::new();
        let mut warm_up = WARM_UP;
        while all.len() < rounds {
            let next = (rounds - all.len()).min(most);
            all.extend(self.rounds_of(gpu, warm_up, next, contenders)?);
            warm_up = 0;
        }
        Ok(all)
    }

    /// Without contenders, of the control alone.
    fn rounds_of(
        &self,
        gpu: &Gpu,
        warm_up: usize,
        rounds: usize,
        contenders: &[Contender],
    ) -> Result<Vec<Round>, BenchError> {
        let width = contenders.len().max(1);
        let samples = width * rounds;
        let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("vrcs bench"),
            ty: wgpu::QueryType::Timestamp,
            count: 4 * samples as u32,
        });
        let ticks = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("vrcs bench"),
            size: 32 * samples as u64,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        for round in 0..warm_up + rounds {
            let number = self.round.replace(self.round.get() + 1);
            for turn in 0..width {
                let index = (round + turn) % width;
                let stamps = |first: u32| {
                    let sample = round.checked_sub(warm_up)? * width + index;
                    Some(wgpu::ComputePassTimestampWrites {
                        query_set: &set,
                        beginning_of_pass_write_index: Some(4 * sample as u32 + first),
                        end_of_pass_write_index: Some(4 * sample as u32 + first + 1),
                    })
                };
                let mut control = gpu.encoder();
                self.control_pass(&mut control, stamps(0));
                let mut encoder = gpu.encoder();
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: contenders
                        .get(index)
                        .map(|contender| contender.name.as_str()),
                    timestamp_writes: stamps(2),
                });
                if let Some(contender) = contenders.get(index) {
                    (contender.record)(&mut pass, number);
                }
                drop(pass);
                // two submissions, since passes of one may overlap; both are recorded first, so that the GPU need not wait between them
                let both = [control.finish(), encoder.finish()];
                for commands in both {
                    gpu.queue.submit([commands]);
                }
            }
            gpu.check()?;
        }
        let mut encoder = gpu.encoder();
        encoder.resolve_query_set(&set, 0..4 * samples as u32, &ticks, 0);
        let bytes = gpu.submit_and_read(encoder, &[&ticks])?;
        let words: Vec<u64> = bytes[0]
            .chunks_exact(8)
            .map(|b| u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]))
            .collect();
        let period = f64::from(gpu.queue.get_timestamp_period()) / 1e6;
        let took = |at: usize| words[at + 1].saturating_sub(words[at]) as f64 * period;
        let all: Vec<Round> = (0..rounds)
            .map(|round| {
                let first = round * width;
                let samples = first..first + width;
                samples.map(|s| [took(4 * s), took(4 * s + 2)]).collect()
            })
            .collect();
        let controls = all.iter().flatten().map(|sample| sample[0]);
        let fastest = controls
            .filter(|&time| time > 0.0)
            .fold(self.fastest.get(), f64::min);
        self.fastest.set(fastest);
        Ok(all)
    }
}
