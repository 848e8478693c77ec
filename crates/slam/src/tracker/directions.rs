//! The rotation between two frames from the directions of their features, where the camera turned and did not move.

use features::{Frame, ProjectionQuery, WindowMatch};
use geometry::{Estimator, Mat3, RansacOptions, SE3, SO3, Vec3, ransac};
use optim::CHI2_MONO;

use crate::noise::{Noise, information};
use crate::params::Params;
use crate::search::{consistent_in_rotation, search};
use crate::visibility::project_inside;

/// Largest descriptor distance of a match, and largest ratio of the best to the second-best one.
const MAX_DISTANCE: u32 = 64;
const MAX_RATIO: f32 = 0.9;
/// Directions that a rotation follows from.
const SAMPLE_SIZE: usize = 2;
const MAX_SAMPLES: usize = 200;

/// A rotation, and what speaks for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenRotation {
    pub(super) now_from_then: SO3,
    /// Matches that agree with it.
    pub(super) inliers: usize,
    /// All matches.
    pub(super) matches: usize,
}

/// Looks for the features of `then` where a predicted rotation puts them, within `radius_px` at octave 0, and finds the rotation that
/// most of them agree with; `None` without one.
pub(super) fn rotation_between(
    then: &Frame,
    now: &Frame,
    predicted: &SO3,
    radius_px: f32,
    params: &Params,
) -> Option<SeenRotation> {
    let matches = match_turned(then, now, predicted, radius_px);
    let noise = Noise { sigma_px: params.camera.feature_sigma_px, weighted: false };
    let estimator = RotationEstimator {
        now,
        pairs: matches
            .iter()
            .map(|&(in_now, in_then)| Pair {
                then: direction(then, in_then),
                now: direction(now, in_now),
                feature: in_now as usize,
                variance: 1.0 / information(then, in_then as usize, noise)
                    + 1.0 / information(now, in_now as usize, noise),
            })
            .collect(),
    };
    let seed = crate::seed::SeedPurpose::Turning.seed(params.seed, now.index, then.index);
    let options =
        RansacOptions { sample_size: SAMPLE_SIZE, max_iterations: MAX_SAMPLES, confidence: 0.999, seed };
    let found = ransac(&estimator, None, &options)?;
    Some(SeenRotation {
        now_from_then: found.model.orthonormalized(),
        inliers: found.inliers.len(),
        matches: matches.len(),
    })
}

/// Unit vector to a feature.
fn direction(frame: &Frame, feature: u32) -> Vec3 {
    frame.rig.stereo.camera.unproject(&frame.pixel(feature as usize)).normalize()
}

/// Matches `(feature of now, feature of then)`.
fn match_turned(then: &Frame, now: &Frame, predicted: &SO3, radius_px: f32) -> Vec<(u32, u32)> {
    let turn = SE3::new(*predicted, Vec3::zeros());
    let top = (now.scales.scales.len() - 1) as u8;
    let asked = (0..then.len() as u32).filter_map(|i| {
        let seen = project_inside(now, &turn, &direction(then, i))?;
        let keypoint = &then.keypoints[i as usize];
        let query = ProjectionQuery {
            x: seen.x as f32,
            y: seen.y as f32,
            right_u: f32::NAN,
            radius_px: radius_px * now.scales.scales[usize::from(keypoint.octave)],
            min_octave: keypoint.octave.saturating_sub(1),
            max_octave: (keypoint.octave + 1).min(top),
            descriptor: then.descriptors[i as usize],
        };
        Some((i, query))
    });
    let accept = |_, find: &WindowMatch| {
        find.best.distance <= MAX_DISTANCE
            && find.second.is_none_or(|s| (find.best.distance as f32) < MAX_RATIO * s.distance as f32)
    };
    let matches = search(now, asked, &vec![true; now.len()], accept);
    consistent_in_rotation(now, matches, |&i| then.keypoints[i as usize].angle_deg)
}

/// A feature seen in both frames.
struct Pair {
    /// Unit vectors.
    then: Vec3,
    now: Vec3,
    /// Feature of the present frame.
    feature: usize,
    /// Variance of each coordinate of the difference, square pixels.
    variance: f64,
}

/// Nearest rotations (Horn, Hilden, Negahdaripour 1988).
struct RotationEstimator<'a> {
    now: &'a Frame,
    pairs: Vec<Pair>,
}

impl Estimator for RotationEstimator<'_> {
    type Model = SO3;

    fn n_items(&self) -> usize {
        self.pairs.len()
    }

    fn fit(&self, sample: &[usize]) -> Vec<SO3> {
        let [a, b] = sample else { return Vec::new() };
        let (a, b) = (&self.pairs[*a], &self.pairs[*b]);
        let (across_then, across_now) = (a.then.cross(&b.then), a.now.cross(&b.now));
        let (Some(across_then), Some(across_now)) =
            (across_then.try_normalize(1e-3), across_now.try_normalize(1e-3))
        else {
            return Vec::new();
        };
        let sum = a.now * a.then.transpose() + b.now * b.then.transpose();
        vec![SO3::from_matrix(&(sum + across_now * across_then.transpose()))]
    }

    fn error_sq(&self, now_from_then: &SO3, item: usize) -> f64 {
        let pair = &self.pairs[item];
        let turned = *now_from_then * pair.then;
        if turned.z <= 0.0 {
            return f64::INFINITY;
        }
        let seen = self.now.rig.stereo.camera.project(&turned);
        (seen - self.now.pixel(pair.feature)).norm_squared() / pair.variance
    }

    fn threshold_sq(&self) -> f64 {
        CHI2_MONO
    }

    fn refit(&self, _: &SO3, inliers: &[usize], weights: &[f64]) -> Option<SO3> {
        let product = |&i: &usize| {
            let pair = &self.pairs[i];
            pair.now * pair.then.transpose() * (weights[i] / pair.variance)
        };
        (inliers.len() > SAMPLE_SIZE).then(|| SO3::from_matrix(&inliers.iter().map(product).sum::<Mat3>()))
    }
}

#[cfg(test)]
#[path = "../../tests/steps/directions.rs"]
mod tests;
