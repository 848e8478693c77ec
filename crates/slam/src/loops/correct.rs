//! From a verified loop to the correction of the map: the test against the path between the visits, then the pose graph,
//! or the motion of a whole sub-map.

use geometry::{SE3, Sim3};
use map::{Correction, KeyframeCorrection, KeyframeId, Map};
use nalgebra::{SMatrix, SVector};
use optim::loop_test::{LoopVerdict, Witness};
use optim::{PoseGraphEdge, PoseGraphOptions, PoseGraphProblem, PoseGroup, refine_pose_graph};

use super::LoopCorrection;
use super::cycle_test;
use super::essential_graph::EssentialGraph;
use super::outcome::NoLoop;
use super::verify::Verified;
use crate::params::Params;

/// Changes of scale beyond this factor are not drift.
const MAX_SCALE: f64 = 3.0;
/// Standard deviations of the motion between neighboring keyframes: a constant part, and per meter or radian of it.
const SIGMA_M: f64 = 0.005;
const SIGMA_M_PER_M: f64 = 0.01;
const SIGMA_RAD: f64 = 5e-4;
const SIGMA_RAD_PER_M: f64 = 1e-4;
const SIGMA_RAD_PER_RAD: f64 = 0.01;
/// Standard deviation of the logarithm of the scale between neighboring keyframes.
const SIGMA_LOG_SCALE: f64 = 0.01;

/// The correction that a verified loop asks for; a witness that was not closed is taken for one of the earlier loops.
///
/// # Errors
/// When the loop contradicts the path between the visits or earlier loops.
pub(super) fn correct(
    keyframe: KeyframeId,
    verified: &Verified,
    map: &Map,
    params: &Params,
    witness: Option<&Witness<SE3>>,
) -> Result<LoopCorrection, NoLoop> {
    let scale = verified.scale;
    if !(scale.is_finite() && scale < MAX_SCALE && scale > 1.0 / MAX_SCALE) {
        return Err(NoLoop::Scale { scale, limit: MAX_SCALE });
    }
    let (Some(here), Some(there)) = (map.keyframe(keyframe), map.keyframe(verified.matched)) else {
        return Err(NoLoop::NoPlaces);
    };
    let joins_submaps = map.submap_of(keyframe) != map.submap_of(verified.matched);
    let mut correction = if joins_submaps {
        join(keyframe, verified, map)
    } else {
        // `p_here = scale * R * p_there + scale * t`: lengths of the earlier visit become lengths of now.
        let rigid = verified.cam_from_world * there.cam_from_world.inverse();
        let graph = graph_with(witness, keyframe, map, params);
        match cycle_test::test(&graph, map, keyframe, verified.matched, &rigid, params) {
            Some(LoopVerdict::Consistent(_)) => {}
            Some(LoopVerdict::Inconsistent { reason, numbers }) => {
                return Err(NoLoop::Inconsistent { reason, numbers });
            }
            None => return Err(NoLoop::NoPlaces),
        }
        let closing = Some(([verified.matched, keyframe], rigid, scale));
        Correction { keyframes: relax(&graph, map, params, closing), ..Correction::default() }
    };
    correction.seen_revision = map.revision();
    correction.loop_edges = vec![(verified.matched, keyframe)];
    correction.merged = verified
        .matches
        .iter()
        .filter_map(|&(feature, earlier)| Some((earlier, here.point_at(feature)?)))
        .filter(|(earlier, own)| earlier != own)
        .collect();
    Ok(LoopCorrection {
        keyframe,
        matched: verified.matched,
        inliers: verified.matches.len(),
        moved_m: (verified.cam_from_world.center() - here.center()).norm(),
        turned_deg: (verified.cam_from_world.rotation * here.cam_from_world.rotation.inverse())
            .angle()
            .to_degrees(),
        scale,
        joins_submaps,
        correction,
        earlier_points: verified.earlier_points.clone(),
    })
}

fn graph_with(
    witness: Option<&Witness<SE3>>,
    keyframe: KeyframeId,
    map: &Map,
    params: &Params,
) -> EssentialGraph {
    let mut graph = EssentialGraph::new(map, keyframe, params.loops.essential_weight);
    if let Some(Witness { now, then, now_from_then }) = witness {
        graph.add_loop(map, [KeyframeId(*then), KeyframeId(*now)], *now_from_then);
    }
    graph
}

/// The test alone, of a loop within a sub-map; `None` if one of its keyframes is gone.
pub(super) fn test(
    keyframe: KeyframeId,
    verified: &Verified,
    map: &Map,
    params: &Params,
    witness: Option<&Witness<SE3>>,
) -> Option<LoopVerdict> {
    let there = map.keyframe(verified.matched)?;
    let rigid = verified.cam_from_world * there.cam_from_world.inverse();
    let graph = graph_with(witness, keyframe, map, params);
    cycle_test::test(&graph, map, keyframe, verified.matched, &rigid, params)
}

/// Moves the younger of two sub-maps as a whole to where the loop puts it.
fn join(keyframe: KeyframeId, verified: &Verified, map: &Map) -> Correction {
    let here_from_world = map.keyframe(keyframe).map_or(SE3::identity(), |kf| kf.cam_from_world);
    // World of the earlier visit to the world of now: `x_now = scale * R * x_then + t`.
    let placed = verified.cam_from_world;
    let now_from_then = Sim3::from(here_from_world).inverse()
        * Sim3::new(placed.rotation, placed.translation * verified.scale, verified.scale);
    let earlier_is_older = map.submap_of(verified.matched) < map.submap_of(keyframe);
    let (moving, under, old_from_new) = if earlier_is_older {
        (keyframe, verified.matched, now_from_then)
    } else {
        (verified.matched, keyframe, now_from_then.inverse())
    };
    let keyframes = map
        .submap_members(moving)
        .into_iter()
        .filter_map(|id| map.keyframe(id))
        .map(|kf| corrected(kf.id, &(Sim3::from(kf.cam_from_world) * old_from_new)))
        .collect();
    Correction { keyframes, joined: vec![(moving, under)], ..Correction::default() }
}

/// A motion between two keyframes, and the length there over the same length at the first of them.
pub(super) type Closing = ([KeyframeId; 2], SE3, f64);

/// The keyframes of a graph where its edges, and the motion that closes a loop, put them.
pub(super) fn relax(
    graph: &EssentialGraph,
    map: &Map,
    params: &Params,
    closing: Option<Closing>,
) -> Vec<KeyframeCorrection> {
    if params.camera.sensor.is_scale_free() {
        let closing = closing
            .map(|(ends, rigid, scale)| (ends, Sim3::new(rigid.rotation, rigid.translation * scale, scale)));
        let motion = |sim: &Sim3| SE3::new(sim.rotation, sim.translation);
        let poses = solve(graph, map, closing, params.camera.unit, Sim3::from, motion);
        graph.nodes.iter().zip(&poses).map(|(&id, pose)| corrected(id, pose)).collect()
    } else {
        let closing = closing.map(|(ends, rigid, _)| (ends, rigid));
        let poses = solve(graph, map, closing, 1.0, |pose| pose, |pose| *pose);
        let poses = graph.nodes.iter().zip(poses);
        poses.map(|(&id, pose)| KeyframeCorrection::rigid(id, pose.normalized())).collect()
    }
}

/// A keyframe's pose from `cam_from_world` with a scale: lengths in the camera divided by it are lengths in the world.
fn corrected(keyframe: KeyframeId, cam_from_world: &Sim3) -> KeyframeCorrection {
    let scale = cam_from_world.scale;
    KeyframeCorrection {
        keyframe,
        cam_from_world: SE3::new(cam_from_world.rotation, cam_from_world.translation / scale).normalized(),
        scale: 1.0 / scale,
    }
}

/// Variances of translation, rotation and logarithm of scale for a motion in a map where a meter has the length `unit`.
fn variances(motion: &SE3, unit: f64) -> [f64; 7] {
    let (length, angle) = (motion.translation.norm(), motion.rotation.angle());
    let sigma_m = unit * SIGMA_M + SIGMA_M_PER_M * length;
    let sigma_rad = SIGMA_RAD + SIGMA_RAD_PER_M * length / unit + SIGMA_RAD_PER_RAD * angle;
    let (m, rad) = (sigma_m * sigma_m, sigma_rad * sigma_rad);
    [m, m, m, rad, rad, rad, SIGMA_LOG_SCALE * SIGMA_LOG_SCALE]
}

/// Poses of the graph with the motion between two keyframes as one more edge, roots fixed. `lift` makes a motion an
/// element of the group, `motion` is the way back.
fn solve<G, const D: usize>(
    graph: &EssentialGraph,
    map: &Map,
    closing: Option<([KeyframeId; 2], G)>,
    unit: f64,
    lift: impl Fn(SE3) -> G,
    motion: impl Fn(&G) -> SE3,
) -> Vec<G>
where
    G: PoseGroup<Tangent = SVector<f64, D>, Matrix = SMatrix<f64, D, D>>,
{
    let edge = |a: usize, b: usize, b_from_a: G| {
        let variances = variances(&motion(&b_from_a), unit);
        let information = SMatrix::from_fn(|i, j| if i == j { 1.0 / variances[i] } else { 0.0 });
        PoseGraphEdge { a: a as u32, b: b as u32, b_from_a, information }
    };
    let mut edges: Vec<_> = graph.edges.iter().map(|e| edge(e.a, e.b, lift(graph.b_from_a(e)))).collect();
    if let Some(([there, here], here_from_there)) = closing
        && let (Some(a), Some(b)) = (graph.index(there), graph.index(here))
    {
        edges.push(edge(a, b, here_from_there));
    }
    let poses = graph.cam_from_world.iter().map(|&pose| lift(pose)).collect();
    let fixed = graph.nodes.iter().map(|id| map.roots().contains(id)).collect();
    refine_pose_graph(&PoseGraphProblem { poses, fixed, edges }, &PoseGraphOptions::default()).poses
}

#[cfg(test)]
#[path = "../../tests/steps/correct.rs"]
mod tests;
