//! The stage by tiles of 16×16 pixels, as NVIDIA ships it (GDC 2019, passes 1 and 2), on the CPU: the twin of `shaders/tile_data.wgsl`
//! and `shaders/tile_rates.wgsl`.
//!
//! Does: takes each tile's data of the previous picture, the mean of its quads' windows; finds how a tile moved by the cameras at its
//! furthest depth ("Find furthest point per tile from z-prepass. Use camera matrices to reproject"); fetches the data there, between the
//! middles of four tiles; and decides one rate for the tile.
//! Needs: [`Fetch::Tile`](super::settings::Fetch), depth and both [`Cameras`](super::Cameras).
//! Guarantees: what was off the screen, a tile with a depth that is none, and data of a pixel without luma is at full rate. Means are
//! rounded to fine.
//! Refuses: nothing here; [`Plan`](crate::plan::Plan) refuses effects that look at pixels one by one.
//!
//! It is the cheapest form, 11 to 33 bytes a pixel less than one fetch for each; objects that move by themselves are not seen, and a
//! surface that was hidden is not told apart: that is what [`Fetch::Pixel`](super::settings::Fetch) is for.

use super::{
    fixed,
    inputs::Inputs,
    motion,
    params::Params,
    pipeline::{Logs, Numbers, Place, legal},
    reasons::Reason,
    reproject::motion_of,
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

/// Where a tile was, and how fast it moves, by the cameras at its furthest depth; positions in 1/256 pixel.
fn fetch(
    inputs: &Inputs,
    params: &Params,
    low: [u32; 2],
    high: [u32; 2],
) -> Result<([i32; 2], [f32; 2]), Reason> {
    let (Some(depth), Some(cameras)) = (inputs.depth, inputs.cameras) else {
        return Err(Reason::NoMotion);
    };
    let mut far: Option<f32> = None;
    for y in low[1]..high[1] {
        for x in low[0]..high[0] {
            let value = depth[(y * inputs.size[0] + x) as usize];
            if !(0.0..=1.0).contains(&value) {
                return Err(Reason::NoMotion);
            }
            far = Some(far.map_or(value, |far| match params.reversed_z != 0 {
                true => far.min(value),
                false => far.max(value),
            }));
        }
    }
    let centre = [0, 1].map(|axis: usize| f64::from(low[axis] + high[axis]) / 2.0);
    let to_world = cameras.now.inverse();
    let depth = far.unwrap_or_default();
    let moved = motion_of(centre, inputs.size, depth, &to_world, &cameras.before);
    if moved.iter().any(|component| component.is_nan()) {
        return Err(Reason::NoMotion);
    }
    let mut position = [0; 2];
    for axis in 0..2 {
        let offset = moved[axis] * params.offset_scale[axis];
        if offset.to_bits() & 0x7fff_ffff >= 0x4b00_0000 {
            return Err(Reason::OffScreen);
        }
        let middle = (low[axis] + high[axis]) * 128;
        position[axis] = fixed::mul_high(middle << 8, params.ratio[axis]) as i32
            + ((offset.floor() as i32 + 1) >> 1);
        if position[axis] < 0 || position[axis] >> 8 >= params.previous[axis] as i32 {
            return Err(Reason::OffScreen);
        }
    }
    Ok((position, moved))
}

/// The rate of a tile before larger rates have had to agree, its error on each axis, and the reason (pass 2). `logs` decides on a window.
pub(super) fn rate<N: Numbers>(
    numbers: &N,
    data: &[Data<N::Window>],
    inputs: &Inputs,
    params: &Params,
    tile: [u32; 2],
    logs: impl Fn(&N::Window, &Place) -> Logs,
) -> (Logs, [f64; 2], Reason) {
    let low = tile.map(|at| at * SIDE);
    let high = [0, 1].map(|axis: usize| (low[axis] + SIDE).min(inputs.size[axis]));
    let (position, moved) = match fetch(inputs, params, low, high) {
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
    let place = Place {
        speed: [0, 1].map(|axis: usize| motion::speed_index(moved[axis], params.speed_scale[axis])),
        quad: tile.map(|at| at * 8),
        ..Place::default()
    };
    let found = legal(logs(&window, &place));
    let error = [0, 1].map(|axis| numbers.error(&window, axis));
    (found, error, Reason::Content)
}
