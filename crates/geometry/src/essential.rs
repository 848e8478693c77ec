//! The relative pose behind an essential matrix (Hartley and Zisserman, 9.6).

use crate::aliases::{Mat3, Vec3};
use crate::pinhole::Pinhole;
use crate::se3::SE3;
use crate::so3::SO3;
use crate::svd::RotationSvd;

/// The essential matrix of a fundamental matrix: `K_b^T F K_a`.
pub fn essential_from_fundamental(fundamental: &Mat3, camera_a: &Pinhole, camera_b: &Pinhole) -> Mat3 {
    camera_b.matrix().transpose() * fundamental * camera_a.matrix()
}

/// The four motions `b_from_a`, with a translation of length one, that have this essential matrix up to scale.
///
/// `None` for a matrix that is zero or not finite.
pub fn decompose_essential(essential: &Mat3) -> Option<[SE3; 4]> {
    let RotationSvd { u, values, v } = RotationSvd::new(essential)?;
    if values[1] <= 0.0 {
        return None;
    }
    let quarter_turn = Mat3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let rotation = |turn: Mat3| SO3::from_matrix_unchecked(u * turn * v.transpose());
    let (first, second) = (rotation(quarter_turn), rotation(quarter_turn.transpose()));
    let t: Vec3 = u.column(2).into_owned();
    Some([SE3::new(first, t), SE3::new(first, -t), SE3::new(second, t), SE3::new(second, -t)])
}
