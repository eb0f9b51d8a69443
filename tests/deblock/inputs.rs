//! What is missing, too small or contradictory is refused.

use vrcs::{
    Rate,
    deblock::{Deblocker, Depth, DepthKind, Inputs, Options, Packing, Picture, PictureInput},
    sri::Sri,
};

use crate::{bench::Bench, case::Case};

#[test]
fn inputs_that_are_missing_or_small_are_refused() {
    let bench = Bench::new();
    let case = Case::new([20, 12], Sri::uniform(20, 12, Rate::R2X2), |_, _| [0.0; 4]);
    let picture = Picture::Buffer(Packing::Rgba8Unorm);
    let options = Options {
        surfaces: true,
        ..Options::new(picture)
    };
    let deblocker = Deblocker::new(&bench.gpu.device, None, options).unwrap();
    let buffer = bench
        .gpu
        .buffer("picture", &[0; 20 * 12 * 4], wgpu::BufferUsages::STORAGE);
    let rates = bench
        .gpu
        .buffer("rates", case.rates.bytes(), wgpu::BufferUsages::STORAGE);
    let inputs = Inputs {
        picture: PictureInput::Buffer(&buffer, 20),
        rates: &rates,
        depth: None,
        surfaces: None,
        luma: None,
    };
    let refused = deblocker.bind(&bench.gpu.device, &inputs).unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("surfaces was declared and is missing"),
        "{refused}"
    );
    let deblocker = Deblocker::new(&bench.gpu.device, None, Options::new(picture)).unwrap();
    let mut bound = deblocker.bind(&bench.gpu.device, &inputs).unwrap();
    for extent in [[21, 12], [20, 13]] {
        let refused = deblocker
            .set_frame(&bench.gpu.queue, &mut bound, extent, 0)
            .unwrap_err();
        assert!(refused.to_string().contains("20x12 given"), "{refused}");
    }
    assert!(
        deblocker
            .set_frame(&bench.gpu.queue, &mut bound, [20, 12], 0)
            .is_ok()
    );
    for depth in [
        Depth {
            kind: DepthKind::Linear,
            tolerance: 0,
        },
        Depth::new(DepthKind::Standard {
            near: 2.0,
            far: 1.0,
        }),
    ] {
        let options = Options {
            depth: Some(depth),
            ..Options::new(picture)
        };
        assert!(Deblocker::new(&bench.gpu.device, None, options).is_err());
    }
}
