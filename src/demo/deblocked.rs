//! The demo's deblocking: the picture of the scene, filtered in place by the rates that it was shaded at.

use super::{DemoError, Stage, own};
use crate::{
    Rate,
    build::cpu::Coordinates,
    check::gpu::{adapters, by_construction},
    deblock::{Bound, Deblocker, Inputs, Options, Picture, PictureInput},
    sri::Sri,
};

/// A deblocker that is bound to the scene's picture.
pub(super) struct Deblock {
    deblocker: Deblocker,
    bound: Bound,
}

/// The rates in which quads really shared: in a tile with too many primaries, none did.
fn effective(sri: &Sri, coordinates: &Coordinates) -> Sri {
    let [width, height] = coordinates.extent;
    let tile = coordinates.options.tile;
    Sri::from_fn(width, height, |x, y| {
        let slot = y * 2 / tile[1] * coordinates.layout.tiles[0] + x * 2 / tile[0];
        match coordinates.header(slot).is_identity() {
            true => Rate::R1X1.code(),
            false => sri.rate(x, y, coordinates.options.largest).code(),
        }
    })
}

impl Deblock {
    pub(super) fn new(
        stage: &Stage,
        sri: &Sri,
        coordinates: &Coordinates,
    ) -> Result<Deblock, DemoError> {
        let gpu = stage.gpu;
        let adapter = adapters()
            .into_iter()
            .find(|adapter| adapter.get_info().name == gpu.info.name);
        let options = Options::new(Picture::Texture(stage.picture.format()));
        let deblocker = Deblocker::new(&gpu.device, adapter.as_ref(), options).map_err(own)?;
        let rates = gpu.buffer(
            "effective rates",
            effective(sri, coordinates).bytes(),
            wgpu::BufferUsages::STORAGE,
        );
        let view = stage
            .picture
            .create_view(&wgpu::TextureViewDescriptor::default());
        let inputs = Inputs {
            picture: PictureInput::Texture(&view),
            rates: &rates,
            depth: None,
            surfaces: None,
            luma: None,
        };
        let mut bound = deblocker.bind(&gpu.device, &inputs).map_err(own)?;
        deblocker
            .set_frame(&gpu.queue, &mut bound, stage.size, 0)
            .map_err(own)?;
        Ok(Deblock { deblocker, bound })
    }

    pub(super) fn record(&self, pass: &mut wgpu::ComputePass) {
        by_construction(self.deblocker.record_in(pass, &self.bound));
    }
}
