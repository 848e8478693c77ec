//! Global bundle adjustment: every keyframe and point of a snapshot.

use std::collections::BTreeMap;

use map::{Correction, KeyframeCorrection, KeyframeId, Map, PointId};
use optim::{BundleObservation, BundleOptions, BundleProblem, refine_bundle};

use crate::noise::information;
use crate::params::Params;
use crate::probe::{Probe, Stage, staged};
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
    let rig = map.keyframes().next()?.frame.rig.stereo;
    let keyframes: Vec<KeyframeId> = map.keyframes().map(|kf| kf.id).collect();
    let index: BTreeMap<KeyframeId, u32> = keyframes.iter().copied().zip(0..).collect();
    let points: Vec<PointId> = map.points().filter(|p| p.observations().len() > 1).map(|p| p.id).collect();
    let mut observations = Vec::new();
    for (number, point) in (0..).zip(points.iter().filter_map(|&id| map.point(id))) {
        for observation in point.observations() {
            let Some(observer) = map.keyframe(observation.keyframe) else { continue };
            let feature = observation.feature as usize;
            observations.push(BundleObservation {
                camera: index[&observation.keyframe],
                point: number,
                pixel: observer.frame.pixel(feature),
                right_u: f64::from(observer.frame.right_u[feature]),
                inv_sigma_sq: information(&observer.frame, feature, params.noise()),
            });
        }
    }
    let problem = BundleProblem {
        rig,
        cameras: map.keyframes().map(|kf| kf.cam_from_world).collect(),
        fixed: keyframes.iter().map(|id| map.roots().contains(id)).collect(),
        points: points.iter().filter_map(|&id| map.point(id)).map(|p| p.position).collect(),
        observations,
    };
    if problem.observations.is_empty() || problem.fixed.iter().all(|&fixed| fixed) {
        return None;
    }
    let options =
        BundleOptions { max_iterations: params.loops.global_iterations, robust: true, ..Default::default() };
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
