//! Bundle adjustment problems made from a map, with the ids of their unknowns.

use std::collections::BTreeMap;

use features::Frame;
use map::{KeyframeId, Map, PointId};
use optim::{BundleObservation, BundleProblem};

use crate::noise::{Noise, information};

/// A bundle adjustment problem and what its cameras and points are in the map.
#[derive(Clone, Debug)]
pub(crate) struct MapProblem {
    pub(crate) problem: BundleProblem,
    /// The keyframe of each camera.
    pub(crate) keyframes: Vec<KeyframeId>,
    /// The map point of each point.
    pub(crate) points: Vec<PointId>,
}

impl MapProblem {
    /// All observations of the `points`. Cameras are the given `keyframes` and behind them, fixed, whoever else
    /// observes a point; of the given ones those are fixed that `is_fixed` names. `None` without a keyframe.
    pub(crate) fn new(
        map: &Map,
        mut keyframes: Vec<KeyframeId>,
        mut points: Vec<PointId>,
        noise: Noise,
        is_fixed: impl Fn(KeyframeId) -> bool,
    ) -> Option<Self> {
        keyframes.retain(|&id| map.keyframe(id).is_some());
        points.retain(|&id| map.point(id).is_some());
        let rig = map.keyframe(*keyframes.first()?)?.frame.rig.stereo;
        let mut fixed: Vec<bool> = keyframes.iter().map(|&id| is_fixed(id)).collect();
        let mut index: BTreeMap<KeyframeId, u32> = keyframes.iter().copied().zip(0..).collect();
        let mut observations = Vec::new();
        for (number, point) in (0..).zip(points.iter().filter_map(|&id| map.point(id))) {
            for seen in point.observations() {
                let Some(observer) = map.keyframe(seen.keyframe) else { continue };
                let camera = *index.entry(seen.keyframe).or_insert_with(|| {
                    keyframes.push(seen.keyframe);
                    fixed.push(true);
                    keyframes.len() as u32 - 1
                });
                observations.push(observation(&observer.frame, seen.feature, camera, number, noise));
            }
        }
        let poses = keyframes.iter().filter_map(|&id| map.keyframe(id)).map(|kf| kf.cam_from_world);
        let positions = points.iter().filter_map(|&id| map.point(id)).map(|point| point.position);
        let (cameras, positions) = (poses.collect(), positions.collect());
        let problem = BundleProblem { rig, cameras, fixed, points: positions, observations };
        Some(MapProblem { problem, keyframes, points })
    }
}

/// What a feature of a camera's frame says of a point.
pub(crate) fn observation(
    frame: &Frame,
    feature: u32,
    camera: u32,
    point: u32,
    noise: Noise,
) -> BundleObservation {
    let feature = feature as usize;
    BundleObservation {
        camera,
        point,
        pixel: frame.pixel(feature),
        right_u: f64::from(frame.right_u[feature]),
        inv_sigma_sq: information(frame, feature, noise),
    }
}

#[cfg(test)]
#[path = "../tests/steps/problem.rs"]
mod tests;
