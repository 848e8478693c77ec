//! Global bundle adjustment: every keyframe and point of a snapshot.

use map::{Correction, KeyframeCorrection, Map};
use optim::{BundleOptions, refine_bundle};

use crate::params::Params;
use crate::probe::{Probe, Stage, staged};
use crate::problem::MapProblem;
use crate::world::World;

/// A global bundle adjustment, computed on a snapshot.
#[derive(Clone, Debug)]
pub struct GlobalSolution {
    /// New poses and positions.
    pub correction: Correction,
    /// Robust cost before and after.
    pub cost: [f64; 2],
}

/// Adjusts all keyframes and points of a snapshot, the root of each sub-map fixed; `None` when there is nothing to adjust.
pub fn adjust_globally(world: &World, params: &Params, probe: &mut dyn Probe) -> Option<GlobalSolution> {
    staged(probe, Stage::GlobalBundle, || solve(&world.map, params))
}

fn solve(map: &Map, params: &Params) -> Option<GlobalSolution> {
    let keyframes = map.keyframes().map(|kf| kf.id).collect();
    let points = map.points().filter(|p| p.observations().len() > 1).map(|p| p.id).collect();
    let is_root = |id| map.roots().contains(&id);
    let MapProblem { problem, keyframes, points } =
        MapProblem::new(map, keyframes, points, params.noise(), is_root)?;
    if problem.observations.is_empty() || problem.fixed.iter().all(|&fixed| fixed) {
        return None;
    }
    let options = BundleOptions {
        max_iterations: params.loops.global_iterations,
        huber: Some(params.camera.huber),
        ..Default::default()
    };
    let solution = refine_bundle(&problem, &options);
    let moved = keyframes.iter().zip(&solution.cameras).zip(&problem.fixed).filter(|(_, fixed)| !**fixed);
    Some(GlobalSolution {
        correction: Correction {
            keyframes: moved
                .map(|((&id, pose), _)| KeyframeCorrection::rigid(id, pose.normalized()))
                .collect(),
            points: points.iter().copied().zip(solution.points.iter().copied()).collect(),
            seen_revision: map.revision(),
            ..Correction::default()
        },
        cost: [solution.report.initial_cost, solution.report.final_cost],
    })
}

#[cfg(test)]
#[path = "../../tests/steps/global.rs"]
mod tests;
