//! The analysis of one view: plan, pipelines and bindings in one piece, for a renderer that has one of each.
//!
//! *Needs*: the view, whose [rates](View::sri) it writes, and the caller's pictures. *Refuses*: settings that call for what the
//! scene does not declare; pictures that are declared and not given, or cannot be read; frames of another size than the view, and views
//! that have made their buffers anew.

use std::sync::Arc;

use super::{
    gpu::{Analysis, BindError, BoundAnalysis, Resources},
    inputs::{Frame, FrameError},
    settings::Settings,
};
use crate::{
    home::Home,
    limits::LimitError,
    object::ObjectOptions,
    plan::{Binding, ColourForm, Plan, PlanError, Scene},
    scope,
    view::View,
};

/// The analysis of one view.
///
/// For several views of one plan (split screen, the two eyes of a headset), make the first and let it make
/// [another](Analyser::another) for each further view: then there is one set of pipelines.
#[derive(Debug)]
pub struct Analyser {
    device: wgpu::Device,
    home: Home,
    analysis: Arc<Analysis>,
    bound: BoundAnalysis,
    /// The rates that it writes: those of the view that it was bound to.
    rates: wgpu::Buffer,
}

/// Why there is no [`Analyser`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AnalyserError {
    /// The settings call for what the scene has not.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A picture is declared and not given, or cannot be bound.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// The device has too little for the kernels.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// A picture's format is none that a colour is read from.
    #[error(
        "{0:?} is no picture's colour here: rgba8unorm, bgra8unorm (with or without -srgb), rgba16float, rgba32float or rg11b10ufloat"
    )]
    Picture(wgpu::TextureFormat),
    /// A picture that is decoded when it is read, and does not allow a view that is not.
    #[error(
        "the picture is {picture:?}, whose codes can only be read through {twin:?}: make the texture with `view_formats: &[{twin:?}]`, or \
         give a view of it to `Analyser::of_view` as `ColourForm::Linear`, which reads what the driver decodes"
    )]
    Srgb {
        /// The picture's format.
        picture: wgpu::TextureFormat,
        /// The format without decoding.
        twin: wgpu::TextureFormat,
    },
    /// A picture of several layers, or none of two dimensions.
    #[error(
        "the picture has {layers} layers and dimension {dimension:?}: choose one layer by a two-dimensional view, and give that to \
         `Analyser::of_view`"
    )]
    Layers {
        /// Its layers.
        layers: u32,
        /// Its dimension.
        dimension: wgpu::TextureDimension,
    },
    /// A picture smaller than the view.
    #[error(
        "the picture is {picture:?} pixels, the view {view:?} at {origin:?} in it: a view is a part of the picture that it shades, or all of it"
    )]
    Size {
        /// The picture's size.
        picture: [u32; 2],
        /// The view's.
        view: [u32; 2],
        /// Where the view lies in the picture.
        origin: [u32; 2],
    },
}

impl Analyser {
    /// Plans the analysis, makes its pipelines and binds them: the rates to the view's, all else to `resources`, one for each
    /// [`Binding`] that the plan has.
    ///
    /// # Errors
    /// If the settings call for what the scene has not, a resource is missing or cannot be bound, or the device has too little.
    pub fn new(
        device: &wgpu::Device,
        view: &View,
        scene: &Scene,
        settings: &Settings,
        resources: Resources,
    ) -> Result<Analyser, AnalyserError> {
        let plan = Plan::new(scene, settings)?;
        Analyser::with(device, view, &plan, resources, &ObjectOptions::default())
    }

    /// The same of a plan, with a name for captures and the caller's cache of pipelines.
    ///
    /// # Errors
    /// As [`Analyser::new`].
    pub fn with(
        device: &wgpu::Device,
        view: &View,
        plan: &Plan,
        resources: Resources,
        objects: &ObjectOptions,
    ) -> Result<Analyser, AnalyserError> {
        let analysis = Analysis::with(device, plan, objects)?;
        Ok(Analyser::bound(
            device,
            Arc::new(analysis),
            view,
            resources,
        )?)
    }

    /// The analysis of what a picture looked like and nothing else, with the default settings: `picture` is what the previous frame
    /// left, and may be what this frame writes later in the same pass.
    ///
    /// The texture needs the usage `TEXTURE_BINDING`. One of 8-bit codes is taken as it is shown (sRGB), one of 16- or 32-bit floats as
    /// linear light. If the view has an [origin](View::origin), it is a part of the texture.
    ///
    /// # Errors
    /// If a shader cannot read the texture, or it has another format, more than one layer or sample, or fewer pixels than the view.
    pub fn of_colour(
        device: &wgpu::Device,
        view: &View,
        picture: &wgpu::Texture,
    ) -> Result<Analyser, AnalyserError> {
        use wgpu::TextureFormat as Format;
        let twin = picture.format().remove_srgb_suffix();
        let colour = match twin {
            Format::Rgba8Unorm | Format::Bgra8Unorm => ColourForm::Codes,
            Format::Rgba16Float | Format::Rgba32Float | Format::Rg11b10Ufloat => ColourForm::Linear,
            _ => return Err(AnalyserError::Picture(picture.format())),
        };
        let (layers, dimension) = (picture.depth_or_array_layers(), picture.dimension());
        if layers != 1 || dimension != wgpu::TextureDimension::D2 {
            return Err(AnalyserError::Layers { layers, dimension });
        }
        let made = scope::caught(device, || {
            picture.create_view(&wgpu::TextureViewDescriptor {
                label: Some("vrcs analyse"),
                format: Some(twin),
                mip_level_count: Some(1),
                ..Default::default()
            })
        });
        let made = made.map_err(|error| match twin == picture.format() {
            true => BindError::Refused(scope::in_words(&error)).into(),
            false => AnalyserError::Srgb {
                picture: picture.format(),
                twin,
            },
        })?;
        Analyser::of_view(device, view, &made, colour)
    }

    /// The same of a view of a texture: of one layer of an array, or in a format of the caller's choice. `form` says what its values are:
    /// [codes](ColourForm::Codes), read without decoding, or [linear light](ColourForm::Linear).
    ///
    /// # Errors
    /// As [`Analyser::of_colour`].
    pub fn of_view(
        device: &wgpu::Device,
        view: &View,
        picture: &wgpu::TextureView,
        form: ColourForm,
    ) -> Result<Analyser, AnalyserError> {
        let [width, height, _] = view.extent();
        let texture = picture.texture();
        let origin = view.origin();
        let needed = [width, height].map(u64::from);
        let needed = [0, 1].map(|axis| u64::from(origin[axis]) + needed[axis]);
        if u64::from(texture.width()) < needed[0] || u64::from(texture.height()) < needed[1] {
            return Err(AnalyserError::Size {
                picture: [texture.width(), texture.height()],
                view: [width, height],
                origin,
            });
        }
        let scene = Scene {
            colour: form,
            origin: origin != [0; 2],
            ..Scene::default()
        };
        let resources = [(Binding::Colour, wgpu::BindingResource::TextureView(picture))];
        Analyser::new(device, view, &scene, &Settings::default(), &resources)
    }

    /// Makes an analyser of another view by the same pipelines: of the other half of a split screen, of the other eye.
    ///
    /// # Errors
    /// If a resource is missing or cannot be bound.
    pub fn another(&self, view: &View, resources: Resources) -> Result<Analyser, BindError> {
        Analyser::bound(&self.device, Arc::clone(&self.analysis), view, resources)
    }

    fn bound(
        device: &wgpu::Device,
        analysis: Arc<Analysis>,
        view: &View,
        resources: Resources,
    ) -> Result<Analyser, BindError> {
        Ok(Analyser {
            home: Home::of(device),
            device: device.clone(),
            bound: bind(&analysis, device, view, resources)?,
            analysis,
            rates: view.sri().clone(),
        })
    }

    /// Binds anew: after the view's extent has changed, or a picture was made anew.
    ///
    /// # Errors
    /// If a resource is missing or cannot be bound; what was bound before then stays.
    pub fn bind(&mut self, view: &View, resources: Resources) -> Result<(), BindError> {
        self.bound = bind(&self.analysis, &self.device, view, resources)?;
        self.rates = view.sri().clone();
        Ok(())
    }

    /// The plan: passes, effects and bindings.
    pub fn plan(&self) -> &Plan {
        self.analysis.plan()
    }

    /// Sets a frame's parameters for what is submitted from now on, and records its analysis into the caller's compute pass. Sets
    /// pipelines and bind group 0.
    ///
    /// # Errors
    /// If the frame is not of the view's size, the analyser is [not bound](FrameError::Stale) to the view as it is now, or a picture or
    /// buffer is smaller than the frame; nothing is recorded then.
    pub fn record(
        &self,
        queue: &wgpu::Queue,
        pass: &mut wgpu::ComputePass,
        view: &View,
        frame: &Frame,
    ) -> Result<(), FrameError> {
        let _span = tracing::trace_span!("vrcs analyse").entered();
        if self.home != *view.home() || self.rates != *view.sri() {
            return Err(FrameError::Stale);
        }
        let [width, height, _] = view.extent();
        if frame.size != [width, height] {
            return Err(FrameError::View {
                frame: frame.size,
                view: [width, height],
            });
        }
        if frame.origin != view.origin() {
            return Err(FrameError::Origin {
                frame: frame.origin,
                view: view.origin(),
            });
        }
        self.analysis.set_frame(queue, &self.bound, frame)?;
        self.analysis.record(pass, &self.bound, frame);
        Ok(())
    }
}

fn bind(
    analysis: &Analysis,
    device: &wgpu::Device,
    view: &View,
    resources: Resources,
) -> Result<BoundAnalysis, BindError> {
    let rates = (Binding::Rates, view.sri().as_entire_binding());
    let all: Vec<_> = std::iter::once(rates)
        .chain(resources.iter().cloned())
        .collect();
    analysis.bind(device, &all)
}
