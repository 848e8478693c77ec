//! What the surroundings of a feature look like, and where another view of it lies exactly: Gauss-Newton over a shift, with the
//! appearance of the reference warped to the present view (inverse compositional, Baker and Matthews 2004).
//!
//! Corners sit where a detector fires, which differs by half a pixel from view to view. Two patches lie on each other to a tenth.

use crate::plane::Plane;

/// Side of a patch, pixels of the feature's level.
const SIDE: usize = 16;
/// Side of the square that is compared.
const WINDOW: usize = 8;
/// Largest shift that is believed, pixels of the level: more is another corner.
const REACH_PX: f32 = 1.5;
const MAX_ITERATIONS: usize = 8;
/// A step shorter than this ends the search, pixels of the level.
const CONVERGED_PX: f32 = 0.01;
/// Least normalized cross-correlation of patches that show the same.
const LEAST_CORRELATION: f32 = 0.8;
/// Least eigenvalue of the mean outer product of the gradients, squared gray levels per pixel: less has no place.
const LEAST_STRUCTURE: f32 = 4.0;

/// The pixels around a feature, on the feature's level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    pixels: [[u8; SIDE]; SIDE],
    /// Where the feature lies in it.
    center: [f32; 2],
}

/// Where a feature lies according to a reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aligned {
    /// From the feature's position to the aligned one, pixels of its level.
    pub shift: [f32; 2],
    /// Normalized cross-correlation there.
    pub correlation: f32,
}

impl Patch {
    /// The surroundings of a position on a level; `None` too near to its edge.
    pub(crate) fn cut(level: &Plane, x: f32, y: f32) -> Option<Self> {
        let corner = |p: f32, length: usize| {
            let first = p.round() - (SIDE / 2) as f32;
            (first >= 0.0 && first as usize + SIDE <= length).then_some(first as usize)
        };
        let (left, top) = (corner(x, level.width())?, corner(y, level.height())?);
        let mut pixels = [[0; SIDE]; SIDE];
        for (row, line) in pixels.iter_mut().enumerate() {
            line.copy_from_slice(&level.row(top + row)[left..left + SIDE]);
        }
        Some(Patch { pixels, center: [x - left as f32, y - top as f32] })
    }

    /// Finds this feature's place as `reference` has it. `warp` takes steps on the reference's level to steps on this one's.
    /// `None` if the reference has no structure, the shift is too large, or they do not look alike.
    pub fn align(&self, reference: &Patch, warp: [[f32; 2]; 2]) -> Option<Aligned> {
        let template = Template::new(reference, warp)?;
        let mut shift = [0.0f32; 2];
        for _ in 0..MAX_ITERATIONS {
            let seen = self.window(shift)?;
            let (gain, offset) = template.light(&seen);
            let (mut bx, mut by) = (0.0f32, 0.0f32);
            for (i, (&value, &expected)) in seen.iter().zip(&template.values).enumerate() {
                let error = value - offset - gain * expected;
                bx += template.dx[i] * error;
                by += template.dy[i] * error;
            }
            // The reference would move by this to fit; the window moves the other way.
            let [a, b, c] = template.inverse;
            let step = [(a * bx + b * by) / gain, (b * bx + c * by) / gain];
            shift = [shift[0] - step[0], shift[1] - step[1]];
            if !shift.iter().all(|s| s.abs() <= REACH_PX) {
                return None;
            }
            if step[0] * step[0] + step[1] * step[1] < CONVERGED_PX * CONVERGED_PX {
                let correlation = template.correlation(&self.window(shift)?);
                return (correlation >= LEAST_CORRELATION).then_some(Aligned { shift, correlation });
            }
        }
        None
    }

    /// The square around the feature, `shift` beside it.
    fn window(&self, shift: [f32; 2]) -> Option<[f32; WINDOW * WINDOW]> {
        let first = |axis: usize| self.center[axis] + shift[axis] - (WINDOW as f32 - 1.0) / 2.0;
        let (x, y) = (first(0), first(1));
        let last = (SIDE - 1 - WINDOW) as f32;
        if !(x >= 0.0 && y >= 0.0 && x <= last && y <= last) {
            return None;
        }
        let (left, top) = (x as usize, y as usize);
        let (fx, fy) = (x - left as f32, y - top as f32);
        let weights = [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy];
        let mut seen = [0.0; WINDOW * WINDOW];
        for (row, line) in seen.chunks_exact_mut(WINDOW).enumerate() {
            let (upper, lower) = (&self.pixels[top + row][left..], &self.pixels[top + row + 1][left..]);
            for (column, value) in line.iter_mut().enumerate() {
                *value = weights[0] * f32::from(upper[column])
                    + weights[1] * f32::from(upper[column + 1])
                    + weights[2] * f32::from(lower[column])
                    + weights[3] * f32::from(lower[column + 1]);
            }
        }
        Some(seen)
    }

    /// The value between pixels; positions outside take that of the edge.
    fn at(&self, x: f32, y: f32) -> f32 {
        let last = (SIDE - 1) as f32;
        let (x, y) = (x.clamp(0.0, last), y.clamp(0.0, last));
        let (left, top) = ((x as usize).min(SIDE - 2), (y as usize).min(SIDE - 2));
        let (fx, fy) = (x - left as f32, y - top as f32);
        let value = |row: usize, column: usize| f32::from(self.pixels[top + row][left + column]);
        let upper = value(0, 0) + fx * (value(0, 1) - value(0, 0));
        let lower = value(1, 0) + fx * (value(1, 1) - value(1, 0));
        upper + fy * (lower - upper)
    }
}

/// A reference as the present view would show it, about its mean, with its gradients.
struct Template {
    values: [f32; WINDOW * WINDOW],
    /// Gradients, about their means: a change of brightness does not move anything.
    dx: [f32; WINDOW * WINDOW],
    dy: [f32; WINDOW * WINDOW],
    /// Inverse of the sums of the products of the gradients: xx, xy, yy.
    inverse: [f32; 3],
    energy: f32,
}

impl Template {
    fn new(reference: &Patch, warp: [[f32; 2]; 2]) -> Option<Self> {
        let [[a, b], [c, d]] = warp;
        let determinant = a * d - b * c;
        if !determinant.is_finite() || determinant.abs() < 1e-3 {
            return None;
        }
        let back = [[d / determinant, -b / determinant], [-c / determinant, a / determinant]];
        const AROUND: usize = WINDOW + 2;
        let mut around = [[0.0f32; AROUND]; AROUND];
        let middle = (AROUND as f32 - 1.0) / 2.0;
        for (row, line) in around.iter_mut().enumerate() {
            for (column, value) in line.iter_mut().enumerate() {
                let (u, v) = (column as f32 - middle, row as f32 - middle);
                let x = reference.center[0] + back[0][0] * u + back[0][1] * v;
                let y = reference.center[1] + back[1][0] * u + back[1][1] * v;
                *value = reference.at(x, y);
            }
        }
        let cell = |i: usize| (1 + i / WINDOW, 1 + i % WINDOW);
        let mut values = std::array::from_fn(|i| around[cell(i).0][cell(i).1]);
        let mut dx = std::array::from_fn(|i| {
            let (row, column) = cell(i);
            0.5 * (around[row][column + 1] - around[row][column - 1])
        });
        let mut dy = std::array::from_fn(|i| {
            let (row, column) = cell(i);
            0.5 * (around[row + 1][column] - around[row - 1][column])
        });
        for all in [&mut values, &mut dx, &mut dy] {
            let mean = all.iter().sum::<f32>() / all.len() as f32;
            all.iter_mut().for_each(|value| *value -= mean);
        }
        let sum = |p: &[f32], q: &[f32]| p.iter().zip(q).map(|(p, q)| p * q).sum::<f32>();
        let (xx, xy, yy) = (sum(&dx, &dx), sum(&dx, &dy), sum(&dy, &dy));
        let energy = sum(&values, &values);
        let determinant = xx * yy - xy * xy;
        let least = 0.5 * (xx + yy) - (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt();
        let inverse = [yy / determinant, -xy / determinant, xx / determinant];
        let has_structure = least >= LEAST_STRUCTURE * (WINDOW * WINDOW) as f32 && energy > 0.0;
        has_structure.then_some(Template { values, dx, dy, inverse, energy })
    }

    /// Gain and mean by which a window differs from the template.
    fn light(&self, seen: &[f32]) -> (f32, f32) {
        let mean = seen.iter().sum::<f32>() / seen.len() as f32;
        let product: f32 = seen.iter().zip(&self.values).map(|(s, t)| s * t).sum();
        ((product / self.energy).clamp(0.3, 3.0), mean)
    }

    /// Normalized cross-correlation with a window.
    fn correlation(&self, seen: &[f32]) -> f32 {
        let mean = seen.iter().sum::<f32>() / seen.len() as f32;
        let (mut product, mut energy) = (0.0, 0.0);
        for (s, t) in seen.iter().zip(&self.values) {
            product += (s - mean) * t;
            energy += (s - mean) * (s - mean);
        }
        product / (energy * self.energy).sqrt().max(f32::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::GrayImage;

    /// A textured plane seen after the map `from` from its pixels to those of the texture.
    fn view(from: impl Fn(f32, f32) -> (f32, f32), gain: f32) -> Plane {
        let texture = |x: f32, y: f32| {
            let waves = (0.55 * x + 0.2 * y).sin() + (0.35 * y - 0.3 * x).cos() + (0.3 * x + 0.5 * y).sin();
            gain * (120.0 + 30.0 * waves)
        };
        let image = GrayImage::from_fn(64, 64, |x, y| {
            let (x, y) = from(x as f32, y as f32);
            texture(x, y).clamp(0.0, 255.0) as u8
        });
        let mut plane = Plane::default();
        plane.copy_from(&image);
        plane
    }

    #[test]
    fn a_feature_is_found_where_the_reference_has_it() {
        let before = Patch::cut(&view(|x, y| (x, y), 1.0), 30.0, 31.0).unwrap();
        for (dx, dy) in [(0.4, -0.7), (-1.1, 0.2), (0.0, 0.0), (0.9, 0.9)] {
            // What was at (30, 31) is now at (30 + dx, 31 + dy); the detector says (30.2, 30.9).
            let after = Patch::cut(&view(|x, y| (x - dx, y - dy), 0.8), 30.2, 30.9).unwrap();
            let aligned = after.align(&before, [[1.0, 0.0], [0.0, 1.0]]).unwrap();
            let [x, y] = aligned.shift;
            assert!((x + 0.2 - dx).abs() < 0.05 && (y - 0.1 - dy).abs() < 0.05, "{dx} {dy}: {aligned:?}");
            assert!(aligned.correlation > 0.98);
        }
    }

    #[test]
    fn a_warp_is_undone() {
        let before = Patch::cut(&view(|x, y| (x, y), 1.0), 30.0, 31.0).unwrap();
        let (sin, cos) = 0.2f32.sin_cos();
        let warp = [[1.1 * cos, -1.1 * sin], [1.1 * sin, 1.1 * cos]];
        let back = [[cos / 1.1, sin / 1.1], [-sin / 1.1, cos / 1.1]];
        let from = |x: f32, y: f32| {
            let (u, v) = (x - 30.5, y - 30.6);
            (30.0 + back[0][0] * u + back[0][1] * v, 31.0 + back[1][0] * u + back[1][1] * v)
        };
        let after = Patch::cut(&view(from, 1.0), 30.0, 31.0).unwrap();
        let [x, y] = after.align(&before, warp).unwrap().shift;
        assert!((x - 0.5).abs() < 0.05 && (y + 0.4).abs() < 0.05, "{x} {y}");
        let unwarped = after.align(&before, [[1.0, 0.0], [0.0, 1.0]]);
        assert!(unwarped.is_none_or(|aligned| aligned.correlation < 0.97), "{unwarped:?}");
    }

    #[test]
    fn what_looks_different_is_refused() {
        let before = Patch::cut(&view(|x, y| (x, y), 1.0), 30.0, 31.0).unwrap();
        let far = Patch::cut(&view(|x, y| (x + 17.0, y + 9.0), 1.0), 30.0, 31.0).unwrap();
        assert_eq!(far.align(&before, [[1.0, 0.0], [0.0, 1.0]]), None);
        let flat = Patch::cut(&view(|_, _| (0.0, 0.0), 1.0), 30.0, 31.0).unwrap();
        assert_eq!(before.align(&flat, [[1.0, 0.0], [0.0, 1.0]]), None, "a wall has no place");
        assert!(Patch::cut(&view(|x, y| (x, y), 1.0), 5.0, 31.0).is_none());
    }
}
