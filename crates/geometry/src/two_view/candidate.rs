//! A motion on trial: which matches agree with it, and where their points are.

use super::models::Chosen;
use super::{CHI2_PIXEL, TwoView, Views};
use crate::aliases::{Vec2, Vec3};
use crate::se3::SE3;
use crate::triangulate::{angle_between, triangulate_dlt};

/// What the matches say of a motion; numbers count matches with a weight.
pub(super) struct Candidate {
    pub(super) motion: SE3,
    points: Vec<Option<Vec3>>,
    pub(super) n_points: usize,
    pub(super) n_consistent: usize,
    /// Parallax that `min_points` consistent matches reach, 0 when there are fewer.
    pub(super) parallax_deg: f64,
}

/// What a match says.
enum Verdict {
    /// Errors too large, or the point lies behind a camera.
    Wrong,
    /// Agrees, but has too little parallax for a point.
    Far,
    /// Agrees and gives a point in the first camera.
    Point(Vec3),
}

impl Candidate {
    pub(super) fn new(views: &Views<'_>, motion: SE3) -> Self {
        let mut candidate =
            Self { motion, points: Vec::new(), n_points: 0, n_consistent: 0, parallax_deg: 0.0 };
        let mut parallaxes_deg = Vec::new();
        for i in 0..views.len() {
            let (first, second) = views.rays(i);
            let parallax_deg = angle_between(&(motion.rotation * first), &second).to_degrees();
            let verdict = verdict(views, &motion, i, parallax_deg);
            let has_weight = views.weights[i] > 0.0;
            if has_weight && !matches!(verdict, Verdict::Wrong) {
                candidate.n_consistent += 1;
                parallaxes_deg.push(parallax_deg);
            }
            let point = if let Verdict::Point(point) = verdict { Some(point) } else { None };
            candidate.n_points += usize::from(has_weight && point.is_some());
            candidate.points.push(point);
        }
        parallaxes_deg.sort_by(|a, b| b.total_cmp(a));
        let rank = views.options().min_points.max(1) - 1;
        candidate.parallax_deg = parallaxes_deg.get(rank).copied().unwrap_or(0.0);
        candidate
    }

    pub(super) fn to_two_view(&self, chosen: &Chosen, n_second: usize) -> TwoView {
        let mut depths: Vec<f64> = self.points.iter().flatten().map(|point| point.z).collect();
        depths.sort_by(f64::total_cmp);
        TwoView {
            second_from_first: self.motion,
            points: self.points.clone(),
            model: chosen.model,
            homography_share: chosen.homography_share,
            n_inliers: chosen.n_inliers,
            n_consistent: self.n_consistent,
            n_points: self.n_points,
            n_second,
            parallax_deg: self.parallax_deg,
            median_depth: depths.get(depths.len() / 2).copied().unwrap_or(0.0),
        }
    }
}

/// Whether two motions with translations of length one are the same solution found twice.
pub(super) fn same_motion(a: &SE3, b: &SE3) -> bool {
    /// Radians; two solutions of one plane that lie closer are as good as one.
    const MAX_TURN: f64 = 0.01;
    /// Radians.
    const MAX_DIRECTION: f64 = 0.1;
    let turn = (a.rotation * b.rotation.inverse()).angle();
    turn < MAX_TURN && angle_between(&a.translation, &b.translation) < MAX_DIRECTION
}

fn verdict(views: &Views<'_>, motion: &SE3, i: usize, parallax_deg: f64) -> Verdict {
    let (first, second) = (&views.reconstruction.first, &views.reconstruction.second);
    let (pixel_a, pixel_b) = views.pixels(i);
    let (ray_a, ray_b) = views.rays(i);
    let limit_sq = CHI2_PIXEL * views.variance();
    let fits = |place: Vec2, pixel: &Vec2| (place - pixel).norm_squared() <= limit_sq;
    let is_far = parallax_deg < views.options().min_point_parallax_deg;
    let Some(point) = triangulate_dlt(&[SE3::identity(), *motion], &[ray_a.xy(), ray_b.xy()]) else {
        // At infinity, where the pixel of the other view follows from the turn alone.
        let turned = motion.rotation * ray_a;
        let agrees = turned.z > 0.0 && fits(second.project(&turned), pixel_b);
        return if agrees { Verdict::Far } else { Verdict::Wrong };
    };
    let in_second = motion * point;
    if !(fits(first.project(&point), pixel_a) && fits(second.project(&in_second), pixel_b)) {
        return Verdict::Wrong;
    }
    match (is_far, point.z > 0.0 && in_second.z > 0.0) {
        // On which side a far point lies is decided by noise.
        (true, _) => Verdict::Far,
        (false, true) => Verdict::Point(point),
        (false, false) => Verdict::Wrong,
    }
}
