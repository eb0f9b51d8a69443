//! Times of contenders, by the GPU's own clock.
//!
//! *Guarantees*: each sample is a submission of its own, so that no two overlap; contenders take turns, each round starting with another,
//! so that a clock that drifts meets all alike; the first rounds are not counted. *Needs*: timestamp queries.

use crate::check::gpu::{Gpu, GpuError};

/// Rounds that are not counted.
const WARM_UP: usize = 8;

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

/// Times contenders over `rounds` counted rounds.
pub(super) fn measure(
    gpu: &Gpu,
    rounds: usize,
    contenders: &[Contender],
) -> Result<Vec<Times>, GpuError> {
    let samples = contenders.len() * rounds;
    let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
        label: Some("vrcs bench"),
        ty: wgpu::QueryType::Timestamp,
        count: 2 * samples as u32,
    });
    let ticks = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("vrcs bench"),
        size: 16 * samples as u64,
        usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    for round in 0..WARM_UP + rounds {
        for turn in 0..contenders.len() {
            let index = (round + turn) % contenders.len();
            let sample = (round.saturating_sub(WARM_UP) * contenders.len() + index) as u32;
            let mut encoder = gpu.encoder();
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(&contenders[index].name),
                timestamp_writes: (round >= WARM_UP).then_some(wgpu::ComputePassTimestampWrites {
                    query_set: &set,
                    beginning_of_pass_write_index: Some(2 * sample),
                    end_of_pass_write_index: Some(2 * sample + 1),
                }),
            });
            (contenders[index].record)(&mut pass, round);
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
        }
        gpu.check()?;
    }
    let mut encoder = gpu.encoder();
    encoder.resolve_query_set(&set, 0..2 * samples as u32, &ticks, 0);
    let bytes = gpu.submit_and_read(encoder, &[&ticks])?;
    let words: Vec<u64> = bytes[0]
        .chunks_exact(8)
        .map(|b| u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]))
        .collect();
    let period = f64::from(gpu.queue.get_timestamp_period()) / 1e6;
    Ok((0..contenders.len())
        .map(|index| {
            let mut times: Vec<f64> = (0..rounds)
                .map(|round| {
                    let sample = 2 * (round * contenders.len() + index);
                    words[sample + 1].saturating_sub(words[sample]) as f64 * period
                })
                .collect();
            times.sort_by(f64::total_cmp);
            Times {
                median: times[rounds / 2],
                p95: times[(rounds * 95 / 100).min(rounds - 1)],
            }
        })
        .collect())
}
