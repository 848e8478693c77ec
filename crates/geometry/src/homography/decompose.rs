//! The motions behind a homography of a plane.
//!
//! Ma, Soatto, Kosecka and Sastry, "An Invitation to 3-D Vision", section 5.3.3, theorem 5.19. The solutions are those of Faugeras and
//! Lustman (1988) with both cameras on the same side of the plane.

use super::Homography;
use crate::aliases::{Mat3, Vec3};
use crate::pinhole::Pinhole;
use crate::se3::SE3;
use crate::so3::SO3;
use crate::svd::RightSvd;

/// Difference of the squared outer singular values, the middle one being one, below which the camera did not move.
const MIN_SPREAD: f64 = 1e-10;

/// A motion and the plane that it was seen by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarMotion {
    /// The motion; its translation is in units of the plane's distance from camera a.
    pub b_from_a: SE3,
    /// Unit normal of the plane in camera a: its points have `normal_a . x = 1` in these units.
    pub normal_a: Vec3,
}

/// The four motions `b_from_a` that induce this homography on a plane; the second and the fourth are the first and the third
/// with normal and translation reversed.
///
/// At most two have points in front of both cameras. `None` when the camera turned only, as no plane can be told then.
pub fn decompose_homography(
    homography: &Homography,
    camera_a: &Pinhole,
    camera_b: &Pinhole,
) -> Option<[PlanarMotion; 4]> {
    let calibrated = camera_b.matrix().try_inverse()? * homography.matrix() * camera_a.matrix();
    let svd = RightSvd::new(&calibrated)?;
    // The middle singular value of R + t n^T is one.
    let h = calibrated / svd.values[1];
    let squares = svd.values.map(|value| (value / svd.values[1]).powi(2));
    let spread = squares[0] - squares[2];
    if !(spread.is_finite() && spread > MIN_SPREAD) {
        return None;
    }
    // Vectors whose length the homography keeps, orthogonal to the second axis.
    let (along, across) = ((1.0 - squares[2]).max(0.0) / spread, (squares[0] - 1.0).max(0.0) / spread);
    let axis = |i: usize| svd.right.column(i).into_owned();
    let kept =
        [axis(0) * along.sqrt() + axis(2) * across.sqrt(), axis(0) * along.sqrt() - axis(2) * across.sqrt()];
    let [first, second] = kept.map(|kept| motion(&h, &axis(1), &kept));
    Some([first, reversed(&first), second, reversed(&second)])
}

/// The motion that turns the plane of two orthogonal unit vectors as the homography does.
fn motion(h: &Mat3, axis: &Vec3, kept: &Vec3) -> PlanarMotion {
    let normal_a = axis.cross(kept);
    let (image_axis, image_kept) = (h * axis, h * kept);
    let before = Mat3::from_columns(&[*axis, *kept, normal_a]);
    let after = Mat3::from_columns(&[image_axis, image_kept, image_axis.cross(&image_kept)]);
    let rotation = SO3::from_matrix(&(after * before.transpose()));
    let translation = (h - rotation.matrix()) * normal_a;
    PlanarMotion { b_from_a: SE3::new(rotation, translation), normal_a }
}

fn reversed(motion: &PlanarMotion) -> PlanarMotion {
    let PlanarMotion { b_from_a, normal_a } = motion;
    PlanarMotion { b_from_a: SE3::new(b_from_a.rotation, -b_from_a.translation), normal_a: -normal_a }
}
