//! How a measured path drifts, and what that leaves open when a place is seen again.

use geometry::SE3;

use super::{CycleEdge, CycleEdgeKind};

/// Standard deviations of the motions along a path, and how far the path can be off at all.
///
/// Drift is systematic (a calibration that is off by a percent is off all the way): over a cycle of n edges it grows with n, not with
/// its square root. `growth`, the square root of n, makes independent edges add up to that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriftModel {
    /// What even the shortest motion has, meters.
    pub sigma_m: f64,
    /// Meters per meter of path.
    pub m_per_m: f64,
    /// What even the shortest motion has, radians.
    pub sigma_rad: f64,
    /// Radians per meter of path.
    pub rad_per_m: f64,
    /// Radians per radian turned.
    pub rad_per_rad: f64,
    /// Most that is plausible, meters per meter of path.
    pub max_m_per_m: f64,
    /// How far two views of one place can be apart, meters.
    pub margin_m: f64,
}

impl DriftModel {
    /// The edge of a motion `b_from_a` along the path.
    pub fn edge(&self, a: u32, b: u32, b_from_a: SE3, growth: f64) -> CycleEdge {
        let (length, angle) = (b_from_a.translation.norm(), b_from_a.rotation.angle());
        CycleEdge {
            a,
            b,
            b_from_a,
            sigma_m: self.sigma_m + growth * self.m_per_m * length,
            sigma_rad: self.sigma_rad + growth * (self.rad_per_m * length + self.rad_per_rad * angle),
            kind: CycleEdgeKind::Odometry,
        }
    }

    /// Whether two nodes that were estimated `distance_m` apart, with `path_m` of path between them, can show one place.
    pub fn can_meet(&self, distance_m: f64, path_m: f64) -> bool {
        distance_m <= self.margin_m + self.max_m_per_m * path_m
    }

    /// Such a distance over the largest at which they can.
    pub fn strain(&self, distance_m: f64, path_m: f64) -> f64 {
        distance_m / (self.margin_m + self.max_m_per_m * path_m)
    }
}
