//! Sub-pixel disparity: aligns a patch of the left image with the right one by Gauss-Newton (inverse compositional,
//! Baker and Matthews 2004) over disparity, its slope down the rows, and a brightness offset.
//!
//! The slope matters: the ground before a car has a disparity that changes by a third of a pixel per row. A parabola through
//! costs, the usual way, prefers whole pixels; its error on real pairs is nearly twice as large.

use crate::kernels::normal::{self, HALF, LANES, ONE, Patch, Row, SIDE, Sums};
use crate::plane::Plane;
use simd::Simd;

/// Pixels around the position that must exist in the left image.
pub(crate) const MARGIN: usize = normal::MARGIN;
/// Weight of the slope's pull to zero, in units of the information on the disparity per squared pixel.
const SLOPE_PRIOR: f64 = 0.3;
/// Largest credible slope, pixels of disparity per row.
const MAX_SLOPE: f64 = 0.8;
/// Largest share of the patch's contrast that may remain: more remains where two different things are compared.
const MAX_UNEXPLAINED: f64 = 0.6;
/// Least information on the disparity per pixel, squared gray levels per pixel: one gray level of noise moves it by a pixel.
const MIN_INFORMATION: f64 = 1.0;
const MAX_ITERATIONS: usize = 5;
/// Steps of the disparity below this many pixels end the iteration.
const CONVERGED_PX: f64 = 0.08;

/// Where a left patch lies in the right image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Alignment {
    /// Disparity at the position asked for, pixels.
    pub(crate) disparity: f64,
    /// Change of the disparity per row.
    pub(crate) slope: f64,
    /// Brightness that the right image lacks, gray levels.
    pub(crate) offset: f64,
    /// Weighted mean of the absolute differences that remain, gray levels.
    pub(crate) residual: f64,
}

impl Alignment {
    /// A first guess.
    pub(crate) fn start(disparity: f64, offset: f64) -> Self {
        Self { disparity, slope: 0.0, offset, residual: f64::INFINITY }
    }
}

/// Refines the alignment of the pixel `(x, y)` of `left` from `start`; `None` when the patch leaves the right image, has no
/// texture along the row, moves by more than `reach_px`, does not come to rest or does not look the same there.
///
/// # Panics
/// When `(x, y)` is nearer than [`MARGIN`] to the edge of `left`.
pub(crate) fn align(
    simd: Simd,
    (left, x, y): (&Plane, usize, usize),
    right: &Plane,
    start: Alignment,
    reach_px: f64,
) -> Option<Alignment> {
    let patch = Patch::new(simd, left, x, y);
    let mut now = start;
    for iteration in 0..MAX_ITERATIONS {
        let rows = rows_at(right, x, y, &now)?;
        let offset = (now.offset * f64::from(ONE)).round() as i16;
        // Weights make sense once the patch is near its place.
        let sums = normal::sums(simd, &patch, &rows, offset, iteration > 0);
        let [disparity, slope, offset] = solve(&sums, now.slope)?;
        now.disparity += disparity;
        now.slope += slope;
        now.offset += offset;
        now.residual = sums.abs / sums.one;
        if (now.disparity - start.disparity).abs() > reach_px || now.slope.abs() > MAX_SLOPE {
            return None;
        }
        if iteration > 0 && disparity.abs() < CONVERGED_PX {
            return (now.residual < MAX_UNEXPLAINED * patch.contrast).then_some(now);
        }
    }
    None
}

/// The rows of the right image under the patch; `None` when it leaves the image.
fn rows_at<'a>(right: &'a Plane, x: usize, y: usize, at: &Alignment) -> Option<[Row<'a>; SIDE]> {
    /// Positions are computed in steps of 1/65536 pixel and rounded to those of [`Row`].
    const FINE: f64 = 65536.0;
    let middle = (((x - HALF) as f64 - at.disparity) * FINE).round() as i64;
    let slope = (at.slope * FINE).round() as i64;
    let mut rows = [Row { pixels: &[], fraction: 0 }; SIDE];
    for (j, row) in rows.iter_mut().enumerate() {
        let place = (middle - slope * (j as i64 - HALF as i64) + 256) >> 9;
        let (first, fraction) = (usize::try_from(place >> 7).ok()?, (place & 127) as i16);
        if first + SIDE >= right.width() {
            return None;
        }
        let pixels = &right.row(y + j - HALF)[first..first + LANES + 1];
        *row = Row { pixels, fraction };
    }
    Some(rows)
}

/// Change of disparity, slope and offset that minimizes the weighted squares of `e - g (d + j s) + o`; `None` without texture.
fn solve(sums: &Sums, slope: f64) -> Option<[f64; 3]> {
    let Sums { gg, jgg, jjgg, g, jg, one, ge, jge, e, .. } = *sums;
    if one < 1.0 {
        return None;
    }
    // The offset is eliminated first, then Cramer's rule.
    let prior = SLOPE_PRIOR * gg;
    let a = gg - g * g / one;
    let b = jgg - g * jg / one;
    let c = jjgg + prior - jg * jg / one;
    let p = ge - g * e / one;
    let q = jge - prior * slope - jg * e / one;
    let determinant = a * c - b * b;
    if a < MIN_INFORMATION * one || determinant <= 0.0 {
        return None;
    }
    let d = (c * p - b * q) / determinant;
    let s = (a * q - b * p) / determinant;
    Some([d, s, (g * d + jg * s - e) / one])
}
