//! The analysis of one view: plan, pipelines and bindings in one piece, for a renderer that has one of each.
//!
//! *Needs*: the view, whose [rates](View::sri) it writes, and the caller's pictures. *Refuses*: settings that call for what the
//! scene does not declare, and pictures that are declared and not given.

use super::{
    gpu::{Analysis, BoundAnalysis, MissingResource, Resources},
    inputs::Frame,
    settings::Settings,
};
use crate::{
    plan::{Binding, ColourForm, Plan, PlanError, Scene},
    view::View,
};

/// The analysis of one view.
///
/// For several views of one plan (split screen, the two eyes of a headset), share an [`Analysis`] and [bind](Analysis::bind) it to each
/// view: then there is one set of pipelines.
#[derive(Debug)]
pub struct Analyser {
    analysis: Analysis,
    bound: BoundAnalysis,
}

/// Why there is no [`Analyser`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AnalyserError {
    /// The settings call for what the scene has not.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A picture is declared and not given.
    #[error(transparent)]
    Missing(#[from] MissingResource),
    /// A picture's format is none that a colour is read from.
    #[error(
        "{0:?} is no picture's colour here: rgba8unorm, bgra8unorm (with or without -srgb), rgba16float, rgba32float or rg11b10ufloat"
    )]
    Picture(wgpu::TextureFormat),
    /// A shader cannot read the picture.
    #[error("the picture needs the usage `TEXTURE_BINDING`")]
    Usage,
}

impl Analyser {
    /// Plans the analysis, makes its pipelines and binds them: the rates to the view's, all else to `resources`, one for each
    /// [`Binding`] that the plan has.
    ///
    /// # Errors
    /// If the settings call for what the scene has not, or a resource is missing.
    pub fn new(
        device: &wgpu::Device,
        view: &View,
        scene: &Scene,
        settings: &Settings,
        resources: Resources,
    ) -> Result<Analyser, AnalyserError> {
        let analysis = Analysis::new(device, &Plan::new(scene, settings)?);
        let bound = bind(&analysis, device, view, resources)?;
        Ok(Analyser { analysis, bound })
    }

    /// The analysis of what a picture looked like and nothing else, with the default settings: `picture` is what the previous frame
    /// left, and may be what this frame writes later in the same pass.
    ///
    /// A texture of 8-bit codes is taken as it is shown (sRGB), one of 16- or 32-bit floats as linear light.
    ///
    /// # Errors
    /// If the texture cannot be read by a shader, or has another format.
    pub fn of_colour(
        device: &wgpu::Device,
        view: &View,
        picture: &wgpu::Texture,
    ) -> Result<Analyser, AnalyserError> {
        use wgpu::TextureFormat as Format;
        let format = picture.format().remove_srgb_suffix();
        let colour = match format {
            Format::Rgba8Unorm | Format::Bgra8Unorm => ColourForm::Codes,
            Format::Rgba16Float | Format::Rgba32Float | Format::Rg11b10Ufloat => ColourForm::Linear,
            _ => return Err(AnalyserError::Picture(picture.format())),
        };
        if !picture
            .usage()
            .contains(wgpu::TextureUsages::TEXTURE_BINDING)
        {
            return Err(AnalyserError::Usage);
        }
        let picture = picture.create_view(&wgpu::TextureViewDescriptor {
            label: Some("vrcs analyse"),
            format: Some(format),
            ..Default::default()
        });
        let scene = Scene {
            colour,
            ..Scene::default()
        };
        let resources = [(
            Binding::Colour,
            wgpu::BindingResource::TextureView(&picture),
        )];
        Analyser::new(device, view, &scene, &Settings::default(), &resources)
    }

    /// Binds anew: after the view's extent has outgrown its buffers, or a picture was made anew.
    ///
    /// # Errors
    /// If a resource is missing; what was bound before then stays.
    pub fn bind(
        &mut self,
        device: &wgpu::Device,
        view: &View,
        resources: Resources,
    ) -> Result<(), MissingResource> {
        self.bound = bind(&self.analysis, device, view, resources)?;
        Ok(())
    }

    /// The plan: passes, effects and bindings.
    pub fn plan(&self) -> &Plan {
        self.analysis.plan()
    }

    /// Sets a frame's parameters for what is submitted from now on, and records its analysis into the caller's compute pass. Sets
    /// pipelines and bind group 0.
    pub fn record(&self, queue: &wgpu::Queue, pass: &mut wgpu::ComputePass, frame: &Frame) {
        let _span = tracing::trace_span!("vrcs analyse").entered();
        self.analysis.set_frame(queue, &self.bound, frame);
        self.analysis.record(pass, &self.bound, frame);
    }
}

fn bind(
    analysis: &Analysis,
    device: &wgpu::Device,
    view: &View,
    resources: Resources,
) -> Result<BoundAnalysis, MissingResource> {
    let rates = (Binding::Rates, view.sri().as_entire_binding());
    let all: Vec<_> = std::iter::once(rates)
        .chain(resources.iter().cloned())
        .collect();
    analysis.bind(device, &all)
}
