//! Which map points a camera should see, and where (ORB-SLAM, Mur-Artal et al. 2015, section V-D, "Track Local Map").

use features::Frame;
use geometry::{SE3, Vec3};
use map::{Map, MapPoint, PointId};
use rayon::prelude::*;

/// Cosine of the largest angle between a point's mean viewing direction and the ray to it: 60 degrees.
const MIN_VIEW_COS: f64 = 0.5;

/// Where a visible point falls in an image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection {
    /// Column in the left image, pixels.
    pub(crate) u: f64,
    /// Row, pixels.
    pub(crate) v: f64,
    /// Column in the right image, pixels.
    pub(crate) right_u: f64,
    /// Octave at which the point should be detected.
    pub(crate) octave: u8,
    /// Cosine of the angle to the point's mean viewing direction.
    pub(crate) view_cos: f64,
}

/// A point with the place where it should appear.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Visible<'m> {
    pub(crate) point: &'m MapPoint,
    pub(crate) projection: Projection,
}

/// Those of the `points` that should be visible from a pose, in their order, without the `known` ones.
pub(crate) fn visible_points<'m>(
    frame: &Frame,
    map: &'m Map,
    cam_from_world: &SE3,
    points: &[PointId],
    known: impl Iterator<Item = PointId>,
) -> Vec<Visible<'m>> {
    let mut known: Vec<PointId> = known.collect();
    known.sort_unstable();
    let center = cam_from_world.center();
    let visible = |&id: &PointId| {
        let point = known.binary_search(&id).is_err().then(|| map.point(id))??;
        let projection = project_visible(frame, cam_from_world, &center, point)?;
        Some(Visible { point, projection })
    };
    points.par_iter().with_min_len(256).filter_map(visible).collect()
}

/// Projects a world position to `(u, v, u_right)`; `None` behind the camera or outside the image.
pub(crate) fn project_inside(frame: &Frame, cam_from_world: &SE3, position: &Vec3) -> Option<Vec3> {
    let point_cam = *cam_from_world * *position;
    if point_cam.z <= 0.0 {
        return None;
    }
    let uvr = frame.rig.stereo.project(&point_cam);
    frame.bounds().contains(&uvr.xy()).then_some(uvr)
}

/// The full test: in front, inside the image, within the distance range, seen from a similar direction.
fn project_visible(
    frame: &Frame,
    cam_from_world: &SE3,
    center: &Vec3,
    point: &MapPoint,
) -> Option<Projection> {
    let uvr = project_inside(frame, cam_from_world, &point.position)?;
    let ray = point.position - center;
    let distance = ray.norm();
    if distance < 0.8 * point.min_distance_m || distance > 1.2 * point.max_distance_m {
        return None;
    }
    let view_cos = ray.dot(&point.normal) / distance;
    if view_cos < MIN_VIEW_COS {
        return None;
    }
    let octave = predict_octave(frame, point.max_distance_m, distance);
    Some(Projection { u: uvr.x, v: uvr.y, right_u: uvr.z, octave, view_cos })
}

/// The octave at which a point of range `max_distance_m` appears from `distance_m`.
fn predict_octave(frame: &Frame, max_distance_m: f64, distance_m: f64) -> u8 {
    let factor = f64::from(frame.scales.factor);
    let levels = frame.scales.scales.len();
    let octave = ((max_distance_m / distance_m).ln() / factor.ln()).ceil();
    octave.clamp(0.0, (levels - 1) as f64) as u8
}

#[cfg(test)]
#[path = "../tests/steps/visibility.rs"]
mod tests;
