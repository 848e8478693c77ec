//! What a frame says of the points that it should see: does each stand still? The network's word, and whether the point is where it
//! would be if it stood, against how far it would have gone if it moved.

use features::Frame;
use geometry::{SE3, Vec3};
use map::{Map, PointId};

use super::local_map::LocallyTracked;
use crate::noise::{Noise, information};

/// Speed of a slow mover, m/s: somebody who walks. Faster ones move about as fast as the camera.
const WALKING_M_S: f64 = 1.4;
/// Most that one sight says for and against standing still, log-odds. Sights of neighboring frames are not independent.
const MOST_FOR: f64 = 0.5;
const MOST_AGAINST: f64 = 2.0;
/// Largest log-odds of a network's word in either direction, and what share of it counts: it repeats itself.
const MOST_OF_WORD: f64 = 2.0;
const SHARE_OF_WORD: f64 = 0.4;

/// Standard deviation of where a point that stands is seen against where it would be, in those of a feature: of both views together,
/// to which the error of the pose adds, and of one view against the other, which hardly feels it and which are matched to a fraction
/// of a pixel. Chosen among 1, 1.5, 2, 3 and 0.2 to 2 on the rendered street busy 932, with a look at KITTI raw 0005 and trams 83.
const COMMON_SIGMAS: f64 = 2.0;
const DISPARITY_SIGMAS: f64 = 0.4;

/// How a mover would have gone since the last frame, in coordinates of the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Yardstick(Vec3);

impl Yardstick {
    /// As far as the camera and in its direction; with a scale in meters at least as far as a walker, ahead if the camera stands.
    pub(super) fn new(cam_from_world: &SE3, last_from_world: &SE3, seconds: f64, is_metric: bool) -> Self {
        let step_world = cam_from_world.center() - last_from_world.center();
        let least = if is_metric { WALKING_M_S * seconds.max(0.0) } else { 0.0 };
        let step = cam_from_world.rotation * step_world;
        match step.try_normalize(0.1 * least.max(f64::MIN_POSITIVE)) {
            Some(direction) => Yardstick(direction * step.norm().max(least)),
            None => Yardstick(Vec3::z() * least),
        }
    }
}

/// Adds what a tracked frame says to its counts. A point that should be seen and is not says nothing: on real streets those that stand
/// are missed as often as those that move.
pub(super) fn add_evidence(
    local: &mut LocallyTracked,
    frame: &Frame,
    map: &Map,
    yardstick: Yardstick,
    sigma_px: f64,
) {
    let LocallyTracked { counts, cam_from_world, matched, .. } = local;
    let mut features: Vec<(PointId, u32)> =
        matched.iter().map(|&(feature, point)| (point, feature)).collect();
    features.sort_unstable();
    for count in counts {
        let Some(point) = map.point(count.point) else { continue };
        let point_cam = *cam_from_world * point.position;
        let at = features.binary_search_by_key(&count.point, |&(point, _)| point);
        let feature = at.ok().map(|at| features[at].1 as usize);
        let says = feature
            .map_or(0.0, |i| sight(frame, i, &point_cam, yardstick, sigma_px) + word(frame.activation[i]));
        count.evidence = (1000.0 * says) as i32;
    }
}

/// Log-odds of a network's word.
fn word(activation: f32) -> f64 {
    let a = f64::from(activation).clamp(1e-3, 1.0 - 1e-3);
    SHARE_OF_WORD * (a / (1.0 - a)).ln().clamp(-MOST_OF_WORD, MOST_OF_WORD)
}

/// Log-likelihood ratio of standing still against moving for a feature that shows a point: the residuals have the feature's variance if
/// it stands, and that of its motion besides if it moves.
fn sight(frame: &Frame, i: usize, point_cam: &Vec3, yardstick: Yardstick, sigma_px: f64) -> f64 {
    if point_cam.z <= 0.0 {
        return 0.0;
    }
    let uvr = frame.rig.stereo.project(point_cam);
    let (pixel, right_u) = (frame.pixel(i), f64::from(frame.right_u[i]));
    let has_right = !right_u.is_nan();
    let dimensions = if has_right { 3.0 } else { 2.0 };
    let error = Vec3::new(pixel.x, pixel.y, right_u) - uvr;
    let chi_sq = in_sigmas_sq(error, has_right) * information(frame, i, Noise { sigma_px, weighted: false });
    let moved_sq = would_have_moved_sq(frame, i, point_cam, yardstick, sigma_px) / dimensions;
    let ratio = 0.5 * (dimensions * (1.0 + moved_sq).ln() - chi_sq * visibility(moved_sq));
    ratio.clamp(-MOST_AGAINST, MOST_FOR)
}

/// Squared motion in the image over the variance of a feature, all measured dimensions added up.
fn would_have_moved_sq(
    frame: &Frame,
    i: usize,
    point_cam: &Vec3,
    Yardstick(step): Yardstick,
    sigma_px: f64,
) -> f64 {
    let moved_cam = point_cam + step;
    if point_cam.z <= 0.0 || moved_cam.z <= 0.0 {
        return 0.0;
    }
    let stereo = &frame.rig.stereo;
    let moved = stereo.project(&moved_cam) - stereo.project(point_cam);
    in_sigmas_sq(moved, frame.has_depth(i)) * information(frame, i, Noise { sigma_px, weighted: false })
}

/// Square of a shift in the image (left column, row, right column), px, in units of what it may be for a point that stands. Without a
/// right column it is that of the left one.
fn in_sigmas_sq(shift: Vec3, has_right: bool) -> f64 {
    let (column, disparity) =
        if has_right { (0.5 * (shift.x + shift.z), shift.x - shift.z) } else { (shift.x, 0.0) };
    (column.powi(2) + shift.y.powi(2)) / COMMON_SIGMAS.powi(2) + (disparity / DISPARITY_SIGMAS).powi(2)
}

/// How well a motion could be seen: 0 for one far below the noise, 1 for one far above.
fn visibility(moved_sq: f64) -> f64 {
    moved_sq / (1.0 + moved_sq)
}

#[cfg(test)]
#[path = "../../tests/steps/evidence.rs"]
mod tests;
