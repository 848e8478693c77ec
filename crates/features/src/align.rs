//! Sub-pixel disparity: aligns a patch of the left image with the right one by Gauss-Newton (inverse compositional,
//! Baker and Matthews 2004) over disparity, its slope down the rows, and a brightness offset.
//!
//! The slope matters: the ground before a car has a disparity that changes by a third of a pixel per row. A parabola through
//! costs, the usual way, prefers whole pixels; its error on real pairs is a third larger.

use crate::kernels::Simd;
use crate::kernels::dispatch::{Task, dispatch};
use crate::plane::Plane;

/// Half side of the patch in pixels; rows are computed as 16 lanes of which the last has no weight.
const HALF: usize = 7;
const SIDE: usize = 2 * HALF + 1;
const LANES: usize = 16;
/// Pixels around the position that must exist in the left image.
pub(crate) const MARGIN: usize = HALF + 1;
/// Standard deviation of the patch's weights, pixels.
const SIGMA_PX: f32 = 5.0;
/// Grey levels of difference from which a pixel has no weight.
const OUTLIER: f32 = 40.0;
/// Weight of the slope's pull to zero, in units of the information on the disparity per squared pixel.
const SLOPE_PRIOR: f32 = 0.3;
/// Largest credible slope, pixels of disparity per row.
const MAX_SLOPE: f32 = 0.8;
/// Largest share of the patch's contrast that may remain: more remains where two different things are compared.
const MAX_UNEXPLAINED: f32 = 0.5;
const MAX_ITERATIONS: usize = 5;
/// Steps of the disparity below this many pixels end the iteration.
const CONVERGED_PX: f32 = 0.08;

/// Where a left patch lies in the right image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Alignment {
    /// Disparity at the position asked for, pixels.
    pub(crate) disparity: f32,
    /// Change of the disparity per row.
    pub(crate) slope: f32,
    /// Weighted mean of the absolute differences that remain, grey levels.
    pub(crate) residual: f32,
}

/// Refines the disparity of the pixel `(x, y)` of `left`, starting at `disparity`; `None` when the patch leaves the right
/// image, has no texture along the row, moves by more than `reach` pixels or does not come to rest.
///
/// # Panics
/// When `(x, y)` is nearer than [`MARGIN`] to the edge of `left`.
pub(crate) fn align(
    simd: Simd,
    left: &Plane,
    right: &Plane,
    (x, y): (usize, usize),
    disparity: f32,
    reach: f32,
) -> Option<Alignment> {
    dispatch(simd, Align { left, right, x, y, disparity, reach })
}

struct Align<'a> {
    left: &'a Plane,
    right: &'a Plane,
    x: usize,
    y: usize,
    disparity: f32,
    reach: f32,
}

impl Task for Align<'_> {
    type Output = Option<Alignment>;

    #[inline(always)]
    fn run(self) -> Option<Alignment> {
        let Self { left, right, x, y, disparity: start, reach } = self;
        let template = Template::new(left, x, y);
        let (mut disparity, mut slope, mut offset) = (start, 0.0, 0.0);
        for iteration in 0..MAX_ITERATIONS {
            // The offset is unknown at first: every pixel counts.
            let outlier = if iteration == 0 { 1e6 } else { OUTLIER };
            let sums = template.sums(right, x, y, disparity, slope, offset, outlier)?;
            let step = sums.step(slope)?;
            disparity += step[0];
            slope += step[1];
            offset += step[2];
            if (disparity - start).abs() > reach || slope.abs() > MAX_SLOPE {
                return None;
            }
            if iteration > 0 && step[0].abs() < CONVERGED_PX {
                let residual = sums.residual();
                let explained = residual < MAX_UNEXPLAINED * template.contrast();
                return explained.then_some(Alignment { disparity, slope, residual });
            }
        }
        None
    }
}

/// The left patch and its derivative along the row.
struct Template {
    values: [[f32; LANES]; SIDE],
    gradients: [[f32; LANES]; SIDE],
}

/// Sums over the patch by lane; `j` is the row relative to the middle, `g` the gradient, `e` the difference.
#[derive(Default)]
struct Sums {
    gg: [f32; 8],
    jgg: [f32; 8],
    jjgg: [f32; 8],
    g: [f32; 8],
    jg: [f32; 8],
    one: [f32; 8],
    ge: [f32; 8],
    jge: [f32; 8],
    e: [f32; 8],
    abs: [f32; 8],
}

impl Template {
    #[inline(always)]
    fn new(left: &Plane, x: usize, y: usize) -> Self {
        let mut template = Self { values: [[0.0; LANES]; SIDE], gradients: [[0.0; LANES]; SIDE] };
        for row in 0..SIDE {
            let pixels = &left.row(y + row - HALF)[x - MARGIN..x - MARGIN + LANES + 2];
            let (before, after) = (widened(pixels), widened(&pixels[2..]));
            template.values[row] = widened(&pixels[1..]);
            for i in 0..LANES {
                template.gradients[row][i] = 0.5 * (after[i] - before[i]);
            }
        }
        template
    }

    /// Weighted mean of the absolute deviations from the mean, grey levels.
    #[inline(always)]
    fn contrast(&self) -> f32 {
        let weighted_mean = |subtracted: f32, absolute: bool| {
            let (mut sums, mut ones) = ([0.0; 8], [0.0; 8]);
            for (values, weights) in self.values.iter().zip(&WEIGHTS) {
                for half in [0, 8] {
                    for k in 0..8 {
                        let deviation = values[half + k] - subtracted;
                        let deviation = if absolute { deviation.abs() } else { deviation };
                        sums[k] += weights[half + k] * deviation;
                        ones[k] += weights[half + k];
                    }
                }
            }
            total(&sums) / total(&ones)
        };
        weighted_mean(weighted_mean(0.0, false), true)
    }

    /// Sums of the linearised problem; `None` when the patch leaves the right image.
    #[inline(always)]
    fn sums(
        &self,
        right: &Plane,
        x: usize,
        y: usize,
        disparity: f32,
        slope: f32,
        offset: f32,
        outlier: f32,
    ) -> Option<Sums> {
        let mut sums = Sums::default();
        let inv_outlier_sq = 1.0 / (outlier * outlier);
        for row in 0..SIDE {
            let j = row as f32 - HALF as f32;
            let place = (x - HALF) as f32 - disparity - slope * j;
            let first = place.floor();
            let fraction = place - first;
            if first < 0.0 || first as usize + SIDE + 1 > right.width() {
                return None;
            }
            let pixels = &right.row(y + row - HALF)[first as usize..first as usize + LANES + 1];
            let (before, after) = (widened(pixels), widened(&pixels[1..]));
            let (weights, values, gradients) = (&WEIGHTS[row], &self.values[row], &self.gradients[row]);
            let mut of_row = [[0.0; 8]; 6];
            for half in [0, 8] {
                for k in 0..8 {
                    let i = half + k;
                    let e = before[i] + fraction * (after[i] - before[i]) + offset - values[i];
                    let weight = weights[i] * (1.0 - e * e * inv_outlier_sq).max(0.0);
                    let wg = weight * gradients[i];
                    of_row[0][k] += wg * gradients[i];
                    of_row[1][k] += wg;
                    of_row[2][k] += weight;
                    of_row[3][k] += wg * e;
                    of_row[4][k] += weight * e;
                    of_row[5][k] += weight * e.abs();
                }
            }
            let [gg, g, one, ge, e, abs] = of_row;
            for k in 0..8 {
                sums.gg[k] += gg[k];
                sums.jgg[k] += j * gg[k];
                sums.jjgg[k] += j * j * gg[k];
                sums.g[k] += g[k];
                sums.jg[k] += j * g[k];
                sums.one[k] += one[k];
                sums.ge[k] += ge[k];
                sums.jge[k] += j * ge[k];
                sums.e[k] += e[k];
                sums.abs[k] += abs[k];
            }
        }
        Some(sums)
    }
}

impl Sums {
    /// Solves for the change of disparity, slope and offset; `None` without texture.
    #[inline(always)]
    fn step(&self, slope: f32) -> Option<[f32; 3]> {
        let [gg, jgg, jjgg] = [total(&self.gg), total(&self.jgg), total(&self.jjgg)];
        let [g, jg, one] = [total(&self.g), total(&self.jg), total(&self.one)];
        let [ge, jge, e] = [total(&self.ge), total(&self.jge), total(&self.e)];
        // Residual e - g * (d + j * s) + o: eliminate the offset, then Cramer for the two others.
        if one < 1.0 {
            return None;
        }
        let prior = SLOPE_PRIOR * gg;
        let a = gg - g * g / one;
        let b = jgg - g * jg / one;
        let c = jjgg + prior - jg * jg / one;
        let p = ge - g * e / one;
        let q = jge - prior * slope - jg * e / one;
        let determinant = a * c - b * b;
        // Below this the disparity is known worse than to about a pixel.
        if a < one || determinant <= 0.0 {
            return None;
        }
        let d = (c * p - b * q) / determinant;
        let s = (a * q - b * p) / determinant;
        Some([d, s, (g * d + jg * s - e) / one])
    }

    fn residual(&self) -> f32 {
        total(&self.abs) / total(&self.one)
    }
}

#[inline(always)]
fn widened(pixels: &[u8]) -> [f32; LANES] {
    let mut values = [0.0; LANES];
    let pixels = &pixels[..LANES];
    for i in 0..LANES {
        values[i] = f32::from(pixels[i]);
    }
    values
}

/// Sum of the lanes in a fixed order.
#[inline(always)]
fn total(lanes: &[f32; 8]) -> f32 {
    let [a, b, c, d, e, f, g, h] = *lanes;
    ((a + e) + (b + f)) + ((c + g) + (d + h))
}

/// Gaussian weights of the patch, the last lane zero.
static WEIGHTS: [[f32; LANES]; SIDE] = weights();

const fn weights() -> [[f32; LANES]; SIDE] {
    let mut table = [[0.0; LANES]; SIDE];
    let mut row = 0;
    while row < SIDE {
        let mut column = 0;
        while column < SIDE {
            let (dx, dy) = (column.abs_diff(HALF), row.abs_diff(HALF));
            table[row][column] =
                exp_negative((dx * dx + dy * dy) as f64 / (2.0 * (SIGMA_PX * SIGMA_PX) as f64)) as f32;
            column += 1;
        }
        row += 1;
    }
    table
}

/// `exp(-x)` for small positive `x` by its series, for constants.
const fn exp_negative(x: f64) -> f64 {
    let (mut sum, mut term, mut n) = (1.0, 1.0, 1.0);
    while n < 40.0 {
        term *= x / n;
        sum += term;
        n += 1.0;
    }
    1.0 / sum
}
