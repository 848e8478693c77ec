//! Places the features of a tracked frame where the points' reference views have them: to a tenth of a pixel instead of half a one.

use features::Frame;
use geometry::{SE3, Vec2, Vec3};
use map::{Map, MapPoint, Observation, PointId};

/// Largest change of scale between views that are compared, a factor and its inverse.
const MAX_ZOOM: f64 = 1.5;
/// Least cosine between the directions from which a point is compared.
const LEAST_VIEW_COS: f64 = 0.9;

/// Shifts `(feature, dx, dy)` in pixels of level 0 of the features that could be aligned.
pub(super) fn alignments(
    frame: &Frame,
    map: &Map,
    cam_from_world: &SE3,
    matches: &[(u32, PointId)],
) -> Vec<(u32, f32, f32)> {
    let shift = |&(feature, point): &(u32, PointId)| {
        let i = feature as usize;
        let patch = frame.patch(i)?;
        let (reference, warp) = reference(frame, i, map, cam_from_world, map.point(point)?)?;
        let seen = map.keyframe(reference.keyframe)?;
        let aligned = patch.align(seen.frame.patch(reference.feature as usize)?, warp)?;
        let scale = frame.scales.scales[usize::from(frame.keypoints[i].octave)];
        Some((feature, aligned.shift[0] * scale, aligned.shift[1] * scale))
    };
    matches.iter().filter_map(shift).collect()
}

/// The oldest view of a point that looks at it from about where the frame does, and how steps on its level become steps on the
/// level of the frame's feature.
fn reference(
    frame: &Frame,
    feature: usize,
    map: &Map,
    cam_from_world: &SE3,
    point: &MapPoint,
) -> Option<(Observation, [[f32; 2]; 2])> {
    let center = cam_from_world.center();
    let to_point = (point.position - center).normalize();
    point.observations().iter().find_map(|&seen| {
        let keyframe = map.keyframe(seen.keyframe)?;
        let from = (point.position - keyframe.center()).normalize();
        if from.dot(&to_point) < LEAST_VIEW_COS {
            return None;
        }
        let warp = warp(
            (&keyframe.frame, seen.feature as usize, &keyframe.cam_from_world),
            (frame, feature, cam_from_world),
            &point.position,
        )?;
        let zoom = (warp[0][0] * warp[1][1] - warp[0][1] * warp[1][0]).abs().sqrt();
        (zoom < MAX_ZOOM && zoom > 1.0 / MAX_ZOOM).then(|| (seen, warp.map(|row| row.map(|v| v as f32))))
    })
}

/// Steps on the level of a feature in one view as steps on that of its match in another, for a surface that faces the first.
fn warp(
    (from, i, from_world): (&Frame, usize, &SE3),
    (to, j, to_world): (&Frame, usize, &SE3),
    position: &Vec3,
) -> Option<[[f64; 2]; 2]> {
    let scale =
        |frame: &Frame, i: usize| f64::from(frame.scales.scales[usize::from(frame.keypoints[i].octave)]);
    let (step, unit) = (scale(from, i), scale(to, j));
    let point_cam = *from_world * position;
    let to_from = *to_world * from_world.inverse();
    let camera = &from.rig.stereo.camera;
    let place = |moved: Vec3| {
        let seen = to_from * moved;
        (seen.z > 0.0).then(|| to.rig.stereo.camera.project(&seen))
    };
    if point_cam.z <= 0.0 {
        return None;
    }
    let here = place(point_cam)?;
    let along = |dx: f64, dy: f64| -> Option<Vec2> {
        let aside = Vec3::new(dx * step * point_cam.z / camera.fx, dy * step * point_cam.z / camera.fy, 0.0);
        Some((place(point_cam + aside)? - here) / unit)
    };
    let (x, y) = (along(1.0, 0.0)?, along(0.0, 1.0)?);
    Some([[x.x, y.x], [x.y, y.y]])
}

#[cfg(test)]
#[path = "../../tests/steps/align.rs"]
mod tests;
