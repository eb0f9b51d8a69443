//! The scenes: each makes a picture, the same for the same frame and seed; its passes are rewritten by this project's
//! own rewriter; at full rate they give the picture that the author's shaders give, bit for bit.

mod common;

use vrcs::{
    Rate, View,
    build::BuildOptions,
    check::gpu::Gpu,
    scenes::{PassName, SceneName, frame::Frame, stage::Stage},
    sri::Sri,
};

const SIZE: [u32; 2] = [122, 75];

/// A frame, at full rate or at a view's rates.
fn render(gpu: &Gpu, stage: &Stage, number: u32, seed: u32, view: Option<&View>) -> Vec<u8> {
    stage.set_frame(
        &gpu.queue,
        &Frame::new(stage.scene(), number, stage.size(), seed),
    );
    let mut encoder = gpu.encoder();
    if let Some(view) = view {
        view.build(&mut encoder).expect("covered");
    }
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        stage.record_geometry(&mut pass);
        for &name in stage.scene().passes() {
            match view {
                Some(view) => stage.record_variable(&mut pass, name, view),
                None => stage.record_full_rate(&mut pass, name),
            }
        }
    }
    gpu.read_rgba8(encoder, stage.picture()).expect("a picture")
}

fn hold(scene: SceneName) {
    let gpu = common::gpu();
    let seed = common::seed() as u32;
    let stage = Stage::new(&gpu, scene, SIZE, &vrcs_passes::Options::default()).expect("a stage");
    let full = render(&gpu, &stage, 7, seed, None);
    if let Some(folder) = std::env::var_os("VRCS_PICTURES") {
        let path = std::path::Path::new(&folder).join(format!("{scene}.png"));
        image::save_buffer(path, &full, SIZE[0], SIZE[1], image::ColorType::Rgba8).expect("a file");
    }
    assert_eq!(
        full,
        render(&gpu, &stage, 7, seed, None),
        "the same frame twice"
    );
    let later = render(&gpu, &stage, 19, seed, None);
    assert_ne!(full, later, "it moves");
    let mut values: Vec<&[u8]> = full.chunks_exact(4).collect();
    values.sort_unstable();
    values.dedup();
    assert!(values.len() > 100, "{} colours", values.len());

    let view = View::new(
        &gpu.device,
        &gpu.queue,
        [SIZE[0], SIZE[1], 1],
        BuildOptions::default(),
    )
    .expect("a view");
    view.write_sri(&gpu.queue, &Sri::uniform(SIZE[0], SIZE[1], Rate::R1X1))
        .expect("rates");
    let identity = render(&gpu, &stage, 7, seed, Some(&view));
    assert_eq!(full, identity, "all rates 1x1");
    view.write_sri(&gpu.queue, &Sri::uniform(SIZE[0], SIZE[1], Rate::R2X2))
        .expect("rates");
    let coarse = render(&gpu, &stage, 7, seed, Some(&view));
    assert_ne!(full, coarse, "rates 2x2");
    assert_eq!(coarse[..4], full[..4], "the first primary");
    assert_eq!(coarse[4..8], coarse[..4], "its duplicate");
}

#[test]
fn interior() {
    hold(SceneName::Interior);
}

#[test]
fn foliage() {
    hold(SceneName::Foliage);
}

#[test]
fn landscape() {
    hold(SceneName::Landscape);
}

#[test]
fn text() {
    hold(SceneName::Text);
}

#[test]
fn ramps() {
    hold(SceneName::Ramps);
}

#[test]
fn disocclusion() {
    hold(SceneName::Disocclusion);
}

#[test]
fn what_a_scene_does_not_declare_has_no_texture() {
    let gpu = common::gpu();
    let always = [
        "albedo", "depth", "ids", "light", "normals", "picture", "surface",
    ];
    for scene in SceneName::ALL {
        let stage = Stage::new(&gpu, scene, [16, 8], &vrcs_passes::Options::default());
        let declared = scene.declared();
        let own = [
            ("materials", declared.materials),
            ("motion", declared.motion_vectors || declared.camera_motion),
            ("noise", declared.grain),
            ("shown", declared.transparents),
            ("surfaces", declared.surface_ids),
            (
                "traced",
                [PassName::Rays, PassName::Atmosphere]
                    .iter()
                    .any(|pass| scene.passes().contains(pass)),
            ),
        ];
        let own = own.iter().filter(|(_, is_there)| *is_there);
        let mut wanted: Vec<&str> = always
            .into_iter()
            .chain(own.map(|(name, _)| *name))
            .collect();
        wanted.sort_unstable();
        let mut found: Vec<&str> = stage.as_ref().expect("a stage").textures().collect();
        found.sort_unstable();
        assert_eq!(found, wanted, "{scene}");
    }
}

#[test]
fn a_scene_without_short_rays_has_no_pass_for_them() {
    assert!(!SceneName::Landscape.passes().contains(&PassName::Rays));
    assert!(!SceneName::Landscape.source().text().contains("fn rays("));
}

#[test]
fn an_unknown_scene_is_refused_with_the_names_that_there_are() {
    let error = "interiour".parse::<SceneName>().expect_err("no such scene");
    assert!(error.to_string().contains("interior, foliage"), "{error}");
}
