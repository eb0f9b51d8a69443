//! The stage by tiles of 16×16 pixels, as NVIDIA ships it (GDC 2019, passes 1 and 2), on the CPU: the twin of `shaders/tile_data.wgsl`
//! and `shaders/tile_rates.wgsl`.
//!
//! Does: takes each tile's data of the previous picture, the error and luma of its own pixels and the shiniest of its surfaces ("max
//! smoothness and specular reflectance (Rf0) per tile"); finds how a tile moved by the cameras at its furthest depth ("Find furthest point
//! per tile from z-prepass. Use camera matrices to reproject"); fetches the data there, between the middles of four tiles ("with linear
//! interpolation"); and decides one rate for the tile, under the tolerance of its surfaces, of this frame or of the one before.
//! Needs: [`Fetch::Tile`](super::settings::Fetch), depth and both [`Cameras`](super::Cameras).
//! Guarantees: a tile of which a pixel was off the screen, or hidden by something nearer, or has a depth that is none, and data of a
//! pixel without luma or of an axis without a pair, are at full rate. Means are rounded to fine.
//! Refuses: nothing here; [`Plan`](crate::plan::Plan) refuses effects that look at pixels one by one.
//!
//! It is the cheapest form, the more so without the depth test ([`Reprojection::tolerance`](super::settings::Reprojection)). All of a
//! tile is taken to move as what is furthest does: objects that move by themselves are not seen, which is what
//! [`Fetch::Pixel`](super::settings::Fetch) is for.

use super::{
    decide::{Place, Quad, Stage, legal, logs_cap},
    fixed,
    inputs::Inputs,
    integer::{Window, share_above},
    motion,
    params::{self, Params},
    reasons::Reason,
    reproject::motion_of,
    settings::Settings,
};

/// The side of a tile in pixels.
pub const SIDE: u32 = 16;

/// Bytes of the buffer that holds a previous picture's tiles: [`Binding::TileData`](crate::plan::Binding::TileData).
pub fn data_bytes(previous_size: [u32; 2]) -> u64 {
    let [across, down] = previous_size.map(|side| u64::from(side.div_ceil(SIDE)));
    across * down * 16
}

/// What a tile tells: its errors and luma, and the most smoothness · Rf0; or that a pixel has no luma, or an axis no pair.
pub(super) type Data = Option<(Window, u32)>;

/// The data of the previous picture's tiles, row by row (pass 1).
pub(super) fn data(stage: &Stage) -> Vec<Data> {
    let [width, height] = stage.inputs.previous_size;
    let surfaces = stage
        .inputs
        .materials
        .filter(|_| stage.settings.has_materials_before());
    let of_tile = |[x, y]: [u32; 2]| -> Data {
        let low = [x * SIDE, y * SIDE];
        let high = [(low[0] + SIDE).min(width), (low[1] + SIDE).min(height)];
        let all: Vec<u32> = pixels(low, high).map(|[x, y]| y * width + x).collect();
        let is_valid = |&at: &u32| stage.numbers.is_valid(0, at as usize);
        if !all.iter().all(is_valid) {
            return None;
        }
        let extent = [high[0] - low[0], high[1] - low[1]];
        let window = stage.numbers.tile(0, &all, extent);
        // a picture one pixel wide has no pair, and nothing to tell of
        let is_unseen = [width, height]
            .iter()
            .zip(window.pairs)
            .any(|(&side, pairs)| side > 1 && pairs == 0);
        let shine = surfaces.map_or(0, |surfaces| {
            let of = |&at: &u32| surfaces[at as usize].map(u32::from);
            let each = all.iter().map(of).map(|[smooth, rf0]| smooth * rf0);
            each.max().unwrap_or_default()
        });
        (!is_unseen).then_some((window, shine))
    };
    let tiles = [width.div_ceil(SIDE), height.div_ceil(SIDE)];
    (0..tiles[1])
        .flat_map(|y| (0..tiles[0]).map(move |x| [x, y]))
        .map(of_tile)
        .collect()
}

/// The pixels of a tile, of which the first and the one beyond the last are given.
fn pixels(low: [u32; 2], high: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    (low[1]..high[1]).flat_map(move |y| (low[0]..high[0]).map(move |x| [x, y]))
}

/// Where a tile was, and how fast it moves, by the cameras at its furthest depth; positions in 1/256 pixel.
fn fetch(
    inputs: &Inputs,
    settings: &Settings,
    params: &Params,
    low: [u32; 2],
    high: [u32; 2],
) -> Result<([i32; 2], [f32; 2]), Reason> {
    let (Some(depth), Some(cameras)) = (inputs.depth, inputs.cameras) else {
        return Err(Reason::NoMotion);
    };
    let at = |[x, y]: [u32; 2]| (y * inputs.size[0] + x) as usize;
    let mut far: Option<f32> = None;
    for pixel in pixels(low, high) {
        let value = depth[at(pixel)];
        if !(0.0..=1.0).contains(&value) {
            return Err(Reason::NoMotion);
        }
        far = Some(far.map_or(value, |far| match params.reversed_z != 0 {
            true => far.min(value),
            false => far.max(value),
        }));
    }
    let centre = [0, 1].map(|axis: usize| f64::from(low[axis] + high[axis]) / 2.0);
    let to_world = cameras.now.inverse();
    let far = far.unwrap_or_default();
    let moved = motion_of(centre, inputs.size, far, &to_world, &cameras.before);
    if moved.iter().any(|component| component.is_nan()) {
        return Err(Reason::NoMotion);
    }
    let mut shift = [0; 2];
    for axis in 0..2 {
        let offset = moved[axis] * params.offset_scale[axis];
        if offset.to_bits() & 0x7fff_ffff >= 0x4b00_0000 {
            return Err(Reason::OffScreen);
        }
        shift[axis] = (offset.floor() as i32 + 1) >> 1;
    }
    let place = |[x, y]: [u32; 2]| {
        [0, 1].map(|axis: usize| {
            fixed::mul_high([x, y][axis] << 8, params.ratio[axis]) as i32 + shift[axis]
        })
    };
    let sources = || {
        pixels(low, high).map(|pixel| {
            let [x, y] = place(pixel.map(|side| side * 256 + 128)).map(|at| at >> 8);
            (pixel, [x, y])
        })
    };
    let is_outside = |[x, y]: [i32; 2]| {
        let [width, height] = params.previous.map(|side| side as i32);
        !(0..width).contains(&x) || !(0..height).contains(&y)
    };
    if sources().any(|(_, source)| is_outside(source)) {
        return Err(Reason::OffScreen);
    }
    let before = inputs.previous_depth.filter(|_| settings.tests_depth());
    let was_covered = |(pixel, [x, y]): ([u32; 2], [i32; 2])| {
        let Some(before) = before else { return false };
        let from = (y as u32 * params.previous[0] + x as u32) as usize;
        let now = params::inverse_depth(depth[at(pixel)], params);
        let then = params::inverse_depth(before[from], params);
        match (now, then) {
            (Some(now), Some(then)) => params::was_covered(now, then, params),
            _ => true,
        }
    };
    if sources().any(was_covered) {
        return Err(Reason::Disoccluded);
    }
    // of the whole tile, also where the picture ends before: at rest a tile has its own data alone
    Ok((place(low.map(|low| low * 256 + 2048)), moved))
}

/// What a tile gets, before larger rates have had to agree (pass 2).
pub(super) fn rate(stage: &Stage, data: &[Data], tile: [u32; 2]) -> Quad {
    let (inputs, settings, params) = (stage.inputs, stage.settings, stage.params);
    let low = tile.map(|at| at * SIDE);
    let high = [0, 1].map(|axis: usize| (low[axis] + SIDE).min(inputs.size[axis]));
    let (position, moved) = match fetch(inputs, settings, params, low, high) {
        Ok(found) => found,
        Err(reason) => return Quad::full(reason),
    };
    let tiles = params.previous.map(|side| side.div_ceil(SIDE) as i32);
    let at = position.map(|position| position - 2048);
    let (first, part) = (
        at.map(|at| at >> 12),
        at.map(|at| ((at & 4095) >> 4) as u32),
    );
    let mut four = Vec::new();
    for i in 0..4usize {
        let step = [i & 1, i >> 1];
        let sides = [0, 1].map(|axis: usize| match step[axis] {
            0 => 256 - part[axis],
            _ => part[axis],
        });
        let place =
            [0, 1].map(|axis: usize| (first[axis] + step[axis] as i32).clamp(0, tiles[axis] - 1));
        let weight = sides[0] * sides[1];
        match &data[(place[1] * tiles[0] + place[0]) as usize] {
            Some(data) => four.push((data, weight)),
            None if weight == 0 => {}
            None => return Quad::full(Reason::Invalid),
        }
    }
    let windows: Vec<(&Window, u32)> = four
        .iter()
        .map(|&((window, _), weight)| (window, weight))
        .collect();
    let window = stage.numbers.blend(&windows);
    let shine = match settings.has_materials_before() {
        // with the rest of the data, rounded up
        true => four
            .iter()
            .map(|&((_, shine), weight)| share_above(*shine, weight))
            .sum(),
        false => {
            let surfaces = inputs.materials.unwrap_or_default();
            let shine = pixels(low, high).filter_map(|[x, y]| {
                let surface = surfaces.get((y * inputs.size[0] + x) as usize)?;
                Some(u32::from(surface[0]) * u32::from(surface[1]))
            });
            shine.max().unwrap_or_default()
        }
    };
    if settings.materials.is_some() && shine >= params.material_mirror {
        return Quad::full(Reason::Material);
    }
    let place = Place {
        shine,
        speed: [0, 1].map(|axis: usize| motion::speed_index(moved[axis], params.speed_scale[axis])),
        ..Place::default()
    };
    let rate = legal(match stage.motion_only(&place) {
        Some(logs) => logs,
        None => stage.logs(&window, &place, false),
    });
    let error = [0, 1].map(|axis| stage.numbers.error(&window, axis));
    Quad {
        rate,
        attachment: rate,
        plain: rate,
        reason: match (rate == logs_cap(params), settings.is_by_motion_alone()) {
            (true, _) => Reason::None,
            (false, true) => Reason::Motion,
            (false, false) => Reason::Content,
        },
        error,
        attachment_error: error,
    }
}
