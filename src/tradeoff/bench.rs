//! A scene on a device, ready to try settings on: error and time of each.
//!
//! *Does*: runs an animation at a setting, with the feedback that a renderer would have; compares its last frames with the same
//! frames at full rate; then, apart from that, times settings and full rate in [turns]. *Guarantees*: a picture is poisoned before a
//! setting draws it, so that what was not drawn shows.
//!
//! [turns]: super::turns

use std::{cell::RefCell, collections::BTreeMap, rc::Rc, sync::Arc};

use rayon::prelude::*;
use vrcs_passes::Options as Rewrite;

use super::{
    Trouble,
    clock::{Clock, FrameTimes, Recorder},
    realise::{Realised, realise},
    rig::{Kernels, Left, Rig},
    setting::Setting,
    study::{Errors, Seen},
    turns::{Round, Rounds, Taken, take},
};
use crate::{
    Rate,
    check::gpu::{Gpu, adapters},
    flat,
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
pub const COMPARED: u32 = 4;
/// The name of the pass that never changes.
pub const CONTROL: &str = "control";

/// A scene on a device.
pub struct Bench<'g> {
    gpu: &'g Gpu,
    adapter: Option<wgpu::Adapter>,
    scene: SceneName,
    size: [u32; 2],
    seed: u64,
    compared: u32,
    stage: Stage,
    poison: wgpu::Texture,
    kernels: Kernels,
    rewritten: RefCell<Vec<(Rewrite, Rc<Rewritten>)>>,
    full: RefCell<BTreeMap<u32, Arc<Vec<u8>>>>,
}

/// The last frame of an animation at a setting.
#[derive(Clone, Debug)]
pub struct Last {
    /// What it left.
    pub left: Left,
    /// Its picture, RGBA.
    pub picture: Vec<u8>,
    /// The same at full rate.
    pub full: Arc<Vec<u8>>,
    /// For each pixel, whether passes that have nothing to do in the sky skip it; nothing if none does.
    pub skipped: Option<Vec<bool>>,
}

/// A frame that was drawn.
struct Drawn {
    number: u32,
    /// Of the frames that are compared.
    picture: Option<Vec<u8>>,
    left: Left,
}

/// What a setting has drawn, not yet compared with full rate: needs no device any more.
#[derive(Debug)]
pub struct Uncompared {
    size: [u32; 2],
    /// All that is known without comparing.
    seen: Seen,
    /// Full rate, variable rate.
    pairs: Vec<(Arc<Vec<u8>>, Vec<u8>)>,
}

impl Uncompared {
    /// Bytes of the pictures of one, at most.
    pub fn bytes(size: [u32; 2]) -> u64 {
        u64::from(size[0]) * u64::from(size[1]) * 4 * u64::from(COMPARED)
    }

    /// Compares: processors' work, of seconds for large pictures.
    pub fn compare(self) -> Seen {
        let flips = self.seen.error.flips;
        let identical = self.pairs.iter().all(|(full, own)| full.as_ref() == own);
        Seen {
            identical,
            error: Errors {
                flips,
                ..compare(self.size, &self.pairs)
            },
            ..self.seen
        }
    }
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
        let usage = wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC;
        let format = stage.picture().format();
        let poison = gpu
            .device
            .create_texture(&flat::texture("poison", size, format, usage));
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
            compared: COMPARED,
            stage,
            poison,
            kernels: Kernels::default(),
            rewritten: RefCell::default(),
            full: RefCell::default(),
        })
    }

    /// Compares so many frames of each setting, the last, in place of [`COMPARED`].
    pub fn comparing(self, compared: u32) -> Bench<'g> {
        Bench { compared, ..self }
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
            &self.kernels,
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
    pub fn full(&self, number: u32) -> Result<Arc<Vec<u8>>, Trouble> {
        if let Some(known) = self.full.borrow().get(&number) {
            return Ok(Arc::clone(known));
        }
        self.set_frame(number);
        let mut recorder = Recorder::untimed(self.gpu);
        recorder.pass(CONTROL, |pass| self.stage.record_geometry(pass));
        self.record_full(&mut recorder);
        self.stage
            .record_transparents(&mut recorder.encoder.begin_compute_pass(&Default::default()));
        let picture = self.gpu.read_rgba8(recorder.encoder, self.stage.shown())?;
        let picture = Arc::new(picture);
        self.full.borrow_mut().insert(number, Arc::clone(&picture));
        Ok(picture)
    }

    fn record_full(&self, recorder: &mut Recorder) {
        for &name in self.scene.passes() {
            recorder.pass(name.entry(), |pass| self.stage.record_full_rate(pass, name));
        }
    }

    /// A frame as a rig draws it.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn draw(&self, rig: &mut Rig, number: u32) -> Result<Vec<u8>, Trouble> {
        let encoder = self.record(rig, number)?;
        Ok(self.gpu.read_rgba8(encoder, self.stage.shown())?)
    }

    fn record(&self, rig: &mut Rig, number: u32) -> Result<wgpu::CommandEncoder, Trouble> {
        self.set_frame(number);
        let mut recorder = Recorder::untimed(self.gpu);
        for poisoned in [self.stage.picture(), self.stage.shown()] {
            recorder.encoder.copy_texture_to_texture(
                self.poison.as_image_copy(),
                poisoned.as_image_copy(),
                self.poison.size(),
            );
        }
        recorder.pass(CONTROL, |pass| self.stage.record_geometry(pass));
        rig.record(&mut recorder, number)?;
        Ok(recorder.encoder)
    }

    /// Draws the animation at a setting, and tells of each frame after the warm-up. Pictures are read of those that are compared alone.
    fn play(&self, rig: &mut Rig, frames: u32, tell: &mut dyn FnMut(Drawn)) -> Result<(), Trouble> {
        let last = Bench::last(frames);
        for number in FIRST..=last {
            let picture = match number + self.compared > last {
                true => Some(self.draw(rig, number)?),
                false => {
                    let encoder = self.record(rig, number)?;
                    self.gpu.queue.submit([encoder.finish()]);
                    self.gpu.check()?;
                    None
                }
            };
            // the frame before the first that is told of is where flips are counted from
            if number + 1 >= FIRST + WARM {
                tell(Drawn {
                    number,
                    picture,
                    left: rig.left()?,
                });
            }
        }
        Ok(())
    }

    /// What a setting looks like over so many frames.
    ///
    /// # Errors
    /// If the setting cannot be had, or the device was lost.
    pub fn look(&self, setting: &Setting, frames: u32) -> Result<Seen, Trouble> {
        Ok(self.frames(setting, frames)?.compare())
    }

    /// Draws so many frames at a setting, to be compared later.
    ///
    /// # Errors
    /// If the setting cannot be had, or the device was lost.
    pub fn frames(&self, setting: &Setting, frames: u32) -> Result<Uncompared, Trouble> {
        let realised = realise(self.scene, setting, true).map_err(Trouble::Setting)?;
        let largest = realised.build.map_or(Rate::R1X1, |build| build.largest);
        let mut rig = self.rig(realised)?;
        let mut before: Option<Sri> = None;
        let mut seen = Seen::default();
        let mut compared = Vec::new();
        let share = 1.0 / f64::from(frames);
        self.play(&mut rig, frames, &mut |drawn| {
            let Drawn {
                number,
                picture,
                left,
            } = drawn;
            if let Some(before) = &before {
                seen.error.flips += share * metrics::flips(before, &left.sri);
                seen.primary_share += share * left.statistics.primary_share();
                seen.retired_share += share * left.statistics.retired_share();
                seen.average_rate += share * average_rate(&left.sri, largest);
                compared.extend(picture.map(|picture| (number, picture)));
            }
            before = Some(left.sri);
        })?;
        // full-rate frames are drawn after: the rig's own history is not theirs
        let mut pairs = Vec::new();
        for (number, picture) in compared {
            pairs.push((self.full(number)?, picture));
        }
        Ok(Uncompared {
            size: self.size,
            seen,
            pairs,
        })
    }

    /// The last frame of an animation at a setting.
    ///
    /// # Errors
    /// If the setting cannot be had, or the device was lost.
    pub fn show(&self, setting: &Setting, frames: u32) -> Result<Last, Trouble> {
        let realised = realise(self.scene, setting, true).map_err(Trouble::Setting)?;
        let skips_sky = realised
            .build
            .is_some_and(|build| build.coverage.sky.is_some());
        let mut rig = self.rig(realised)?;
        let mut last = None;
        self.play(&mut rig, frames, &mut |drawn| last = Some(drawn))?;
        let skipped = match skips_sky {
            true => Some(self.sky()?),
            false => None,
        };
        let Some(Drawn {
            number,
            picture: Some(picture),
            left,
        }) = last
        else {
            return Err(Trouble::Own("no frame was drawn".to_owned()));
        };
        Ok(Last {
            left,
            picture,
            full: self.full(number)?,
            skipped,
        })
    }

    /// For each pixel of the G-buffer, whether it shows the sky.
    fn sky(&self) -> Result<Vec<bool>, Trouble> {
        let Some(depth) = self.stage.texture("depth") else {
            return Err(Trouble::Own("sky is told by depth".to_owned()));
        };
        // depth is 32 bits a pixel, as RGBA is, and 0 is infinitely far
        let bytes = self.gpu.read_rgba8(self.gpu.encoder(), depth)?;
        Ok(bytes.chunks_exact(4).map(|d| d == [0; 4]).collect())
    }

    /// What settings take, timed in turns.
    ///
    /// # Errors
    /// If a setting cannot be had, or the device has no clock or was lost.
    pub fn time(&self, settings: &[&Setting], rounds: Rounds) -> Result<Taken, Trouble> {
        let mut rigs = Vec::new();
        for setting in settings {
            let realised = realise(self.scene, setting, false).map_err(Trouble::Setting)?;
            rigs.push(self.rig(realised)?);
        }
        let mut turns = Turns {
            bench: self,
            clock: Clock::new(self.gpu)?,
            rigs,
            chance: fastrand::Rng::with_seed(self.seed),
            number: FIRST,
        };
        turns.run(rounds.warm)?;
        take(rounds, |more| turns.run(more))
    }
}

/// Settings that take turns.
struct Turns<'b, 'g> {
    bench: &'b Bench<'g>,
    clock: Clock,
    rigs: Vec<Rig<'b>>,
    chance: fastrand::Rng,
    /// The next frame.
    number: u32,
}

impl Turns<'_, '_> {
    /// So many more rounds.
    fn run(&mut self, rounds: u32) -> Result<Vec<Round>, Trouble> {
        let mut orders = Vec::new();
        for _ in 0..rounds {
            let mut order: Vec<Option<usize>> = (0..self.rigs.len()).map(Some).collect();
            order.push(None);
            self.chance.shuffle(&mut order);
            self.round(&order)?;
            orders.push(order);
        }
        let mut found = self.clock.finish(self.bench.gpu)?.into_iter();
        let mut next = || found.next().unwrap_or_default();
        Ok(orders
            .iter()
            .map(|order| {
                let mut round = Round {
                    control: next().values().sum(),
                    full: FrameTimes::new(),
                    settings: vec![FrameTimes::new(); self.rigs.len()],
                };
                for turn in order {
                    match turn {
                        None => round.full = next(),
                        Some(index) => round.settings[*index] = next(),
                    }
                }
                round
            })
            .collect())
    }

    /// One frame: the control, then full rate (no index) and every setting in this order.
    fn round(&mut self, order: &[Option<usize>]) -> Result<(), Trouble> {
        let (bench, number) = (self.bench, self.number);
        self.number += 1;
        bench.set_frame(number);
        self.clock.frame(bench.gpu, |recorder| {
            recorder.pass(CONTROL, |pass| bench.stage.record_geometry(pass));
        })?;
        for turn in order {
            let rig = turn.and_then(|index| self.rigs.get_mut(index));
            let mut done = Ok(());
            self.clock.frame(bench.gpu, |recorder| match rig {
                None => bench.record_full(recorder),
                Some(rig) => done = rig.record(recorder, number),
            })?;
            done?;
        }
        Ok(())
    }
}

/// A pair of pictures, compared.
struct Compared {
    flip_mean: f64,
    flip_p99: f64,
    ssim: f64,
    square: f64,
    seam: f64,
}

impl Compared {
    fn new(size: [u32; 2], full: &[u8], variable: &[u8]) -> Compared {
        if full == variable {
            return Compared {
                flip_mean: 0.0,
                flip_p99: 0.0,
                ssim: 1.0,
                square: 0.0,
                seam: 1.0,
            };
        }
        let (full, variable) = (Shown::new(size, full), Shown::new(size, variable));
        let (flip, (ssim, rest)) = rayon::join(
            || metrics::flip(full, variable),
            || {
                rayon::join(
                    || metrics::ssim(full, variable),
                    || {
                        // an infinite distance from noise is no square error
                        let psnr = metrics::psnr(full, variable);
                        let square = 255.0f64.powi(2) / 10f64.powf(psnr / 10.0);
                        (
                            square,
                            metrics::seam(full, variable, Rewrite::default().tile),
                        )
                    },
                )
            },
        );
        let (square, seam) = rest;
        Compared {
            flip_mean: flip.mean,
            flip_p99: flip.p99,
            ssim,
            square,
            seam,
        }
    }
}

/// Compares pairs of pictures: full rate, variable rate. Flips are not seen in them.
fn compare(size: [u32; 2], pairs: &[(Arc<Vec<u8>>, Vec<u8>)]) -> Errors {
    let found: Vec<Compared> = pairs
        .par_iter()
        .map(|(full, variable)| Compared::new(size, full, variable))
        .collect();
    let mean =
        |of: &dyn Fn(&Compared) -> f64| found.iter().map(of).sum::<f64>() / found.len() as f64;
    let square = mean(&|c| c.square);
    Errors {
        flip_mean: mean(&|c| c.flip_mean),
        flip_p99: mean(&|c| c.flip_p99),
        ssim: mean(&|c| c.ssim),
        psnr: (square > 0.0).then(|| 10.0 * (255.0f64.powi(2) / square).log10()),
        seam: mean(&|c| c.seam),
        flips: 0.0,
    }
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
