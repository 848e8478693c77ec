//! Local bundle adjustment: the new keyframe and its covisible ones move, other observers of their points stay fixed.

use std::collections::BTreeMap;

use geometry::{SE3, StereoRig, Vec3};
use map::{KeyframeId, PointId};
use optim::{
    BundleObservation, BundleOptions, BundleProblem, BundleSolution, CHI2_MONO, CHI2_STEREO, refine_bundle,
};

use super::Mapper;
use crate::noise::information;

/// What the adjustment moved.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Adjusted {
    pub(super) keyframes: usize,
    pub(super) points: usize,
    pub(super) outliers: usize,
}

/// A bundle problem with the ids of its unknowns.
struct LocalProblem {
    problem: BundleProblem,
    keyframes: Vec<KeyframeId>,
    points: Vec<PointId>,
}

impl Mapper {
    /// Optimises around `keyframe`: robustly, then without the outliers; outlier observations are unlinked.
    pub(super) fn adjust(&mut self, keyframe: KeyframeId) -> Adjusted {
        if self.world.map.n_keyframes() < 2 {
            return Adjusted::default();
        }
        let Some(local) = self.local_problem(keyframe) else { return Adjusted::default() };
        let mapping = &self.params.mapping;
        let robust =
            BundleOptions { max_iterations: mapping.first_iterations, robust: true, ..Default::default() };
        let first = refine_bundle(&local.problem, &robust);
        let mut inliers = local.problem.clone();
        inliers.cameras.clone_from(&first.cameras);
        inliers.points.clone_from(&first.points);
        let bad = outliers(&local.problem, &first);
        let mut at = 0;
        inliers.observations.retain(|_| {
            at += 1;
            !bad[at - 1]
        });
        let plain =
            BundleOptions { max_iterations: mapping.second_iterations, robust: false, ..Default::default() };
        let second = refine_bundle(&inliers, &plain);
        self.write_back(&local, &second)
    }

    /// The unknowns and observations around a keyframe.
    fn local_problem(&self, keyframe: KeyframeId) -> Option<LocalProblem> {
        let mapping = &self.params.mapping;
        let center = self.world.map.keyframe(keyframe)?;
        let mut free = vec![keyframe];
        free.extend(center.covisible_at_least(mapping.min_covisible_weight).iter().map(|&(id, _)| id));
        free.truncate(mapping.max_local_keyframes);
        let mut points: Vec<PointId> = free
            .iter()
            .filter_map(|&id| self.world.map.keyframe(id))
            .flat_map(|kf| kf.points().iter().flatten().copied())
            .collect();
        points.sort_unstable();
        points.dedup();
        let mut index: BTreeMap<KeyframeId, u32> = BTreeMap::new();
        let mut keyframes = Vec::new();
        for &id in &free {
            index.insert(id, keyframes.len() as u32);
            keyframes.push(id);
        }
        let mut observations = Vec::new();
        for (point_index, point) in points.iter().filter_map(|&id| self.world.map.point(id)).enumerate() {
            for observation in point.observations() {
                let Some(observer) = self.world.map.keyframe(observation.keyframe) else { continue };
                let camera = *index.entry(observation.keyframe).or_insert_with(|| {
                    keyframes.push(observation.keyframe);
                    keyframes.len() as u32 - 1
                });
                let feature = observation.feature as usize;
                observations.push(BundleObservation {
                    camera,
                    point: point_index as u32,
                    pixel: observer.frame.pixel(feature),
                    right_u: f64::from(observer.frame.right_u[feature]),
                    inv_sigma_sq: information(&observer.frame, feature, self.params.noise()),
                });
            }
        }
        let roots = self.world.map.roots();
        let mut fixed: Vec<bool> =
            keyframes.iter().enumerate().map(|(i, &id)| i >= free.len() || roots.contains(&id)).collect();
        if !fixed.contains(&true) {
            // Nothing ties the problem to the world: the oldest keyframe does.
            let oldest = (0..keyframes.len()).min_by_key(|&i| keyframes[i])?;
            fixed[oldest] = true;
        }
        let rig: StereoRig = center.frame.rig.stereo;
        let cameras = keyframes
            .iter()
            .filter_map(|&id| self.world.map.keyframe(id))
            .map(|kf| kf.cam_from_world)
            .collect();
        let positions =
            points.iter().filter_map(|&id| self.world.map.point(id)).map(|p| p.position).collect();
        let problem = BundleProblem { rig, cameras, fixed, points: positions, observations };
        Some(LocalProblem { problem, keyframes, points })
    }

    /// Writes the solution into the map and unlinks the observations that do not agree with it.
    fn write_back(&mut self, local: &LocalProblem, solution: &BundleSolution) -> Adjusted {
        let moved: Vec<(KeyframeId, SE3)> = (0..local.keyframes.len())
            .filter(|&i| !local.problem.fixed[i])
            .map(|i| (local.keyframes[i], solution.cameras[i].normalized()))
            .collect();
        let positions: Vec<(PointId, Vec3)> =
            local.points.iter().copied().zip(solution.points.iter().copied()).collect();
        if self.world.map.set_estimates(&moved, &positions).is_err() {
            return Adjusted::default();
        }
        let mut outliers = 0;
        for observation in &local.problem.observations {
            let camera = &solution.cameras[observation.camera as usize];
            let point = &solution.points[observation.point as usize];
            if disagrees(&local.problem.rig, camera, point, observation) {
                let point = local.points[observation.point as usize];
                let keyframe = local.keyframes[observation.camera as usize];
                outliers += usize::from(self.world.map.unlink(point, keyframe).is_ok());
            }
        }
        Adjusted { keyframes: moved.len(), points: positions.len(), outliers }
    }
}

/// Observations whose error is beyond the chi-square limit, or whose point is behind the camera.
fn outliers(problem: &BundleProblem, solution: &BundleSolution) -> Vec<bool> {
    problem
        .observations
        .iter()
        .map(|o| {
            disagrees(
                &problem.rig,
                &solution.cameras[o.camera as usize],
                &solution.points[o.point as usize],
                o,
            )
        })
        .collect()
}

fn disagrees(rig: &StereoRig, cam_from_world: &SE3, point: &Vec3, observation: &BundleObservation) -> bool {
    let point_cam = *cam_from_world * *point;
    if point_cam.z <= 0.0 {
        return true;
    }
    let uvr = rig.project(&point_cam);
    let (du, dv) = (uvr.x - observation.pixel.x, uvr.y - observation.pixel.y);
    let (error_sq, limit) = if observation.right_u.is_nan() {
        (du * du + dv * dv, CHI2_MONO)
    } else {
        let dr = uvr.z - observation.right_u;
        (du * du + dv * dv + dr * dr, CHI2_STEREO)
    };
    error_sq * observation.inv_sigma_sq > limit
}
