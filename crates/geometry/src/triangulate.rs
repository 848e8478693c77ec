//! Points from two or more views of known poses, by the direct linear transform (Hartley and Zisserman, 12.2).

use crate::aliases::{Mat4, Vec2, Vec3};
use crate::se3::SE3;
use crate::svd::{RightSvd, triangular_factor};
use nalgebra::{MatrixXx4, RowVector4};

/// Below this weight, relative to the unit homogeneous vector in units of the baseline, a point counts as infinitely far.
const MIN_HOMOGENEOUS_WEIGHT: f64 = 1e-10;

/// The world point seen at the normalized image points `(x, y) = (X / Z, Y / Z)` of two or more views.
///
/// Minimizes the algebraic error, which is close to the reprojection error for noise of a few pixels. `None` for fewer than
/// two views, views without a baseline, or a point at infinity. The point may lie behind a camera: see [`triangulate`].
pub fn triangulate_dlt(cams_from_world: &[SE3], normalized: &[Vec2]) -> Option<Vec3> {
    if cams_from_world.len() != normalized.len() || cams_from_world.len() < 2 {
        return None;
    }
    // The first center as origin and the baseline as unit make the conditioning independent of the choice of the world.
    let origin = cams_from_world[0].center();
    let unit = cams_from_world.iter().map(|cam| (cam.center() - origin).norm()).fold(0.0, f64::max);
    if !(unit.is_finite() && unit > 0.0) {
        return None;
    }
    let rows = |i: usize| equations(&cams_from_world[i], &normalized[i], &origin, unit);
    let system = if cams_from_world.len() == 2 {
        let ([a, b], [c, d]) = (rows(0), rows(1));
        Mat4::from_rows(&[a, b, c, d])
    } else {
        let all: Vec<_> = (0..cams_from_world.len()).flat_map(rows).collect();
        triangular_factor(MatrixXx4::from_rows(&all))?
    };
    let solution = RightSvd::new(&system)?.null_vector();
    if solution.w.abs() < MIN_HOMOGENEOUS_WEIGHT {
        return None;
    }
    let point = origin + solution.xyz() * (unit / solution.w);
    point.iter().all(|v| v.is_finite()).then_some(point)
}

/// Like [`triangulate_dlt`], and `None` unless the point lies in front of every camera.
pub fn triangulate(cams_from_world: &[SE3], normalized: &[Vec2]) -> Option<Vec3> {
    let point = triangulate_dlt(cams_from_world, normalized)?;
    cams_from_world.iter().all(|cam| (cam * point).z > 0.0).then_some(point)
}

/// The angle in radians between two directions, from 0 to pi, precise also for tiny angles; zero if a direction is zero.
pub fn angle_between(a: &Vec3, b: &Vec3) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// The two equations `x P_3 - P_1 = 0`, `y P_3 - P_2 = 0` of one view on the homogeneous point, moved and scaled.
fn equations(cam_from_world: &SE3, normalized: &Vec2, origin: &Vec3, unit: f64) -> [RowVector4<f64>; 2] {
    let r = cam_from_world.rotation.matrix();
    let t = (cam_from_world * origin) / unit;
    let row = |i: usize| RowVector4::new(r[(i, 0)], r[(i, 1)], r[(i, 2)], t[i]);
    let depth = row(2);
    [depth * normalized.x - row(0), depth * normalized.y - row(1)]
}
