//! Homographies: what maps one image of a plane onto another, and any image onto another when the camera only turned
//! (Hartley and Zisserman, chapter 4).

mod decompose;

pub use decompose::{PlanarMotion, decompose_homography};

use crate::aliases::{Mat3, Vec2, Vec3};
use crate::fundamental::{Normalized, direct_linear};

/// Determinant of a matrix of norm one below which it flattens the image.
const MIN_DETERMINANT: f64 = 1e-14;

/// An invertible map between the pixels of two images, with its inverse.
///
/// Scaled to Frobenius norm one and a positive determinant: then `b_from_a * [pixel_a; 1]` has a positive last component for
/// what both cameras see in front of them, on the same side of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homography {
    b_from_a: Mat3,
    a_from_b: Mat3,
}

impl Homography {
    /// The homography of this matrix, up to scale; `None` when it is singular or not finite.
    pub fn new(b_from_a: &Mat3) -> Option<Self> {
        let norm = b_from_a.norm();
        let scaled = b_from_a / norm;
        let determinant = scaled.determinant();
        if !(norm.is_finite() && determinant.abs() > MIN_DETERMINANT) {
            return None;
        }
        let b_from_a = scaled * determinant.signum();
        Some(Self { b_from_a, a_from_b: b_from_a.try_inverse()? })
    }

    /// The matrix that maps homogeneous pixels of image a to those of image b.
    pub fn matrix(&self) -> &Mat3 {
        &self.b_from_a
    }

    /// Squared distances in square pixels: of `pixel_b` from the transferred `pixel_a`, and the other way round.
    pub fn transfer_errors_sq(&self, pixel_a: &Vec2, pixel_b: &Vec2) -> [f64; 2] {
        let error_sq = |matrix: &Mat3, from: &Vec2, to: &Vec2| {
            mapped(matrix, from).map_or(f64::INFINITY, |place| (place - to).norm_squared())
        };
        [error_sq(&self.b_from_a, pixel_a, pixel_b), error_sq(&self.a_from_b, pixel_b, pixel_a)]
    }
}

#[inline]
fn mapped(matrix: &Mat3, pixel: &Vec2) -> Option<Vec2> {
    let place = matrix * pixel.push(1.0);
    (place.z > 0.0).then(|| place.xy() / place.z)
}

/// The homography of four pixel pairs, by way of the basis that the points make of the projective plane (Semple and Kneebone;
/// Hartley and Zisserman, section 2.4): some twenty times faster than [`estimate_homography`].
///
/// `None` when three of four lie on a line, or when no camera in front of a plane sees the points like that (the map would turn
/// some of them over).
pub fn homography_of_four(pixels_a: &[Vec2; 4], pixels_b: &[Vec2; 4]) -> Option<Homography> {
    let ((basis_a, weights_a), (basis_b, weights_b)) = (basis(pixels_a)?, basis(pixels_b)?);
    let ratios = weights_b.component_div(&weights_a);
    if !(ratios.min() > 0.0 || ratios.max() < 0.0) {
        return None;
    }
    Homography::new(&(basis_b * Mat3::from_diagonal(&ratios) * basis_a.try_inverse()?))
}

/// The matrix of the first three homogeneous points, and their weights in the fourth.
fn basis(pixels: &[Vec2; 4]) -> Option<(Mat3, Vec3)> {
    /// Least share of a point in the fourth.
    const MIN_WEIGHT: f64 = 1e-6;
    let [first, second, third, fourth] = pixels.map(|pixel| pixel.push(1.0));
    let basis = Mat3::from_columns(&[first, second, third]);
    let weights = basis.try_inverse()? * fourth;
    // Three points on a line: a weight of zero, or weights beyond all bounds.
    let regular = weights.iter().all(|w| w.abs() > MIN_WEIGHT && w.abs() < 1.0 / MIN_WEIGHT);
    regular.then_some((basis, weights))
}

/// The homography of four or more pixel pairs by the normalized direct linear transform (Hartley and Zisserman, algorithm
/// 4.2); weights default to one.
///
/// `None` when lengths differ, fewer than four pairs are given, or the pairs leave it open (three of four on a line).
pub fn estimate_homography(
    pixels_a: &[Vec2],
    pixels_b: &[Vec2],
    weights: Option<&[f64]>,
) -> Option<Homography> {
    let rows = |a: Vec3, b: Vec3| {
        [
            [0.0, 0.0, 0.0, -a.x, -a.y, -1.0, b.y * a.x, b.y * a.y, b.y],
            [a.x, a.y, 1.0, 0.0, 0.0, 0.0, -b.x * a.x, -b.x * a.y, -b.x],
        ]
    };
    let Normalized { a, b, matrix } = direct_linear(pixels_a, pixels_b, weights, 4, rows)?;
    // Judged before the scales of the pixels come in.
    Homography::new(&matrix)?;
    Homography::new(&(b.try_inverse()? * matrix * a))
}
