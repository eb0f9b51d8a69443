//! A scene on a device, ready to try settings on: error and time of each.
//!
//! *Does*: runs an animation at a setting, with the feedback that a renderer would have; compares its last frames with the same
//! frames at full rate; then, apart from that, times every pass beside its full-rate original. *Guarantees*: each timed
//! frame runs both, in alternating order, over moving pictures, after a warm-up, beside a pass that never changes; a picture
//! is poisoned before a setting draws it, so that what was not drawn shows.

use std::{
    cell::RefCell,
    collections::{BTreeMap, BTreeSet},
    rc::Rc,
};

use rayon::prelude::*;
use vrcs_passes::Options as Rewrite;

use super::{
    Trouble,
    clock::{Clock, FrameTimes, Recorder, quantile},
    realise::{Realised, realise},
    rig::{Left, Rig},
    setting::Setting,
    study::{Errors, PassTime, Times},
};
use crate::{
    Rate,
    check::gpu::{Gpu, adapters},
    metrics::{self, Shown},
    scenes::{
        SceneName,
        frame::Frame,
        stage::{Rewritten, Stage, rewrite},
    },
    sri::Sri,
};

/// The animation's first frame: far enough in that everything moves.
const FIRST: u32 = 30;
/// Frames before anything is measured, in which the analysis finds its history.
const WARM: u32 = 3;
/// Frames that are compared, at most: one for each phase of rotating primaries.
const COMPARED: u32 = 4;
/// The name of the pass that never changes.
pub const CONTROL: &str = "control";
/// What full-rate passes are called before their own name.
const FULL: &str = "full rate ";

/// A scene on a device.
pub struct Bench<'g> {
    gpu: &'g Gpu,
    adapter: Option<wgpu::Adapter>,
    scene: SceneName,
    size: [u32; 2],
    seed: u64,
    stage: Stage,
    poison: wgpu::Texture,
    rewritten: RefCell<Vec<(Rewrite, Rc<Rewritten>)>>,
    full: RefCell<BTreeMap<u32, Rc<Vec<u8>>>>,
}

/// What a setting looks like.
#[derive(Clone, Debug)]
pub struct Look {
    /// Against full rate.
    pub error: Errors,
    /// Whether the compared pictures have the full-rate pictures' bytes.
    pub identical: bool,
    /// The share of pixels that are shaded, sky that is skipped not among them; mean over the frames.
    pub primary_share: f64,
    /// The share of waves that find nothing to do, of a tiled dispatch; mean over the frames.
    pub retired_share: f64,
    /// Shaded pixels for each pixel by rates alone; mean over the frames.
    pub average_rate: f64,
    /// What the last frame left.
    pub left: Left,
    /// The last frame's picture.
    pub picture: Vec<u8>,
    /// The last frame at full rate.
    pub full: Rc<Vec<u8>>,
    /// The ꟻLIP map of the last frame.
    pub map: Vec<u8>,
}

impl<'g> Bench<'g> {
    /// Puts a scene on a device.
    ///
    /// # Errors
    /// If the device lacks what it needs.
    pub fn new(
        gpu: &'g Gpu,
        scene: SceneName,
        size: [u32; 2],
        seed: u64,
    ) -> Result<Bench<'g>, Trouble> {
        let adapter = adapters()
            .into_iter()
            .find(|adapter| adapter.get_info().name == gpu.info.name);
        let rewrite = Rewrite::default();
        let stage = Stage::new(gpu, scene, size, &rewrite)?;
        let poison = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("poison"),
            size: stage.picture().size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: stage.picture().format(),
            usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let magenta = [255, 0, 255, 0].repeat(size[0] as usize * size[1] as usize);
        gpu.queue.write_texture(
            poison.as_image_copy(),
            &magenta,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(size[0] * 4),
                rows_per_image: None,
            },
            poison.size(),
        );
        gpu.check()?;
        Ok(Bench {
            gpu,
            adapter,
            scene,
            size,
            seed,
            stage,
            poison,
            rewritten: RefCell::default(),
            full: RefCell::default(),
        })
    }

    /// The scene.
    pub fn scene(&self) -> SceneName {
        self.scene
    }

    /// Width and height of the pictures.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// A setting at work on the scene.
    ///
    /// # Errors
    /// If the device lacks what it needs.
    pub fn rig(&self, realised: Realised) -> Result<Rig<'_>, Trouble> {
        let mut known = self.rewritten.borrow_mut();
        let found = known
            .iter()
            .find(|(options, _)| *options == realised.rewrite)
            .map(|(_, rewritten)| Rc::clone(rewritten));
        let rewritten = match found {
            Some(rewritten) => rewritten,
            None => {
                let made = Rc::new(rewrite(self.gpu, self.scene, &realised.rewrite)?);
                known.push((realised.rewrite.clone(), Rc::clone(&made)));
                made
            }
        };
        Rig::new(
            self.gpu,
            self.adapter.as_ref(),
            &self.stage,
            rewritten,
            realised,
        )
    }

    fn set_frame(&self, number: u32) {
        let frame = Frame::new(self.scene, number, self.size, self.seed as u32);
        self.stage.set_frame(&self.gpu.queue, &frame);
    }

    /// The last frame of an animation of so many frames.
    pub fn last(frames: u32) -> u32 {
        FIRST + WARM + frames - 1
    }

    /// A frame at full rate, RGBA.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn full(&self, number: u32) -> Result<Rc<Vec<u8>>, Trouble> {
        if let Some(known) = self.full.borrow().get(&number) {
            return Ok(Rc::clone(known));
        }
        self.set_frame(number);
        let mut recorder = Recorder::untimed(self.gpu);
        recorder.pass(CONTROL, |pass| self.stage.record_geometry(pass));
        self.record_full(&mut recorder);
        let picture = self
            .gpu
            .read_rgba8(recorder.encoder, self.stage.picture())?;
        let picture = Rc::new(picture);
        self.full.borrow_mut().insert(number, Rc::clone(&picture));
        Ok(picture)
    }

    fn record_full(&self, recorder: &mut Recorder) {
        for &name in self.scene.passes() {
            let label = format!("{FULL}{}", name.entry());
            recorder.pass(&label, |pass| self.stage.record_full_rate(pass, name));
        }
    }

    /// A frame as a rig draws it.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn draw(&self, rig: &mut Rig, number: u32) -> Result<Vec<u8>, Trouble> {
        self.set_frame(number);
        let mut recorder = Recorder::untimed(self.gpu);
        recorder.encoder.copy_texture_to_texture(
            self.poison.as_image_copy(),
            self.stage.picture().as_image_copy(),
            self.poison.size(),
        );
        recorder.pass(CONTROL, |pass| self.stage.record_geometry(pass));
        rig.record(&mut recorder, number)?;
        Ok(self
            .gpu
            .read_rgba8(recorder.encoder, self.stage.picture())?)
    }

    /// What a setting looks like over so many frames.
    ///
    /// # Errors
    /// If the setting cannot be had, or the device was lost.
    pub fn look(&self, setting: &Setting, frames: u32) -> Result<Look, Trouble> {
        let realised = realise(self.scene, setting, true).map_err(Trouble::Setting)?;
        let largest = realised.build.map_or(Rate::R1X1, |build| build.largest);
        let mut rig = self.rig(realised)?;
        for number in FIRST..FIRST + WARM {
            self.draw(&mut rig, number)?;
        }
        let mut before = rig.left()?.sri;
        let (mut flips, mut primaries, mut retired, mut rates) = (0.0, 0.0, 0.0, 0.0);
        let mut compared = Vec::new();
        let last = Bench::last(frames);
        for number in FIRST + WARM..=last {
            let picture = self.draw(&mut rig, number)?;
            let left = rig.left()?;
            flips += metrics::flips(&before, &left.sri);
            primaries += left.statistics.primary_share();
            retired += left.statistics.retired_share();
            rates += average_rate(&left.sri, largest);
            before = left.sri.clone();
            if number + COMPARED > last {
                compared.push((number, picture, left));
            }
        }
        // full-rate frames are drawn after: the rig's own history is not theirs
        let mut pairs = Vec::new();
        for (number, picture, _) in &compared {
            pairs.push((self.full(*number)?.as_ref().clone(), picture.clone()));
        }
        let (error, identical, map) = compare(self.size, &pairs, flips / f64::from(frames));
        let Some((_, picture, left)) = compared.pop() else {
            return Err(Trouble::Own("no frame was compared".to_owned()));
        };
        let mean = |sum: f64| sum / f64::from(frames);
        Ok(Look {
            error,
            identical,
            primary_share: mean(primaries),
            retired_share: mean(retired),
            average_rate: mean(rates),
            left,
            picture,
            full: self.full(last)?,
            map,
        })
    }

    /// What a setting takes, over so many frames after `warm` others.
    ///
    /// # Errors
    /// If the setting cannot be had, or the device has no clock or was lost.
    pub fn time(&self, setting: &Setting, warm: u32, rounds: u32) -> Result<Times, Trouble> {
        let realised = realise(self.scene, setting, false).map_err(Trouble::Setting)?;
        let mut rig = self.rig(realised)?;
        let mut clock = Clock::new(self.gpu)?;
        for round in 0..warm + rounds {
            let number = FIRST + round;
            self.set_frame(number);
            let mut done = Ok(());
            clock.frame(self.gpu, |recorder| {
                recorder.pass(CONTROL, |pass| self.stage.record_geometry(pass));
                if round % 2 == 0 {
                    self.record_full(recorder);
                }
                done = rig.record(recorder, number);
                if round % 2 == 1 {
                    self.record_full(recorder);
                }
            })?;
            done?;
        }
        let all = clock.finish(self.gpu)?;
        let timed = all.get(warm as usize..).unwrap_or_default();
        Ok(summarise(self.scene, timed))
    }
}

/// Medians and 95th percentiles of timed frames. What does not run in every frame counts for the share of frames in which it
/// runs.
fn summarise(scene: SceneName, frames: &[FrameTimes]) -> Times {
    let of = |name: &str| -> Vec<f64> {
        let known = frames.iter().filter_map(|times| times.get(name));
        known.copied().collect()
    };
    let amortised = |name: &str| {
        let samples = of(name);
        quantile(&samples, 0.5) * samples.len() as f64 / frames.len().max(1) as f64
    };
    let sum = |is_in: &dyn Fn(&str) -> bool| -> Vec<f64> {
        frames
            .iter()
            .map(|times| {
                let parts = times.iter().filter(|(name, _)| is_in(name));
                parts.map(|(_, ms)| ms).sum()
            })
            .collect()
    };
    let is_own = |name: &str| !name.starts_with(FULL) && name != CONTROL;
    let full = sum(&|name| name.starts_with(FULL));
    let variable = sum(&is_own);
    let names: BTreeSet<&str> = frames
        .iter()
        .flat_map(|times| times.keys().map(String::as_str))
        .collect();
    let order = |name: &str| {
        let known = ["camera motion", "analyse", "granularity", "build"];
        let shading = scene.passes().iter().map(|pass| pass.entry());
        known.into_iter().chain(shading).position(|k| k == name)
    };
    let mut own: Vec<&str> = names.iter().copied().filter(|name| is_own(name)).collect();
    own.sort_by_key(|name| order(name).unwrap_or(usize::MAX));
    let runs_always = own.iter().all(|name| of(name).len() == frames.len());
    let passes: Vec<PassTime> = own
        .into_iter()
        .map(|name| {
            let original = format!("{FULL}{name}");
            PassTime {
                name: name.to_owned(),
                full_ms: names
                    .contains(original.as_str())
                    .then(|| amortised(&original)),
                variable_ms: amortised(name),
            }
        })
        .collect();
    Times {
        full_ms: quantile(&full, 0.5),
        full_p95_ms: quantile(&full, 0.95),
        // frames of two kinds have no median that stands for both
        variable_ms: match runs_always {
            true => quantile(&variable, 0.5),
            false => passes.iter().map(|pass| pass.variable_ms).sum(),
        },
        variable_p95_ms: quantile(&variable, 0.95),
        control_ms: amortised(CONTROL),
        control_p95_ms: quantile(&of(CONTROL), 0.95),
        passes,
    }
}

/// A pair of pictures, compared.
struct Compared {
    flip: metrics::Flip,
    ssim: f64,
    square: f64,
    seam: f64,
}

/// Compares pairs of pictures: full rate, variable rate. Also whether all are equal, and the last ꟻLIP map.
fn compare(size: [u32; 2], pairs: &[(Vec<u8>, Vec<u8>)], flips: f64) -> (Errors, bool, Vec<u8>) {
    let found: Vec<Compared> = pairs
        .par_iter()
        .map(|(full, variable)| {
            let (full, variable) = (Shown::new(size, full), Shown::new(size, variable));
            Compared {
                flip: metrics::flip(full, variable),
                ssim: metrics::ssim(full, variable),
                // an infinite distance from noise is no square error
                square: 255.0f64.powi(2) / 10f64.powf(metrics::psnr(full, variable) / 10.0),
                seam: metrics::seam(full, variable, Rewrite::default().tile),
            }
        })
        .collect();
    let mean =
        |of: &dyn Fn(&Compared) -> f64| found.iter().map(of).sum::<f64>() / found.len() as f64;
    let square = mean(&|c| c.square);
    let error = Errors {
        flip_mean: mean(&|c| c.flip.mean),
        flip_p99: mean(&|c| c.flip.p99),
        ssim: mean(&|c| c.ssim),
        psnr: (square > 0.0).then(|| 10.0 * (255.0f64.powi(2) / square).log10()),
        seam: mean(&|c| c.seam),
        flips,
    };
    let identical = pairs.iter().all(|(full, variable)| full == variable);
    let map = found.into_iter().next_back();
    (error, identical, map.map_or_else(Vec::new, |c| c.flip.map))
}

/// Shaded pixels for each pixel, by rates alone.
pub fn average_rate(sri: &Sri, largest: Rate) -> f64 {
    let layout = sri.layout();
    let shaded: f64 = (0..layout.height)
        .flat_map(|y| (0..layout.width).map(move |x| (x, y)))
        .map(|(x, y)| 1.0 / f64::from(sri.rate(x, y, largest).pixels()))
        .sum();
    shaded / (f64::from(layout.width) * f64::from(layout.height))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(parts: &[(&str, f64)]) -> FrameTimes {
        parts
            .iter()
            .map(|&(name, ms)| (name.to_owned(), ms))
            .collect()
    }

    #[test]
    fn what_runs_in_every_other_frame_counts_half() {
        let with = [
            (CONTROL, 1.0),
            ("full rate material", 10.0),
            ("analyse", 4.0),
            ("material", 5.0),
        ];
        let without = [with[0], with[1], with[3]];
        let frames: Vec<FrameTimes> = (0..10)
            .map(|i| match i % 2 {
                0 => frame(&with),
                _ => frame(&without),
            })
            .collect();
        let found = summarise(SceneName::Ramps, &frames);
        assert_eq!((found.full_ms, found.control_ms), (10.0, 1.0));
        assert_eq!((found.variable_ms, found.variable_p95_ms), (7.0, 9.0));
        assert_eq!((found.machinery_ms(), found.share()), (2.0, 0.7));
        assert_eq!(found.passes[0].name, "analyse");
        assert_eq!(found.passes[1].full_ms, Some(10.0));
        assert_eq!(found.saved_share(), 0.5);
    }

    #[test]
    fn of_no_frames_there_is_no_time() {
        assert_eq!(summarise(SceneName::Ramps, &[]), Times::default());
    }
}
