//! A setting at work on a scene: analysis, build, passes and deblocker of one view, frame by frame.
//!
//! *Does*: records a frame's variable-rate part, then keeps what the next frame's analysis looks at. *Guarantees*: what
//! [`Realised`] does not have is not made; the first frame has no history and is shaded at full rate. *Needs*: a G-buffer
//! of the same frame, recorded before.
//!
//! The picture, depth and rates of the frame before are copied outside all timed passes: a renderer swaps them.

use std::{cell::RefCell, rc::Rc};

use super::{Trouble, clock::Recorder, granularity::Granularity, realise::Realised};
use crate::{
    Rate,
    analyse::{self, Analysis, gpu::BoundAnalysis},
    build::statistics::Statistics,
    check::gpu::{Gpu, by_construction},
    coverage,
    deblock::{self, Bound, Deblocker, Inputs, PictureInput, luma_pitch},
    flat,
    plan::{Binding, ColourForm, Plan},
    scenes::stage::{Rewritten, Stage},
    sri::{Sri, SriLayout},
    view::View,
};

/// Pipelines that settings share: most differ in numbers alone.
#[derive(Debug, Default)]
pub struct Kernels {
    analyses: RefCell<Vec<Analysis>>,
    deblockers: RefCell<Vec<Rc<Deblocker>>>,
}

impl Kernels {
    fn analysis(&self, device: &wgpu::Device, plan: &Plan) -> Result<Analysis, Trouble> {
        let mut known = self.analyses.borrow_mut();
        if let Some(found) = known.iter().find_map(|known| known.another(plan)) {
            return Ok(found);
        }
        let made = Analysis::new(device, plan).map_err(own)?;
        known.push(made.clone());
        Ok(made)
    }

    fn deblocker(
        &self,
        gpu: &Gpu,
        adapter: Option<&wgpu::Adapter>,
        options: deblock::Options,
    ) -> Result<Rc<Deblocker>, Trouble> {
        let mut known = self.deblockers.borrow_mut();
        if let Some(found) = known.iter().find(|known| *known.options() == options) {
            return Ok(Rc::clone(found));
        }
        let made = Deblocker::new(&gpu.device, adapter, options).map_err(own)?;
        let made = Rc::new(made);
        known.push(Rc::clone(&made));
        Ok(made)
    }
}

/// A setting at work.
pub struct Rig<'s> {
    gpu: &'s Gpu,
    stage: &'s Stage,
    rewritten: Rc<Rewritten>,
    realised: Realised,
    view: Option<View>,
    analysis: Option<Analysed>,
    granularity: Option<Granularity>,
    deblock: Option<(Rc<Deblocker>, Bound)>,
    frames: u32,
}

/// The analysis, and what it keeps from frame to frame.
struct Analysed {
    analysis: Analysis,
    bound: BoundAnalysis,
    /// The picture of the frame before.
    history: wgpu::Texture,
    /// The same after transparents.
    after: Option<wgpu::Texture>,
    depth: Option<wgpu::Texture>,
    rates: Option<wgpu::Buffer>,
    reasons: Option<wgpu::Buffer>,
}

/// What a frame left beside its picture.
#[derive(Clone, Debug)]
pub struct Left {
    /// The rates that were asked for.
    pub sri: Sri,
    /// What was counted, if it was.
    pub statistics: Statistics,
    /// A byte for each quad in the form of [`SriLayout`]: why it is not coarser; if it was asked for.
    pub reasons: Option<Vec<u8>>,
}

fn own(error: impl std::fmt::Display) -> Trouble {
    Trouble::Own(error.to_string())
}

fn view_of(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

impl<'s> Rig<'s> {
    /// Puts a setting to work. `rewritten` is the scene's passes with [`Realised::rewrite`].
    ///
    /// # Errors
    /// If the device lacks what it needs.
    pub fn new(
        gpu: &'s Gpu,
        adapter: Option<&wgpu::Adapter>,
        kernels: &Kernels,
        stage: &'s Stage,
        rewritten: Rc<Rewritten>,
        realised: Realised,
    ) -> Result<Rig<'s>, Trouble> {
        let size = stage.size();
        let view = match realised.build {
            None => None,
            Some(options) => {
                let extent = [size[0], size[1], 1];
                let builder = gpu.builder(options)?;
                let mut view = View::by(&gpu.device, &gpu.queue, extent, builder).map_err(own)?;
                cover(gpu, stage, &mut view)?;
                let full = Sri::uniform(size[0], size[1], Rate::R1X1);
                view.write_sri(&gpu.queue, &full).map_err(own)?;
                Some(view)
            }
        };
        let deblock = match (realised.deblock, &view) {
            (Some(options), Some(view)) => {
                let deblocker = kernels.deblocker(gpu, adapter, options)?;
                Some(deblocks(gpu, deblocker, stage, view)?)
            }
            _ => None,
        };
        let luma = deblock.as_ref().and_then(|(_, _, luma)| luma.clone());
        let analysis = match (&realised.analysis, &view) {
            (Some(plan), Some(view)) => Some(Analysed::new(gpu, kernels, stage, view, plan, luma)?),
            _ => None,
        };
        let granularity = match (&analysis, &view, realised.granularity) {
            (Some(_), Some(view), pixels) if pixels > 2 => Some(
                Granularity::new(&gpu.device, &gpu.queue, view.sri(), size, pixels).map_err(own)?,
            ),
            _ => None,
        };
        gpu.check()?;
        Ok(Rig {
            gpu,
            stage,
            rewritten,
            view,
            analysis,
            granularity,
            deblock: deblock.map(|(deblocker, bound, _)| (deblocker, bound)),
            realised,
            frames: 0,
        })
    }

    /// Sets rates from memory, in place of those of an analysis.
    ///
    /// # Errors
    /// If they are of another size.
    pub fn write_rates(&mut self, sri: &Sri) -> Result<(), Trouble> {
        match &self.view {
            Some(view) => view.write_sri(&self.gpu.queue, sri).map_err(own),
            None => Ok(()),
        }
    }

    /// Records the scene's frame `number`, whose G-buffer is there: rates, coordinates, passes, deblocking; then keeps what the next
    /// frame's analysis looks at.
    ///
    /// # Errors
    /// If the deblocker refuses the frame.
    pub fn record(&mut self, recorder: &mut Recorder, number: u32) -> Result<(), Trouble> {
        let size = self.stage.size();
        let Some(view) = &mut self.view else {
            for &name in self.stage.scene().passes() {
                recorder.pass(name.entry(), |pass| self.stage.record_full_rate(pass, name));
            }
            self.stage
                .record_transparents(&mut recorder.encoder.begin_compute_pass(&Default::default()));
            return Ok(());
        };
        if let Some(analysed) = &self.analysis
            && self.frames.is_multiple_of(self.realised.every)
        {
            let frame = analyse::Frame {
                has_history: self.frames > 0,
                ..analyse::Frame::of_size(size)
            };
            let Analysed {
                analysis, bound, ..
            } = analysed;
            analysis
                .set_frame(&self.gpu.queue, bound, &frame)
                .map_err(own)?;
            if self.realised.camera_motion {
                recorder.pass("camera motion", |pass| {
                    self.stage.record_camera_motion(pass)
                });
            }
            recorder.pass("analyse", |pass| analysis.record(pass, bound, &frame));
            if let Some(granularity) = &self.granularity {
                recorder.pass("granularity", |pass| granularity.record(pass));
            }
        }
        let mut order = 0;
        if self.realised.rotate {
            view.rotate(number);
            order = 1 + number % 4;
        }
        recorder.pass("build", |pass| by_construction(view.build_in(pass)));
        for &name in self.stage.scene().passes() {
            recorder.pass(name.entry(), |pass| {
                match self.realised.untouched.contains(&name) {
                    true => self.stage.record_full_rate(pass, name),
                    false => self
                        .stage
                        .record_rewritten(pass, name, &self.rewritten, view),
                }
            });
        }
        if let Some((deblocker, bound)) = &mut self.deblock {
            deblocker
                .set_frame(&self.gpu.queue, bound, size, order)
                .map_err(own)?;
            recorder.pass("deblock", |pass| {
                by_construction(deblocker.record_in(pass, bound));
            });
        }
        // as at full rate, and no part of what is compared
        self.stage
            .record_transparents(&mut recorder.encoder.begin_compute_pass(&Default::default()));
        if let Some(analysed) = &self.analysis {
            analysed.keep(&mut recorder.encoder, self.stage, view);
        }
        self.frames += 1;
        Ok(())
    }

    /// Reads what the frame left. Every rate is 1×1 and every pixel a primary where nothing was built.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn left(&self) -> Result<Left, Trouble> {
        let [width, height] = self.stage.size();
        let Some(view) = &self.view else {
            let pixels = u64::from(width) * u64::from(height);
            let mut statistics = Statistics {
                pixels,
                primaries: pixels,
                ..Statistics::default()
            };
            statistics.pixels_at[0] = pixels;
            return Ok(Left {
                sri: Sri::uniform(width, height, Rate::R1X1),
                statistics,
                reasons: None,
            });
        };
        let reasons = self
            .analysis
            .as_ref()
            .and_then(|analysed| analysed.reasons.as_ref());
        let buffers: Vec<&wgpu::Buffer> = [Some(view.sri()), view.statistics(), reasons]
            .into_iter()
            .flatten()
            .collect();
        let mut read = self
            .gpu
            .submit_and_read(self.gpu.encoder(), &buffers)?
            .into_iter();
        let codes = read.next().unwrap_or_default();
        let pitch = SriLayout::new(width, height).pitch;
        let sri = Sri::from_fn(width, height, |x, y| {
            codes.get((y * pitch + x) as usize).copied().unwrap_or(0)
        });
        let statistics = match view.statistics() {
            Some(_) => Statistics::read(&read.next().unwrap_or_default()),
            None => Statistics::default(),
        };
        Ok(Left {
            sri,
            statistics,
            reasons: reasons.and_then(|_| read.next()),
        })
    }
}

/// Gives the view the textures that its coverage declares.
fn cover(gpu: &Gpu, stage: &Stage, view: &mut View) -> Result<(), Trouble> {
    let declared = view.options().coverage;
    if declared.is_empty() {
        return Ok(());
    }
    let texture = |name: &str| stage.texture(name).map(view_of);
    let triangles = texture("ids").filter(|_| declared.triangles);
    let surfaces = texture("surfaces").filter(|_| declared.surfaces);
    let depth = texture("depth").filter(|_| declared.depth.is_some());
    let textures = coverage::Textures {
        triangles: triangles.as_ref(),
        surfaces: surfaces.as_ref(),
        depth: depth.as_ref(),
        ..coverage::Textures::default()
    };
    view.cover(&gpu.queue, &textures).map_err(own)
}

/// The deblocker on the scene's picture, and the root of luma that it leaves.
fn deblocks(
    gpu: &Gpu,
    deblocker: Rc<Deblocker>,
    stage: &Stage,
    view: &View,
) -> Result<(Rc<Deblocker>, Bound, Option<wgpu::Buffer>), Trouble> {
    let size = stage.size();
    let options = *deblocker.options();
    let picture = view_of(stage.picture());
    let depth = stage.texture("depth").map(view_of);
    let surfaces = stage.texture("surfaces").map(view_of);
    let bytes = luma_pitch(size[0]) as usize * size[1] as usize;
    let luma = options
        .luma
        .map(|_| gpu.buffer("root of luma", &vec![0; bytes], wgpu::BufferUsages::STORAGE));
    let inputs = Inputs {
        picture: PictureInput::Texture(&picture),
        rates: view
            .effective()
            .ok_or_else(|| own("a deblocker needs effective rates"))?,
        depth: depth.as_ref().filter(|_| options.depth.is_some()),
        surfaces: surfaces.as_ref().filter(|_| options.surfaces),
        luma: luma.as_ref(),
    };
    let mut bound = deblocker.bind(&gpu.device, &inputs).map_err(own)?;
    deblocker
        .set_frame(&gpu.queue, &mut bound, size, 0)
        .map_err(own)?;
    Ok((deblocker, bound, luma))
}

impl Analysed {
    fn new(
        gpu: &Gpu,
        kernels: &Kernels,
        stage: &Stage,
        view: &View,
        plan: &Plan,
        luma: Option<wgpu::Buffer>,
    ) -> Result<Analysed, Trouble> {
        let size = stage.size();
        let has = |binding| plan.bindings.contains(&binding);
        let copy_of = |label, format| {
            let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
            gpu.device
                .create_texture(&flat::texture(label, size, format, usage))
        };
        let zeros = vec![0; SriLayout::new(size[0], size[1]).bytes() as usize];
        let buffer = |label| gpu.buffer(label, &zeros, wgpu::BufferUsages::STORAGE);
        let history = copy_of("picture before", stage.picture().format());
        let after = has(Binding::After)
            .then(|| copy_of("picture before, after transparents", stage.shown().format()));
        let depth = has(Binding::PreviousDepth)
            .then(|| copy_of("depth before", wgpu::TextureFormat::R32Float));
        let rates = has(Binding::PreviousRates).then(|| buffer("rates before"));
        let reasons = has(Binding::Reasons).then(|| buffer("reasons"));
        let views: Vec<(Binding, wgpu::TextureView)> = [
            (Binding::Motion, "motion"),
            (Binding::Depth, "depth"),
            (Binding::Materials, "materials"),
            (Binding::Noise, "noise"),
        ]
        .into_iter()
        .filter_map(|(binding, name)| Some((binding, view_of(stage.texture(name)?))))
        .collect();
        let history_view = view_of(&history);
        let depth_view = depth.as_ref().map(view_of);
        let after_view = after.as_ref().map(view_of);
        let mut resources = vec![(Binding::Rates, view.sri().as_entire_binding())];
        resources.push(match (&luma, plan.scene.colour) {
            (Some(luma), ColourForm::SqrtLuma) => (Binding::Colour, luma.as_entire_binding()),
            _ => (
                Binding::Colour,
                wgpu::BindingResource::TextureView(&history_view),
            ),
        });
        if let Some(view) = &after_view {
            resources.push((Binding::After, wgpu::BindingResource::TextureView(view)));
        }
        for (binding, view) in &views {
            resources.push((*binding, wgpu::BindingResource::TextureView(view)));
        }
        if let Some(view) = &depth_view {
            resources.push((
                Binding::PreviousDepth,
                wgpu::BindingResource::TextureView(view),
            ));
        }
        for (binding, buffer) in [
            (Binding::PreviousRates, &rates),
            (Binding::Reasons, &reasons),
        ] {
            if let Some(buffer) = buffer {
                resources.push((binding, buffer.as_entire_binding()));
            }
        }
        let analysis = kernels.analysis(&gpu.device, plan)?;
        let bound = analysis.bind(&gpu.device, &resources).map_err(own)?;
        Ok(Analysed {
            analysis,
            bound,
            history,
            after,
            depth,
            rates,
            reasons,
        })
    }

    /// Keeps the picture, depth and rates for the next frame.
    fn keep(&self, encoder: &mut wgpu::CommandEncoder, stage: &Stage, view: &View) {
        let mut copy = |from: &wgpu::Texture, to: &wgpu::Texture| {
            encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), to.size());
        };
        copy(stage.picture(), &self.history);
        if let Some(after) = &self.after {
            copy(stage.shown(), after);
        }
        if let (Some(from), Some(to)) = (stage.texture("depth"), &self.depth) {
            copy(from, to);
        }
        if let Some(rates) = &self.rates {
            encoder.copy_buffer_to_buffer(view.sri(), 0, rates, 0, rates.size());
        }
    }
}
