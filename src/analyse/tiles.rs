//! The stage by tiles of 16×16 pixels, as NVIDIA ships it (GDC 2019, passes 1 and 2), on the CPU: the twin of `shaders/tile_data.wgsl`
//! and `shaders/tile_rates.wgsl`.
//!
//! Does: takes each tile's data of the previous picture, the mean of its quads' windows, which are the tile and a border of one pixel;
//! finds how a tile moved by the cameras at its furthest depth ("Find furthest point per tile from z-prepass. Use camera matrices to
//! reproject"); fetches the data there, between the middles of four tiles; and decides one rate for the tile, under the tolerance of the
//! shiniest of its surfaces ("max Smoothness & Rf0").
//! Needs: [`Fetch::Tile`](super::settings::Fetch), depth and both [`Cameras`](super::Cameras).
//! Guarantees: a tile of which a pixel was off the screen, or hidden by something nearer, or has a depth that is none, and data of a
//! pixel without luma, are at full rate. Means are rounded to fine.
//! Refuses: nothing here; [`Plan`](crate::plan::Plan) refuses effects that look at pixels one by one.
//!
//! It is the cheapest form, the more so without the depth test ([`Reprojection::tolerance`](super::settings::Reprojection)). All of a
//! tile is taken to move as what is furthest does: objects that move by themselves are not seen, which is what
//! [`Fetch::Pixel`](super::settings::Fetch) is for.

use super::{
    fixed,
    inputs::Inputs,
    motion,
    params::{self, Params},
    pipeline::{Logs, Numbers, Place, legal},
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

/// What a tile's window tells, or that a pixel has no luma.
pub(super) type Data<W> = Option<W>;

/// The data of the previous picture's tiles, row by row (pass 1).
pub(super) fn data<N: Numbers>(numbers: &N, inputs: &Inputs) -> Vec<Data<N::Window>> {
    let [width, height] = inputs.previous_size;
    let quads = [width.div_ceil(2), height.div_ceil(2)];
    let tiles = [width.div_ceil(SIDE), height.div_ceil(SIDE)];
    let of_tile = |tile: [u32; 2]| -> Data<N::Window> {
        let range = |axis: usize| tile[axis] * 8..(tile[axis] * 8 + 8).min(quads[axis]);
        let mut windows = Vec::new();
        for y in range(1) {
            for x in range(0) {
                let sources: [u32; 16] = std::array::from_fn(|i| {
                    let (i, side) = (i as i64, |v: u32| i64::from(v) - 1);
                    let px = (i64::from(x) * 2 - 1 + i % 4).clamp(0, side(width));
                    let py = (i64::from(y) * 2 - 1 + i / 4).clamp(0, side(height));
                    (py * i64::from(width) + px) as u32
                });
                if !sources.iter().all(|&at| numbers.is_valid(0, at as usize)) {
                    return None;
                }
                windows.push(numbers.window(0, &sources, [1, 1]));
            }
        }
        Some(numbers.mean(&windows))
    };
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
    Ok((
        place([0, 1].map(|axis: usize| (low[axis] + high[axis]) * 128)),
        moved,
    ))
}

/// The rate of a tile before larger rates have had to agree, its error on each axis, and the reason (pass 2). `logs` decides on a window.
pub(super) fn rate<N: Numbers>(
    numbers: &N,
    data: &[Data<N::Window>],
    inputs: &Inputs,
    settings: &Settings,
    params: &Params,
    tile: [u32; 2],
    logs: impl Fn(&N::Window, &Place) -> Logs,
) -> (Logs, [f64; 2], Reason) {
    let low = tile.map(|at| at * SIDE);
    let high = [0, 1].map(|axis: usize| (low[axis] + SIDE).min(inputs.size[axis]));
    let (position, moved) = match fetch(inputs, settings, params, low, high) {
        Ok(found) => found,
        Err(reason) => return ([0; 2], [0.0; 2], reason),
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
            Some(window) => four.push((window, weight)),
            None if weight == 0 => {}
            None => return ([0; 2], [0.0; 2], Reason::Invalid),
        }
    }
    let window = numbers.blend(&four);
    let surfaces = inputs.materials.unwrap_or_default();
    let shine = pixels(low, high).filter_map(|[x, y]| {
        let surface = surfaces.get((y * inputs.size[0] + x) as usize)?;
        Some(u32::from(surface[0]) * u32::from(surface[1]))
    });
    let shine = shine.max().unwrap_or_default();
    if settings.materials.is_some() && shine >= params.material_mirror {
        return ([0; 2], [0.0; 2], Reason::Material);
    }
    let place = Place {
        shine,
        speed: [0, 1].map(|axis: usize| motion::speed_index(moved[axis], params.speed_scale[axis])),
        quad: tile.map(|at| at * 8),
        ..Place::default()
    };
    let found = legal(logs(&window, &place));
    let error = [0, 1].map(|axis| numbers.error(&window, axis));
    (found, error, Reason::Content)
}
