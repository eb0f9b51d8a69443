//! Times of compute passes: by the GPU's own timestamps where it has them, else by the host's clock.

use std::time::Instant;

use crate::check::gpu::{Gpu, GpuError};

/// Times one compute pass at a time.
pub(super) struct Timer {
    queries: Option<(wgpu::QuerySet, wgpu::Buffer)>,
}

impl Timer {
    pub(super) fn new(gpu: &Gpu) -> Timer {
        let has = gpu
            .device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY);
        let queries = has.then(|| {
            let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("times"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            });
            let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("times"),
                size: 16,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            (set, buffer)
        });
        Timer { queries }
    }

    pub(super) fn by_gpu(&self) -> bool {
        self.queries.is_some()
    }

    /// Milliseconds that a pass takes.
    pub(super) fn time(
        &mut self,
        gpu: &Gpu,
        record: impl FnOnce(&mut wgpu::ComputePass),
    ) -> Result<f64, GpuError> {
        let mut encoder = gpu.encoder();
        let Some((set, buffer)) = &self.queries else {
            record(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()));
            let start = Instant::now();
            gpu.queue.submit([encoder.finish()]);
            gpu.wait()?;
            return Ok(start.elapsed().as_secs_f64() * 1e3);
        };
        record(
            &mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("timed"),
                timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                    query_set: set,
                    beginning_of_pass_write_index: Some(0),
                    end_of_pass_write_index: Some(1),
                }),
            }),
        );
        encoder.resolve_query_set(set, 0..2, buffer, 0);
        let read = gpu.submit_and_read(encoder, &[buffer])?;
        let ticks: Vec<u64> = read[0]
            .chunks_exact(8)
            .map(|bytes| {
                let mut word = [0; 8];
                word.copy_from_slice(bytes);
                u64::from_le_bytes(word)
            })
            .collect();
        let period = f64::from(gpu.queue.get_timestamp_period());
        Ok(ticks[1].saturating_sub(ticks[0]) as f64 * period / 1e6)
    }
}

/// The median; 0 of nothing.
pub(super) fn median(mut samples: Vec<f64>) -> f64 {
    samples.sort_by(f64::total_cmp);
    samples.get(samples.len() / 2).copied().unwrap_or_default()
}
