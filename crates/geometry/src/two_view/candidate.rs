//! A motion on trial: which matches agree with it, and where their points are.

use super::models::Suggestion;
use super::refine::{Refined, refine_motion};
use super::{CHI2_LINE, CHI2_PIXEL, TwoViewModel, Views};
use crate::aliases::Vec3;
use crate::se3::SE3;
use crate::triangulate::{angle_between, triangulate_dlt};

/// What the matches say of a motion; numbers count matches with a weight.
pub(super) struct Candidate {
    pub(super) model: TwoViewModel,
    pub(super) motion: SE3,
    /// Sum of the gains.
    pub(super) score: f64,
    pub(super) direction_sigma_deg: f64,
    pub(super) points: Vec<Option<Vec3>>,
    /// For each match what its errors leave of their limit, weighted; zero for those that do not agree.
    gains: Vec<f64>,
    pub(super) n_points: usize,
    pub(super) n_consistent: usize,
    /// Parallax that `min_points` consistent matches reach, 0 when there are fewer.
    pub(super) parallax_deg: f64,
}

/// What a match says of a motion.
enum Verdict {
    /// Errors too large, or the point lies behind a camera.
    Wrong,
    /// Agrees with this squared error, square pixels in both images together, but has too little parallax for a point.
    Far { error_sq: f64 },
    /// Agrees and gives a point in the first camera.
    Point { error_sq: f64, point: Vec3 },
}

impl Candidate {
    /// Refines the suggested motion and hears all matches.
    pub(super) fn new(views: &Views<'_>, suggestion: &Suggestion) -> Self {
        let Refined { motion, direction_sigma_deg } = refine_motion(views, &suggestion.motion);
        let mut candidate = Self {
            model: suggestion.model,
            motion,
            score: 0.0,
            direction_sigma_deg,
            points: Vec::with_capacity(views.len()),
            gains: vec![0.0; views.len()],
            n_points: 0,
            n_consistent: 0,
            parallax_deg: 0.0,
        };
        let mut parallaxes_deg = Vec::new();
        for i in 0..views.len() {
            let (first, second) = views.rays(i);
            let parallax_deg = angle_between(&(motion.rotation * first), &second).to_degrees();
            let (error_sq, point) = match verdict(views, &motion, i, parallax_deg) {
                Verdict::Wrong => (None, None),
                Verdict::Far { error_sq } => (Some(error_sq), None),
                Verdict::Point { error_sq, point } => (Some(error_sq), Some(point)),
            };
            candidate.points.push(point);
            let weight = views.weights[i];
            if let (Some(error_sq), true) = (error_sq, weight > 0.0) {
                candidate.gains[i] = weight * (CHI2_LINE - error_sq / views.variance()).max(0.0);
                candidate.score += candidate.gains[i];
                candidate.n_consistent += 1;
                candidate.n_points += usize::from(point.is_some());
                parallaxes_deg.push(parallax_deg);
            }
        }
        parallaxes_deg.sort_by(|a, b| b.total_cmp(a));
        let rank = views.options().min_points.max(1) - 1;
        candidate.parallax_deg = parallaxes_deg.get(rank).copied().unwrap_or(0.0);
        candidate
    }

    /// How much of what this motion gains by its points another one gains by the same matches, from 0 to about 1. Far points
    /// agree with many motions and are skipped.
    pub(super) fn share_of(&self, other: &Self) -> f64 {
        let with_point = || (0..self.points.len()).filter(|&i| self.points[i].is_some());
        let (own, others) = (
            with_point().map(|i| self.gains[i]).sum::<f64>(),
            with_point().map(|i| other.gains[i]).sum::<f64>(),
        );
        if own > 0.0 { others / own } else { 1.0 }
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
    let is_far = parallax_deg < views.options().min_point_parallax_deg;
    let Some(point) = triangulate_dlt(&[SE3::identity(), *motion], &[ray_a.xy(), ray_b.xy()]) else {
        // At infinity, where the pixel of the other view follows from the turn alone.
        let turned = motion.rotation * ray_a;
        let error_sq = (second.project(&turned) - pixel_b).norm_squared();
        let agrees = turned.z > 0.0 && error_sq <= limit_sq;
        return if agrees { Verdict::Far { error_sq } } else { Verdict::Wrong };
    };
    let in_second = motion * point;
    let errors_sq = [
        (first.project(&point) - pixel_a).norm_squared(),
        (second.project(&in_second) - pixel_b).norm_squared(),
    ];
    if !errors_sq.iter().all(|&error_sq| error_sq <= limit_sq) {
        return Verdict::Wrong;
    }
    let error_sq = errors_sq[0] + errors_sq[1];
    match (is_far, point.z > 0.0 && in_second.z > 0.0) {
        // On which side a far point lies is decided by noise.
        (true, _) => Verdict::Far { error_sq },
        (false, true) => Verdict::Point { error_sq, point },
        (false, false) => Verdict::Wrong,
    }
}
