//! The relative pose behind an essential matrix (Hartley and Zisserman, 9.6).

use crate::aliases::{Mat3, Vec2, Vec3};
use crate::pinhole::Pinhole;
use crate::se3::SE3;
use crate::so3::SO3;
use crate::svd::RotationSvd;
use crate::triangulate::triangulate;

/// The essential matrix of a fundamental matrix: `K_b^T F K_a`.
#[must_use]
pub fn essential_from_fundamental(fundamental: &Mat3, camera_a: &Pinhole, camera_b: &Pinhole) -> Mat3 {
    camera_b.matrix().transpose() * fundamental * camera_a.matrix()
}

/// The four motions `b_from_a`, with a translation of length one, that have this essential matrix up to scale.
///
/// `None` for a matrix that is zero or not finite.
#[must_use]
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

/// A motion chosen among four, and how clearly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheiralityChoice {
    /// The motion with the most points in front of both cameras.
    pub b_from_a: SE3,
    /// How many points that is.
    pub n_in_front: usize,
    /// How many the second best motion has.
    pub n_second_best: usize,
}

/// The motion `b_from_a` (translation of length one) that puts most of the normalized point pairs in front of both cameras.
///
/// `None` when the essential matrix cannot be decomposed or no motion has a point in front; ties go to the earlier motion.
#[must_use]
pub fn pose_from_essential(
    essential: &Mat3,
    normalized_a: &[Vec2],
    normalized_b: &[Vec2],
) -> Option<CheiralityChoice> {
    let motions = decompose_essential(essential)?;
    let counts = motions.map(|b_from_a| {
        let views = [SE3::identity(), b_from_a];
        let pairs = normalized_a.iter().zip(normalized_b);
        pairs.filter(|(a, b)| triangulate(&views, &[**a, **b]).is_some()).count()
    });
    let mut order = [0, 1, 2, 3];
    order.sort_by_key(|&i| std::cmp::Reverse(counts[i]));
    let [best, second, ..] = order;
    (counts[best] > 0).then(|| CheiralityChoice {
        b_from_a: motions[best],
        n_in_front: counts[best],
        n_second_best: counts[second],
    })
}
