//! A rigid motion as it is written.

use geometry::{Quaternion, SE3, SO3, Vec3};
use serde::{Deserialize, Serialize};

/// A rigid motion: unit quaternion `x y z w` and translation in meters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Rotation.
    pub rotation_xyzw: [f64; 4],
    /// Translation, meters.
    pub translation: [f64; 3],
}

impl From<&SE3> for Pose {
    fn from(pose: &SE3) -> Self {
        let q = pose.rotation.to_quaternion();
        Pose { rotation_xyzw: [q.i, q.j, q.k, q.w], translation: pose.translation.into() }
    }
}

impl From<&Pose> for SE3 {
    fn from(pose: &Pose) -> Self {
        let [x, y, z, w] = pose.rotation_xyzw;
        let rotation = SO3::from_quaternion(&Quaternion::from_quaternion([x, y, z, w].into()));
        SE3::new(rotation, Vec3::from(pose.translation))
    }
}

impl Pose {
    /// Whether all numbers are finite and the quaternion can be one of a rotation.
    pub fn is_valid(&self) -> bool {
        let norm_sq: f64 = self.rotation_xyzw.iter().map(|q| q * q).sum();
        self.translation.iter().all(|t| t.is_finite()) && (norm_sq - 1.0).abs() < 1e-3
    }
}
