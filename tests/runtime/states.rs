//! States: what was not given, not bound again, or made for something else.

use vrcs::{
    Mismatch, Pass, PassError, View, ViewError,
    analyse::{Frame, FrameError},
    build::BuildOptions,
    coverage::{Coverage, Textures},
};
use vrcs_passes::options::Mode;

use crate::{
    common,
    renderer::{Drawn, SIZE, options, picture, shader, texture_of},
};

#[test]
fn a_view_is_not_built_until_its_coverage_is_known_for_its_extent() {
    let gpu = common::gpu();
    let declared = BuildOptions {
        coverage: Coverage {
            surfaces: true,
            ..Coverage::default()
        },
        ..BuildOptions::default()
    };
    let mut view = View::new(&gpu.device, &gpu.queue, [64, 48, 1], declared).expect("a view");
    let build = |view: &View| view.build(&mut gpu.encoder());
    assert_eq!(build(&view), Err(ViewError::Uncovered));

    let numbers = wgpu::TextureDescriptor {
        format: wgpu::TextureFormat::R32Uint,
        ..picture(SIZE)
    };
    let (_, surfaces) = texture_of(&gpu.device, &numbers);
    let given = Textures {
        surfaces: Some(&surfaces),
        ..Textures::default()
    };
    view.cover(&gpu.queue, &given).expect("its size");
    assert_eq!(build(&view), Ok(()));
    view.set_extent(&gpu.queue, [64, 48, 1]).expect("as it was");
    assert_eq!(build(&view), Ok(()), "nothing changed");
    view.set_extent(&gpu.queue, [60, 40, 1]).expect("smaller");
    assert_eq!(build(&view), Err(ViewError::Uncovered), "another extent");
    view.cover(&gpu.queue, &given).expect("a corner of it");
    assert_eq!(build(&view), Ok(()));

    view.set_extent(&gpu.queue, [65, 48, 1]).expect("larger");
    let error = view.cover(&gpu.queue, &given).expect_err("too small");
    assert!(
        matches!(
            error,
            ViewError::SmallTexture {
                name: "surfaces",
                ..
            }
        ),
        "{error:?}"
    );
    let (_, colours) = texture_of(&gpu.device, &picture([65, 48]));
    let wrong = Textures {
        surfaces: Some(&colours),
        ..Textures::default()
    };
    let error = view.cover(&gpu.queue, &wrong).expect_err("no numbers");
    assert!(matches!(error, ViewError::Refused(_)), "{error:?}");
    gpu.check().expect("nothing of it came to the device");
}

#[test]
fn a_pass_is_not_dispatched_over_a_view_that_was_made_for_something_else() {
    let gpu = common::gpu();
    let pass = Pass::new(&gpu.device, &shader(), &options(Mode::Graded));
    let error = pass.expect_err("the shader grades nothing");
    assert!(matches!(error, PassError::Refused { .. }), "{error:?}");
    let pass = Pass::new(&gpu.device, &shader(), &options(Mode::Classified)).expect("a pass");
    let view = View::of_size(&gpu.device, &gpu.queue, SIZE).expect("a view");
    let mut encoder = gpu.encoder();
    let mut compute = encoder.begin_compute_pass(&Default::default());
    let mismatch = Mismatch::Mode {
        pass: Mode::Classified,
    };
    assert_eq!(pass.dispatch(&mut compute, &view), Err(mismatch.clone()));
    assert_eq!(pass.bindings(&view).err(), Some(mismatch));

    drop(compute);
    gpu.queue.submit([encoder.finish()]);
    gpu.check().expect("nothing was recorded");
}

#[test]
fn an_analyser_that_was_not_bound_again_refuses_to_write_the_old_buffers() {
    let gpu = common::gpu();
    let mut drawn = Drawn::new(&gpu.device, &gpu.queue, SIZE);
    let mut encoder = gpu.encoder();
    let mut compute = encoder.begin_compute_pass(&Default::default());
    let mut record = |drawn: &Drawn, frame: &Frame| {
        drawn
            .analyser
            .record(&gpu.queue, &mut compute, &drawn.view, frame)
    };
    assert_eq!(record(&drawn, &Frame::of_size(SIZE)), Ok(()));
    let error = record(&drawn, &Frame::of_size([64, 47])).expect_err("another size");
    assert!(matches!(error, FrameError::View { .. }), "{error:?}");
    let scaled = Frame {
        resolution_scale: 0.0,
        ..Frame::of_size(SIZE)
    };
    assert_eq!(record(&drawn, &scaled), Err(FrameError::Scale(0.0)));
    let larger = Frame {
        previous_size: [65, 48],
        ..Frame::of_size(SIZE)
    };
    let error = record(&drawn, &larger).expect_err("the picture is smaller");
    assert!(
        matches!(error, FrameError::Texture { what: "colour", .. }),
        "{error:?}"
    );

    let before = drawn.view.generation();
    drawn
        .view
        .set_extent(&gpu.queue, [200, 200, 1])
        .expect("larger");
    assert_ne!(drawn.view.generation(), before);
    assert_eq!(
        record(&drawn, &Frame::of_size([200, 200])),
        Err(FrameError::Stale)
    );
    drawn.resize(&gpu.device, &gpu.queue, [200, 200]);
    assert_eq!(record(&drawn, &Frame::of_size([200, 200])), Ok(()));
}
