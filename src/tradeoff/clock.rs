//! Times of passes by the GPU's own clock.
//!
//! *Does*: records compute passes into an encoder, each by a name, and gives their times when the GPU has them. *Needs*: a device
//! with timestamps. *Guarantees*: nothing waits while fewer than a few frames are under way, so the GPU does not idle.

use std::collections::BTreeMap;

use wgpu_profiler::{GpuProfiler, GpuProfilerSettings};

use super::Trouble;
use crate::check::gpu::Gpu;

/// Frames that may be under way.
const UNDER_WAY: usize = 3;

/// Milliseconds of each name in a frame; passes of one name are summed.
pub type FrameTimes = BTreeMap<String, f64>;

/// Records passes, timed or not.
pub struct Recorder<'r> {
    /// What is recorded into.
    pub encoder: wgpu::CommandEncoder,
    profiler: Option<&'r GpuProfiler>,
}

impl<'r> Recorder<'r> {
    /// One that takes no times.
    pub fn untimed(gpu: &Gpu) -> Recorder<'r> {
        Recorder {
            encoder: gpu.encoder(),
            profiler: None,
        }
    }

    /// Records a compute pass.
    pub fn pass(&mut self, name: &str, record: impl FnOnce(&mut wgpu::ComputePass)) {
        let query = self
            .profiler
            .map(|profiler| profiler.begin_pass_query(name, &mut self.encoder));
        record(
            &mut self
                .encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(name),
                    timestamp_writes: query
                        .as_ref()
                        .and_then(|query| query.compute_pass_timestamp_writes()),
                }),
        );
        if let (Some(profiler), Some(query)) = (self.profiler, query) {
            profiler.end_query(&mut self.encoder, query);
        }
    }
}

/// Times frames.
pub struct Clock {
    profiler: GpuProfiler,
    under_way: usize,
    found: Vec<FrameTimes>,
}

impl Clock {
    /// A clock.
    ///
    /// # Errors
    /// If the device has no timestamps.
    pub fn new(gpu: &Gpu) -> Result<Clock, Trouble> {
        let has = gpu
            .device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY);
        if !has {
            return Err(Trouble::NoClock(gpu.info.name.clone()));
        }
        let settings = GpuProfilerSettings {
            enable_debug_groups: false,
            max_num_pending_frames: UNDER_WAY + 1,
            ..GpuProfilerSettings::default()
        };
        let profiler = GpuProfiler::new(&gpu.device, settings)
            .map_err(|error| Trouble::Own(error.to_string()))?;
        Ok(Clock {
            profiler,
            under_way: 0,
            found: Vec::new(),
        })
    }

    /// Submits a frame.
    ///
    /// # Errors
    /// If the device refused something, or was lost.
    pub fn frame(&mut self, gpu: &Gpu, record: impl FnOnce(&mut Recorder)) -> Result<(), Trouble> {
        let mut recorder = Recorder {
            encoder: gpu.encoder(),
            profiler: Some(&self.profiler),
        };
        record(&mut recorder);
        let mut encoder = recorder.encoder;
        self.profiler.resolve_queries(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        self.profiler
            .end_frame()
            .map_err(|error| Trouble::Own(error.to_string()))?;
        self.under_way += 1;
        if self.under_way >= UNDER_WAY {
            self.collect(gpu)?;
        }
        Ok(())
    }

    /// The times of all frames since the last call, in order.
    ///
    /// # Errors
    /// If the device refused something, or was lost.
    pub fn finish(&mut self, gpu: &Gpu) -> Result<Vec<FrameTimes>, Trouble> {
        self.collect(gpu)?;
        Ok(std::mem::take(&mut self.found))
    }

    fn collect(&mut self, gpu: &Gpu) -> Result<(), Trouble> {
        gpu.wait()?;
        gpu.check()?;
        let period = gpu.queue.get_timestamp_period();
        while self.under_way > 0 {
            let Some(results) = self.profiler.process_finished_frame(period) else {
                return Err(Trouble::Own("the GPU's times did not come".to_owned()));
            };
            let mut times = FrameTimes::new();
            for result in results {
                let Some(range) = result.time else {
                    return Err(Trouble::NoClock(gpu.info.name.clone()));
                };
                *times.entry(result.label).or_default() += (range.end - range.start) * 1e3;
            }
            self.found.push(times);
            self.under_way -= 1;
        }
        Ok(())
    }
}

/// The value that a share of the samples stay at or below (nearest rank); 0 of nothing.
pub fn quantile(samples: &[f64], share: f64) -> f64 {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted
        .get(rank.clamp(1, sorted.len().max(1)) - 1)
        .copied()
        .unwrap_or_default()
}

/// An interval that holds the median of what the samples are drawn from in 95 of 100 cases, whatever its distribution: between
/// two of the samples (order statistics). Of fewer than six samples no such interval is known; it is then from the least to the most.
pub fn median_interval(samples: &[f64]) -> [f64; 2] {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (Some(&least), Some(&most)) = (sorted.first(), sorted.last()) else {
        return [0.0; 2];
    };
    // the chance that fewer than `k` of n samples lie below the median is that of fewer than `k` heads of n coins
    let n = sorted.len();
    let mut chance = 0.5f64.powi(n as i32);
    let (mut below, mut k) = (0.0, 0);
    while k < n && below + chance <= 0.025 {
        below += chance;
        k += 1;
        chance *= (n + 1 - k) as f64 / k as f64;
    }
    match k {
        0 => [least, most],
        k => [sorted[k - 1], sorted[n - k]],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_median_is_that_of_the_tables() {
        assert_eq!(median_interval(&[]), [0.0; 2]);
        assert_eq!(median_interval(&[4.0, 2.0, 9.0]), [2.0, 9.0]);
        // Conover, Practical Nonparametric Statistics: ranks 1 and 6 of 6, 2 and 9 of 10, 6 and 15 of 20
        for (n, low, high) in [(6, 1.0, 6.0), (10, 2.0, 9.0), (20, 6.0, 15.0)] {
            let samples: Vec<f64> = (1..=n).map(f64::from).collect();
            assert_eq!(median_interval(&samples), [low, high], "{n}");
        }
    }

    #[test]
    fn quantiles_are_samples() {
        assert_eq!(quantile(&[], 0.5), 0.0);
        assert_eq!(quantile(&[3.0], 0.95), 3.0);
        assert_eq!(quantile(&[4.0, 1.0, 3.0, 2.0], 0.5), 2.0);
        let many: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(quantile(&many, 0.95), 95.0);
        assert_eq!(quantile(&many, 1.0), 100.0);
    }
}
