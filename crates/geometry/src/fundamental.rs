//! The fundamental matrix of two views by the normalized eight-point algorithm (Hartley 1997).
//!
//! `F` maps a pixel of view `a` to its epipolar line in view `b`: `[pixel_b; 1]^T F [pixel_a; 1] = 0`.

use crate::aliases::{Mat3, Vec2, Vec3};
use crate::svd::{RightSvd, triangular_factor};
use nalgebra::{OMatrix, RowSVector, U9};

/// Second smallest singular value over the largest below which the points do not determine the matrix.
const MIN_RANK_RATIO: f64 = 1e-9;

/// The fundamental matrix of eight or more pixel pairs, of rank two and Frobenius norm one; weights default to one.
///
/// `None` when lengths differ, fewer than eight pairs are given, or the pairs leave it open (points on a plane, no motion).
pub fn estimate_fundamental(pixels_a: &[Vec2], pixels_b: &[Vec2], weights: Option<&[f64]>) -> Option<Mat3> {
    let row = |a: Vec3, b: Vec3| [[b.x * a.x, b.x * a.y, b.x, b.y * a.x, b.y * a.y, b.y, a.x, a.y, 1.0]];
    let Normalized { a, b, matrix } = direct_linear(pixels_a, pixels_b, weights, 8, row)?;
    let f = b.transpose() * with_rank_two(&matrix)? * a;
    let norm = f.norm();
    (norm.is_finite() && norm > 0.0).then(|| f / norm)
}

/// A matrix between two images whose pixels are normalized by `a` and `b`.
pub(crate) struct Normalized {
    pub(crate) a: Mat3,
    pub(crate) b: Mat3,
    pub(crate) matrix: Mat3,
}

/// The direct linear transform: the matrix, row by row, on which the equations of each pair of normalized homogeneous pixels vanish.
///
/// `None` when lengths differ, fewer than `n_least` pairs are given, or the pairs leave it open.
pub(crate) fn direct_linear<const N: usize>(
    pixels_a: &[Vec2],
    pixels_b: &[Vec2],
    weights: Option<&[f64]>,
    n_least: usize,
    equations: impl Fn(Vec3, Vec3) -> [[f64; 9]; N],
) -> Option<Normalized> {
    let n = pixels_a.len();
    let is_usable = |w: &[f64]| w.len() == n && !w.iter().any(|&v| v < 0.0);
    if n < n_least || pixels_b.len() != n || !weights.is_none_or(is_usable) {
        return None;
    }
    let (a, b) = (normalization(pixels_a)?, normalization(pixels_b)?);
    // Nine rows at least, so that the triangular factor is square.
    let mut system = OMatrix::<f64, nalgebra::Dyn, U9>::zeros((N * n).max(9));
    for i in 0..n {
        let weight = weights.map_or(1.0, |w| w[i].sqrt());
        let rows = equations(a * pixels_a[i].push(1.0), b * pixels_b[i].push(1.0));
        for (k, row) in rows.iter().enumerate() {
            system.set_row(N * i + k, &(RowSVector::<f64, 9>::from_row_slice(row) * weight));
        }
    }
    let svd = RightSvd::new(&triangular_factor(system)?)?;
    let is_open = svd.values[7] <= MIN_RANK_RATIO * svd.values[0];
    (!is_open).then(|| Normalized { a, b, matrix: Mat3::from_row_slice(svd.null_vector().as_slice()) })
}

/// The Sampson distance: the squared distance in square pixels, to first order, from a pair to the nearest exact pair.
///
/// Hartley and Zisserman, equation 11.9. Not a number where both pixels are epipoles.
#[inline]
pub fn sampson_error_sq(fundamental: &Mat3, pixel_a: &Vec2, pixel_b: &Vec2) -> f64 {
    let (a, b) = (pixel_a.push(1.0), pixel_b.push(1.0));
    let line_b = fundamental * a;
    let line_a = fundamental.tr_mul(&b);
    let algebraic = b.dot(&line_b);
    let gradient_sq = line_b.x * line_b.x + line_b.y * line_b.y + line_a.x * line_a.x + line_a.y * line_a.y;
    algebraic * algebraic / gradient_sq
}

/// Moves the centroid to zero and the mean distance from it to the square root of two.
fn normalization(pixels: &[Vec2]) -> Option<Mat3> {
    let n = pixels.len() as f64;
    let centroid = pixels.iter().sum::<Vec2>() / n;
    let mean_distance = pixels.iter().map(|p| (p - centroid).norm()).sum::<f64>() / n;
    if !(mean_distance.is_finite() && mean_distance > 0.0) {
        return None;
    }
    let s = std::f64::consts::SQRT_2 / mean_distance;
    Some(Mat3::new(s, 0.0, -s * centroid.x, 0.0, s, -s * centroid.y, 0.0, 0.0, 1.0))
}

/// The nearest matrix of rank two: without the part along the last right singular vector.
fn with_rank_two(matrix: &Mat3) -> Option<Mat3> {
    let last = RightSvd::new(matrix)?.null_vector();
    Some(matrix - (matrix * last) * last.transpose())
}
