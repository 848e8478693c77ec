//! Before a loop may move anything it must agree with the path between its visits and with the loops closed earlier.

use geometry::SE3;
use map::{KeyframeId, Map};
use optim::loop_test::{CycleEdge, CycleEdgeKind, DriftModel, LoopVerdict, test_loop};

use super::essential_graph::EssentialGraph;
use crate::params::{CameraParams, Params};

/// Standard deviations that even the shortest motion has.
const SIGMA_M: f64 = 0.01;
const SIGMA_RAD: f64 = 1e-3;
/// Drift of the rotation, radians per meter of path and per radian turned: three times what stereo odometry shows.
const SIGMA_RAD_PER_M: f64 = 5e-5;
const SIGMA_RAD_PER_RAD: f64 = 5e-3;
/// Standard deviations of the loop's own motion.
const LOOP_SIGMA_M: f64 = 0.1;
const LOOP_SIGMA_RAD: f64 = 5e-3;

/// Tests the motion `here_from_there` against spanning tree and loop edges; `None` if the graph lacks one of the ends.
pub(super) fn test(
    graph: &EssentialGraph,
    map: &Map,
    here: KeyframeId,
    there: KeyframeId,
    here_from_there: &SE3,
    params: &Params,
) -> Option<LoopVerdict> {
    let (here, there) = (graph.index(here)?, graph.index(there)?);
    let drift = drift_model(&params.camera);
    let growth = (path_length(graph, map, here, there) as f64).sqrt();
    let mut edges = Vec::with_capacity(graph.nodes.len());
    for (child, &id) in graph.nodes.iter().enumerate() {
        let parent = map.keyframe(id).and_then(map::Keyframe::parent).and_then(|id| graph.index(id));
        let Some(parent) = parent else { continue };
        let motion = graph.cam_from_world[child] * graph.cam_from_world[parent].inverse();
        edges.push(drift.edge(parent as u32, child as u32, motion, growth));
    }
    edges.extend(graph.edges.iter().filter(|e| e.is_loop).map(|e| CycleEdge {
        kind: CycleEdgeKind::EarlierLoop,
        ..candidate(e.a, e.b, graph.b_from_a(e), params.camera.unit)
    }));
    edges.push(candidate(there, here, *here_from_there, params.camera.unit));
    Some(test_loop(&graph.cam_from_world, &edges))
}

/// Edges on the way through the spanning tree from one node to another.
fn path_length(graph: &EssentialGraph, map: &Map, here: usize, there: usize) -> usize {
    let (a, b) = (graph.ancestors(map, here), graph.ancestors(map, there));
    let shared = a.iter().rev().zip(b.iter().rev()).take_while(|(x, y)| x == y).count();
    a.len() + b.len() - 2 * shared
}

/// How the path of a camera drifts; the map gives a meter the length `unit`.
pub(super) fn drift_model(camera: &CameraParams) -> DriftModel {
    DriftModel {
        sigma_m: camera.unit * SIGMA_M,
        m_per_m: camera.drift_sigma,
        sigma_rad: SIGMA_RAD,
        rad_per_m: SIGMA_RAD_PER_M / camera.unit,
        rad_per_rad: SIGMA_RAD_PER_RAD,
        max_m_per_m: camera.max_drift,
        margin_m: camera.prior_margin_m,
    }
}

fn candidate(a: usize, b: usize, b_from_a: SE3, unit: f64) -> CycleEdge {
    CycleEdge {
        a: a as u32,
        b: b as u32,
        b_from_a,
        sigma_m: unit * LOOP_SIGMA_M,
        sigma_rad: LOOP_SIGMA_RAD,
        kind: CycleEdgeKind::Candidate,
    }
}

#[cfg(test)]
#[path = "../../tests/steps/cycle_test.rs"]
mod tests;
