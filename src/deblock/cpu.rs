//! The deblocker on the CPU, in f64: the oracle in tests, and for whoever has no GPU at hand.

use super::{Counters, Depth};
use crate::{
    analyse::{fixed, params::linear_code},
    rate::Rate,
    sri::Sri,
};

/// A picture in memory, and what tells its surfaces apart; everything row by row.
#[derive(Clone, Debug)]
pub struct Scene<'s> {
    /// Width and height, in pixels.
    pub extent: [u32; 2],
    /// Red, green, blue and alpha of each pixel, as the GPU would load them.
    pub colors: &'s [[f32; 4]],
    /// The effective rates; bit 7 where coverage split the quad's block.
    pub rates: &'s Sri,
    /// The order of primaries, as for [`Deblocker::set_frame`](super::Deblocker::set_frame).
    pub order: u32,
    /// Depth, and what it means.
    pub depth: Option<(Depth, &'s [f32])>,
    /// Surface numbers.
    pub surfaces: Option<&'s [u32]>,
}

/// A deblocked picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Deblocked {
    /// The colors, not yet rounded to a format.
    pub colors: Vec<[f64; 4]>,
    /// What was counted.
    pub counters: Counters,
    /// How near the nearest comparison of depths was to going the other way, relative to inverse depth: where it is less than what
    /// f32 can tell, the GPU may decide otherwise. Infinite if nothing was compared.
    pub margin: f64,
}

/// A quad's groups: their width and height, and whether coverage split their block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Groups {
    rate: Rate,
    is_split: bool,
}

/// Deblocks a picture.
///
/// # Panics
/// If there is not one color, depth and surface for each pixel.
pub fn deblock(scene: &Scene) -> Deblocked {
    let [width, height] = scene.extent;
    let pixels = width as usize * height as usize;
    assert_eq!(scene.colors.len(), pixels, "a color for each pixel");
    assert!(scene.depth.is_none_or(|(_, depth)| depth.len() == pixels));
    assert!(
        scene
            .surfaces
            .is_none_or(|surfaces| surfaces.len() == pixels)
    );
    let mut result = Deblocked {
        colors: scene
            .colors
            .iter()
            .map(|color| color.map(f64::from))
            .collect(),
        counters: Counters::default(),
        margin: f64::INFINITY,
    };
    for y in 0..height {
        for x in 0..width {
            scene.filter([x, y], &mut result);
        }
    }
    result
}

/// √luma of a quad's pixels, 8 bits each, row by row, as the pass writes it; see [`Luma`](super::Luma). `None` stands for a pixel outside
/// the picture, and gives 0.
pub fn luma_codes(luma: &super::Luma, quad: [Option<[f32; 4]>; 4]) -> [u8; 4] {
    let is_finite = |color: &[f32; 4]| color[..3].iter().all(|c| c.is_finite());
    if quad.iter().flatten().all(is_finite) {
        quad.map(|color| color.map_or(0, |color| luma_code(luma, color)))
    } else {
        let chessboard = [0, 255, 255, 0];
        std::array::from_fn(|i| quad[i].map_or(0, |_| chessboard[i]))
    }
}

/// √luma of a finite color.
fn luma_code(luma: &super::Luma, color: [f32; 4]) -> u8 {
    let units = [color[0], color[1], color[2]].map(|channel| match luma.transfer {
        Some(transfer) => {
            let code = (channel * 255.0 + 0.5) as u8;
            Some(linear_code(code, transfer))
        }
        None => fixed::quantise(channel, luma.white_log2),
    });
    match units {
        [Some(r), Some(g), Some(b)] => {
            fixed::sqrt_code(fixed::luma([r, g, b], luma.weights.fixed())) as u8
        }
        _ => 255,
    }
}

impl Scene<'_> {
    fn index(&self, [x, y]: [u32; 2]) -> usize {
        y as usize * self.extent[0] as usize + x as usize
    }

    /// The byte of a quad; 0 if it stands for full rate.
    fn byte(&self, x: u32, y: u32) -> u8 {
        let byte = self.rates.code(x, y);
        match Rate::from_code(byte & 0x7f) {
            None | Some(Rate::R1X1) => 0,
            Some(_) => byte,
        }
    }

    /// The groups of the quad that a pixel lies in.
    fn groups(&self, pixel: [u32; 2]) -> Groups {
        let [x, y] = pixel.map(|v| v / 2);
        let byte = self.byte(x, y);
        let is_split = byte & 0x80 != 0;
        let rate = Rate::from_code_or_full(byte & 0x7f);
        let agreed = (0..4).all(|i| self.byte((x & !1) + (i & 1), (y & !1) + (i >> 1)) == byte);
        Groups {
            rate: match agreed && !is_split {
                true => rate,
                false => rate.meet(Rate::R2X2),
            },
            is_split,
        }
    }

    /// Where the value of a pixel's group was computed.
    fn sample(&self, pixel: [u32; 2], rate: Rate) -> [u32; 2] {
        let size = [rate.width(), rate.height()];
        let corner = [0, 1].map(|axis| pixel[axis] / size[axis] * size[axis]);
        let odd = self.order.wrapping_sub(1) & 1;
        let offset = match rate {
            _ if self.order == 0 => [0, 0],
            Rate::R2X1 => [(pixel[1] + odd) & 1, 0],
            Rate::R1X2 => [0, (pixel[0] + odd) & 1],
            _ => size.map(|side| odd * (side - 1)),
        };
        [0, 1].map(|axis| (corner[axis] + offset[axis]).min(self.extent[axis] - 1))
    }

    fn filter(&self, pixel: [u32; 2], result: &mut Deblocked) {
        let groups = self.groups(pixel);
        if groups.rate == Rate::R1X1 {
            return;
        }
        let own = self.colors[self.index(pixel)];
        if own[..3].iter().any(|c| !c.is_finite()) {
            result.counters.not_finite += 1;
        }
        let origin = self.sample(pixel, groups.rate);
        let is_active = [0, 1].map(|axis| {
            pixel[axis] != origin[axis] && (!groups.is_split || self.is_like_partner(pixel, axis))
        });
        if is_active == [false; 2] || !is_usable(own) {
            return;
        }
        result.counters.filtered += 1;
        let size = [groups.rate.width(), groups.rate.height()];
        let beyond = [0, 1].map(|axis| {
            let corner = i64::from(pixel[axis] / size[axis] * size[axis]);
            match pixel[axis] > origin[axis] {
                true => corner + i64::from(size[axis]),
                false => corner - 1,
            }
        });
        let base = [0, 1].map(|axis| {
            i64::from(match is_active[axis] {
                true => origin[axis],
                false => pixel[axis],
            })
        });
        let mut part = [0.0; 2];
        let mut beside = [own; 2];
        for axis in [0, 1].into_iter().filter(|&axis| is_active[axis]) {
            let mut at = base;
            at[axis] = beyond[axis];
            if let Some(tap) = self.tap(at) {
                let whole = f64::from(tap[axis]) - f64::from(origin[axis]);
                part[axis] = (f64::from(pixel[axis]) - f64::from(origin[axis])).abs() / whole.abs();
                beside[axis] = self.tapped(pixel, own, tap, result);
            }
        }
        let mut diagonal = own;
        if is_active == [true; 2]
            && let Some(tap) = self.tap(beyond)
        {
            diagonal = self.tapped(pixel, own, tap, result);
        }
        let index = self.index(pixel);
        for channel in 0..3 {
            let [own, across, down, diagonal] =
                [own, beside[0], beside[1], diagonal].map(|color| f64::from(color[channel]));
            let near = own + (across - own) * part[0];
            let far = down + (diagonal - down) * part[0];
            result.colors[index][channel] = near + (far - near) * part[1];
        }
    }

    /// Whether a pixel holds what its neighbour in the quad holds.
    fn is_like_partner(&self, pixel: [u32; 2], axis: usize) -> bool {
        let mut partner = pixel;
        partner[axis] = (pixel[axis] ^ 1).min(self.extent[axis] - 1);
        let bits = |at| self.colors[self.index(at)].map(f32::to_bits);
        bits(pixel) == bits(partner)
    }

    /// The sample of the group at a place; none outside the picture.
    fn tap(&self, at: [i64; 2]) -> Option<[u32; 2]> {
        let inside = (0..2).all(|axis| (0..i64::from(self.extent[axis])).contains(&at[axis]));
        let pixel = at.map(|v| v as u32);
        inside.then(|| self.sample(pixel, self.groups(pixel).rate))
    }

    /// The value of a tap as seen from a pixel.
    fn tapped(
        &self,
        pixel: [u32; 2],
        own: [f32; 4],
        tap: [u32; 2],
        result: &mut Deblocked,
    ) -> [f32; 4] {
        let value = self.colors[self.index(tap)];
        match is_usable(value) && self.is_one_surface(pixel, tap, &mut result.margin) {
            true => value,
            false => {
                result.counters.refused += 1;
                own
            }
        }
    }

    fn is_one_surface(&self, pixel: [u32; 2], tap: [u32; 2], margin: &mut f64) -> bool {
        let is_one = self
            .surfaces
            .is_none_or(|surfaces| surfaces[self.index(pixel)] == surfaces[self.index(tap)]);
        is_one && self.is_in_plane(pixel, tap, margin) && self.is_in_plane(tap, pixel, margin)
    }

    /// Inverse depth; at the border, pixels repeat.
    fn inverse(&self, depth: &Depth, values: &[f32], at: [i64; 2]) -> f64 {
        let inside = [0, 1].map(|axis| at[axis].clamp(0, i64::from(self.extent[axis]) - 1) as u32);
        let value = f64::from(values[self.index(inside)]);
        match depth.kind.to_inverse() {
            Some([factor, summand]) => f64::from(factor) * value + f64::from(summand),
            None if value > 0.0 => 1.0 / value,
            None => 0.0,
        }
    }

    fn is_in_plane(&self, origin: [u32; 2], goal: [u32; 2], margin: &mut f64) -> bool {
        let Some((depth, values)) = &self.depth else {
            return true;
        };
        let [origin, goal] = [origin, goal].map(|at| at.map(i64::from));
        let here = self.inverse(depth, values, origin);
        let mut expected = 0.0;
        for axis in 0..2 {
            let distance = goal[axis] - origin[axis];
            if distance == 0 {
                continue;
            }
            let next = |step| {
                let mut at = origin;
                at[axis] += step;
                self.inverse(depth, values, at)
            };
            let (back, ahead) = (here - next(-1), next(1) - here);
            // at the border there is only one
            let has_back = origin[axis] > 0;
            let has_ahead = origin[axis] + 1 < i64::from(self.extent[axis]);
            let is_back = has_back && (!has_ahead || back.abs() < ahead.abs());
            let slope = if is_back { back } else { ahead };
            expected += slope * distance as f64;
        }
        let off = (self.inverse(depth, values, goal) - here - expected).abs();
        let allowed = here * (-f64::from(depth.tolerance)).exp2();
        if here > 0.0 {
            *margin = margin.min((off - allowed).abs() / here);
        }
        off <= allowed
    }
}

/// Whether differences of it cannot overflow in f32.
fn is_usable(color: [f32; 4]) -> bool {
    color[..3].iter().all(|c| c.abs() < 2f32.powi(126))
}
