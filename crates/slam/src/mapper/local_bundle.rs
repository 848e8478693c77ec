//! Local bundle adjustment: the new keyframe and its covisible ones move, other observers of their points stay fixed.

use geometry::{SE3, Vec3};
use map::{KeyframeId, PointId};
use optim::{BundleOptions, BundleProblem, BundleSolution, refine_bundle};

use super::{Mapper, MappingReport};
use crate::problem::MapProblem;
use crate::search::points_of;

impl Mapper {
    /// Optimizes around `keyframe`: robustly, then without the outliers; outlier observations are unlinked.
    pub(super) fn adjust(&mut self, keyframe: KeyframeId) -> MappingReport {
        if self.world.map.n_keyframes() < 2 {
            return MappingReport::default();
        }
        let Some(local) = self.local_problem(keyframe) else { return MappingReport::default() };
        let (mapping, huber) = (&self.params.mapping, self.params.camera.huber);
        let options = |max_iterations, huber| BundleOptions { max_iterations, huber, ..Default::default() };
        let first = refine_bundle(&local.problem, &options(mapping.local_ba_first_iterations, Some(huber)));
        let agreeing = local.problem.observations.iter().zip(&first.inliers).filter(|(_, agrees)| **agrees);
        let inliers = BundleProblem {
            rig: local.problem.rig,
            cameras: first.cameras.clone(),
            fixed: local.problem.fixed.clone(),
            points: first.points.clone(),
            observations: agreeing.map(|(observation, _)| *observation).collect(),
        };
        let last = options(mapping.local_ba_second_iterations, (huber < 1.0).then_some(huber));
        let second = refine_bundle(&inliers, &last);
        self.write_back(&local, &second)
    }

    /// The unknowns and observations around a keyframe.
    fn local_problem(&self, keyframe: KeyframeId) -> Option<MapProblem> {
        let (map, mapping) = (&self.world.map, &self.params.mapping);
        let center = map.keyframe(keyframe)?;
        let mut free = vec![keyframe];
        free.extend(center.covisible_at_least(mapping.min_covisible_weight).iter().map(|&(id, _)| id));
        free.truncate(mapping.max_local_keyframes);
        let points = points_of(map, free.iter().copied());
        let is_root = |id| map.roots().contains(&id);
        let mut local = MapProblem::new(map, free, points, self.params.noise(), is_root)?;
        if !local.problem.fixed.contains(&true) {
            // Nothing ties the problem to the world: the oldest keyframe does.
            let oldest = (0..local.keyframes.len()).min_by_key(|&i| local.keyframes[i])?;
            local.problem.fixed[oldest] = true;
        }
        Some(local)
    }

    /// Writes the solution into the map and unlinks the observations that do not agree with it.
    fn write_back(&mut self, local: &MapProblem, solution: &BundleSolution) -> MappingReport {
        let moved: Vec<(KeyframeId, SE3)> = (0..local.keyframes.len())
            .filter(|&i| !local.problem.fixed[i])
            .map(|i| (local.keyframes[i], solution.cameras[i].normalized()))
            .collect();
        let positions: Vec<(PointId, Vec3)> =
            local.points.iter().copied().zip(solution.points.iter().copied()).collect();
        if self.world.map.set_estimates(&moved, &positions).is_err() {
            return MappingReport::default();
        }
        let mut outliers = 0;
        // Also those that the last adjustment left out: they may agree by now.
        let agrees = local.problem.inliers(&solution.cameras, &solution.points);
        for (observation, _) in local.problem.observations.iter().zip(agrees).filter(|(_, agrees)| !agrees) {
            let point = local.points[observation.point as usize];
            let keyframe = local.keyframes[observation.camera as usize];
            outliers += usize::from(self.world.map.unlink(point, keyframe).is_ok());
        }
        let (adjusted_keyframes, adjusted_points) = (moved.len(), positions.len());
        MappingReport { adjusted_keyframes, adjusted_points, outliers, ..MappingReport::default() }
    }
}

#[cfg(test)]
#[path = "../../tests/steps/local_bundle.rs"]
mod tests;
