//! What is analysed: pictures and resources that cannot be are refused, with what to do.

use vrcs::{
    Analyser, AnalyserError, Scene, View,
    analyse::{BindError, Settings},
    plan::{Binding, ColourForm},
};

use crate::{
    common,
    renderer::{SIZE, picture, texture_of},
};

#[test]
fn a_picture_that_cannot_be_analysed_is_told_why_and_what_to_do() {
    let gpu = common::gpu();
    let view = View::of_size(&gpu.device, &gpu.queue, SIZE).expect("a view");
    let of = |descriptor: &wgpu::TextureDescriptor| {
        let (texture, _) = texture_of(&gpu.device, descriptor);
        Analyser::of_colour(&gpu.device, &view, &texture)
    };
    let sampled = wgpu::TextureUsages::TEXTURE_BINDING;
    let plain = wgpu::TextureDescriptor {
        usage: sampled,
        ..picture(SIZE)
    };
    of(&plain).expect("a picture as it should be");

    let srgb = wgpu::TextureDescriptor {
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        ..plain.clone()
    };
    let error = of(&srgb).expect_err("its codes cannot be read");
    assert!(matches!(error, AnalyserError::Srgb { .. }), "{error:?}");
    let words = error.to_string();
    assert!(words.contains("view_formats: &[Rgba8Unorm]"), "{words}");
    let twin = wgpu::TextureDescriptor {
        view_formats: &[wgpu::TextureFormat::Rgba8Unorm],
        ..srgb.clone()
    };
    of(&twin).expect("its codes can be read");
    let (_, decoded) = texture_of(&gpu.device, &srgb);
    Analyser::of_view(&gpu.device, &view, &decoded, ColourForm::Linear).expect("what is decoded");

    let array = wgpu::TextureDescriptor {
        size: wgpu::Extent3d {
            depth_or_array_layers: 2,
            ..plain.size
        },
        ..plain.clone()
    };
    let error = of(&array).expect_err("which layer?");
    assert!(
        matches!(error, AnalyserError::Layers { layers: 2, .. }),
        "{error:?}"
    );
    let (_, layer) = texture_of(&gpu.device, &array);
    Analyser::of_view(&gpu.device, &view, &layer, ColourForm::Codes).expect("one layer");

    let samples = wgpu::TextureDescriptor {
        sample_count: 4,
        usage: sampled | wgpu::TextureUsages::RENDER_ATTACHMENT,
        ..plain.clone()
    };
    let error = of(&samples).expect_err("four samples");
    assert!(
        matches!(
            error,
            AnalyserError::Bind(BindError::Samples { samples: 4, .. })
        ),
        "{error:?}"
    );
    let hidden = wgpu::TextureDescriptor {
        usage: wgpu::TextureUsages::COPY_SRC,
        ..plain.clone()
    };
    let error = of(&hidden).expect_err("no shader may read it");
    assert!(
        matches!(&error, AnalyserError::Bind(BindError::Usage { usage, .. }) if *usage == "TEXTURE_BINDING")
            || matches!(&error, AnalyserError::Bind(BindError::Refused(_))),
        "{error:?}"
    );
    let small = wgpu::TextureDescriptor {
        usage: sampled,
        ..picture([63, 48])
    };
    let error = of(&small).expect_err("smaller than the view");
    assert!(matches!(error, AnalyserError::Size { .. }), "{error:?}");
    let depth = wgpu::TextureDescriptor {
        format: wgpu::TextureFormat::R32Float,
        ..plain.clone()
    };
    let error = of(&depth).expect_err("no colour");
    assert!(matches!(error, AnalyserError::Picture(_)), "{error:?}");
    gpu.check().expect("nothing of it came to wgpu");
}

#[test]
fn resources_of_another_kind_are_refused_when_they_are_bound() {
    let gpu = common::gpu();
    let view = View::of_size(&gpu.device, &gpu.queue, SIZE).expect("a view");
    let scene = Scene::default();
    let settings = Settings::default();
    let of = |resource| {
        let resources = [(Binding::Colour, resource)];
        Analyser::new(&gpu.device, &view, &scene, &settings, &resources).expect_err("no colour")
    };
    let error = of(view.sri().as_entire_binding());
    assert!(
        matches!(
            error,
            AnalyserError::Bind(BindError::Kind {
                wanted: "texture",
                ..
            })
        ),
        "{error:?}"
    );
    let integers = wgpu::TextureDescriptor {
        format: wgpu::TextureFormat::R32Uint,
        ..picture(SIZE)
    };
    let (_, integers) = texture_of(&gpu.device, &integers);
    let error = of(wgpu::BindingResource::TextureView(&integers));
    assert!(
        matches!(error, AnalyserError::Bind(BindError::Refused(_))),
        "{error:?}"
    );
    gpu.check().expect("nothing of it came to the device");
}
