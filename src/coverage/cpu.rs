//! The coverage rule on the CPU: the same operations as `shaders/build.wgsl`, one after the other.

use super::{Coverage, DepthKind, Normals, Sky};

/// What a scene has, in memory; each is row by row and may be empty if it is not declared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Width and height.
    pub size: [u32; 2],
    /// Triangle numbers.
    pub triangles: Vec<u32>,
    /// Surface numbers.
    pub surfaces: Vec<u32>,
    /// Depth.
    pub depth: Vec<f32>,
    /// Octahedral normals, each component 0 to 1.
    pub normals: Vec<[f32; 2]>,
}

/// The neighbours of a pixel, in the order in which three pixels of one plane are sought.
const AROUND: [[i32; 2]; 8] = [
    [1, 0],
    [0, 1],
    [-1, 0],
    [0, -1],
    [1, 1],
    [-1, 1],
    [-1, -1],
    [1, -1],
];

/// Cuts to 16 significant bits; what is not finite, or negative, becomes −1, which is close to nothing.
fn quantise(inverse: f32) -> f32 {
    let bits = inverse.to_bits();
    match bits & 0x7f80_0000 == 0x7f80_0000 || bits & 0x8000_0000 != 0 && inverse != 0.0 {
        true => -1.0,
        false => f32::from_bits(bits & 0x7fff_ff00),
    }
}

impl Samples {
    fn at(&self, [x, y]: [i32; 2]) -> usize {
        let clamp = |v: i32, size: u32| v.clamp(0, size as i32 - 1) as usize;
        clamp(y, self.size[1]) * self.size[0] as usize + clamp(x, self.size[0])
    }

    /// The depth of a pixel, as the texture has it.
    pub fn depth_at(&self, [x, y]: [u32; 2]) -> f32 {
        self.depth[self.at([x as i32, y as i32])]
    }

    /// Whether a pixel is sky.
    pub fn is_sky(&self, coverage: &Coverage, [x, y]: [u32; 2]) -> bool {
        let at = self.at([x as i32, y as i32]);
        match coverage.sky {
            None => false,
            Some(Sky::Triangle(sky)) => self.triangles[at] == sky,
            Some(Sky::Surface(sky)) => self.surfaces[at] == sky,
            Some(Sky::Depth) => {
                let depth = self.depth[at];
                match coverage.depth.map(|depth| depth.kind) {
                    Some(DepthKind::Standard { .. }) => depth >= 1.0,
                    Some(DepthKind::Linear) => !(depth > 0.0 && depth <= f32::MAX),
                    _ => depth <= 0.0,
                }
            }
        }
    }

    /// Inverse depth, up to a factor.
    fn inverse(&self, coverage: &Coverage, at: [i32; 2]) -> f32 {
        let depth = self.depth[self.at(at)];
        match coverage.depth.and_then(|depth| depth.kind.to_inverse()) {
            Some([scale, bias]) => quantise(depth * scale + bias),
            None => quantise(1.0 / depth),
        }
    }

    /// The slope of inverse depth at a pixel along an axis: the smaller difference to either side.
    fn slope(&self, coverage: &Coverage, at: [i32; 2], axis: usize) -> f32 {
        let mut before = at;
        let mut after = at;
        before[axis] -= 1;
        after[axis] += 1;
        let here = self.inverse(coverage, at);
        let back = here - self.inverse(coverage, before);
        let ahead = self.inverse(coverage, after) - here;
        match back.abs() < ahead.abs() {
            true => back,
            false => ahead,
        }
    }

    /// Whether `to` lies in the plane through `from`.
    fn is_in_plane(&self, coverage: &Coverage, from: [i32; 2], to: [i32; 2]) -> bool {
        let (here, there) = (self.inverse(coverage, from), self.inverse(coverage, to));
        if here < 0.0 || there < 0.0 {
            return false;
        }
        let [dx, dy] = [0, 1].map(|axis| (to[axis] - from[axis]) as f32);
        let expected = self.slope(coverage, from, 0) * dx + self.slope(coverage, from, 1) * dy;
        let tolerance = coverage.depth.map_or(0, |depth| depth.tolerance);
        ((there - here) - expected).abs() <= here * 0.5f32.powi(tolerance as i32)
    }

    fn is_z_close(&self, coverage: &Coverage, a: [i32; 2], b: [i32; 2]) -> bool {
        coverage.depth.is_none()
            || self.is_in_plane(coverage, a, b) && self.is_in_plane(coverage, b, a)
    }

    /// A pixel's normal, on a grid where the components' absolute values sum up to about 127; zero if there is none.
    fn normal(&self, coverage: &Coverage, at: [i32; 2]) -> [i32; 3] {
        match coverage.normals {
            None => [0; 3],
            Some(Normals::Octahedral { .. }) => {
                let [x, y] = self.normals[self.at(at)]
                    .map(|v| ((v * 254.0 + 0.5).floor() as i32 - 127).clamp(-127, 127));
                let z = 127 - x.abs() - y.abs();
                let sign = |v: i32| if v < 0 { -1 } else { 1 };
                match z < 0 {
                    true => [(127 - y.abs()) * sign(x), (127 - x.abs()) * sign(y), z],
                    false => [x, y, z],
                }
            }
            Some(Normals::Rebuilt { tangents, .. }) => self.rebuilt(coverage, tangents, at),
        }
    }

    fn rebuilt(&self, coverage: &Coverage, tangents: [f32; 2], at: [i32; 2]) -> [i32; 3] {
        let here = self.inverse(coverage, at);
        let id = self.triangles[self.at(at)];
        let usable = |offset: [i32; 2]| {
            let there = [at[0] + offset[0], at[1] + offset[1]];
            let is_inside = (0..2).all(|axis| (0..self.size[axis] as i32).contains(&there[axis]));
            (is_inside
                && self.triangles[self.at(there)] == id
                && self.inverse(coverage, there) >= 0.0)
                .then(|| self.inverse(coverage, there) - here)
        };
        if here < 0.0 {
            return [0; 3];
        }
        for (index, &a) in AROUND.iter().enumerate() {
            let Some(along_a) = usable(a) else { continue };
            for &b in &AROUND[index + 1..] {
                let area = a[0] * b[1] - a[1] * b[0];
                let Some(along_b) = usable(b).filter(|_| area != 0) else {
                    continue;
                };
                let area = area as f32;
                let gx = (along_a * b[1] as f32 - along_b * a[1] as f32) / area;
                let gy = (along_b * a[0] as f32 - along_a * b[0] as f32) / area;
                return self.plane_normal(tangents, at, here, [gx, gy]);
            }
        }
        [0; 3]
    }

    /// The normal of the plane with this slope of inverse depth.
    ///
    /// A plane n·P = d seen through P = z (u, v, 1) is 1/z = (n/d)·(u, v, 1): its slopes along u and v are n's first two
    /// components, and what remains is the third.
    fn plane_normal(
        &self,
        tangents: [f32; 2],
        at: [i32; 2],
        here: f32,
        slope: [f32; 2],
    ) -> [i32; 3] {
        let mut normal = [0.0, 0.0, here];
        for axis in 0..2 {
            let size = self.size[axis] as f32;
            let pixels = size / (2.0 * tangents[axis]);
            let seen = (at[axis] as f32 + 0.5 - size * 0.5) / pixels;
            normal[axis] = slope[axis] * pixels;
            normal[2] -= seen * normal[axis];
        }
        let sum = normal[0].abs() + normal[1].abs() + normal[2].abs();
        match sum > 0.0 {
            true => normal.map(|n: f32| (n * 127.0 / sum + 0.5).floor() as i32),
            false => [0; 3],
        }
    }

    fn is_normal_close(&self, coverage: &Coverage, a: [i32; 2], b: [i32; 2]) -> bool {
        let Some(normals) = coverage.normals else {
            return true;
        };
        let (a, b) = (self.normal(coverage, a), self.normal(coverage, b));
        let dot = |a: [i32; 3], b: [i32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let lengths = dot(a, a) * dot(b, b);
        let along = dot(a, b);
        along > 0 && along * along >= lengths - (lengths >> normals.tolerance())
    }

    /// Whether a pixel may take another's result.
    pub fn share(&self, coverage: &Coverage, a: [u32; 2], b: [u32; 2]) -> bool {
        let (a_sky, b_sky) = (self.is_sky(coverage, a), self.is_sky(coverage, b));
        if a_sky || b_sky {
            return a_sky && b_sky;
        }
        let [a, b] = [a, b].map(|p| p.map(|v| v as i32));
        let (at_a, at_b) = (self.at(a), self.at(b));
        if coverage.surfaces && self.surfaces[at_a] != self.surfaces[at_b] {
            return false;
        }
        if coverage.triangles {
            if self.triangles[at_a] == self.triangles[at_b] {
                return true;
            }
            // other triangles share only where they are one surface, or where normals and depth say that they lie in one plane
            let is_plane = coverage.normals.is_some() && coverage.depth.is_some();
            if !is_plane && !coverage.surfaces {
                return false;
            }
        }
        self.is_normal_close(coverage, a, b) && self.is_z_close(coverage, a, b)
    }
}
