//! The measurements of a loop test, in the order of its gates.

use geometry::{Mat3, SE3, SO3, Vec3};

use super::cycle::{Way, lightest_way};
use super::{CHI2_CLOSURE, CycleEdge, CycleEdgeKind, Inconsistency, LoopNumbers};
use crate::convex::{TranslationEdge, TranslationProblem, fit_translations};
use crate::pose_graph::{PoseGraphEdge, PoseGraphOptions, PoseGraphProblem, refine_pose_graph};
use crate::robust::CHI2_STEREO;

/// Fills in the numbers; `Err` names the first gate that the candidate fails.
pub(super) fn measure(
    nodes: &[SE3],
    edges: &[CycleEdge],
    numbers: &mut LoopNumbers,
) -> Result<(), Inconsistency> {
    let candidate = check(nodes, edges)?;
    let ends: Vec<(u32, u32)> = edges.iter().map(|e| (e.a, e.b)).collect();
    let variances: Vec<f64> = edges.iter().map(|e| e.sigma_rad * e.sigma_rad).collect();
    let way = lightest_way(nodes.len(), &ends, &variances, candidate).ok_or(Inconsistency::NoCycle)?;
    gate_rotation(edges, candidate, &way, numbers)?;

    // Where the losses turn from quadratic to linear, in sigma.
    let huber = CHI2_STEREO.sqrt();
    let averaged = average_rotations(nodes, edges, candidate, huber);
    let problem = TranslationProblem {
        n_nodes: nodes.len(),
        fixed: edges[candidate].a,
        edges: translations(nodes, edges, candidate, &way, &averaged.rotations),
        huber,
    };
    let closed = gate_translation(&problem, &ends, candidate, numbers);
    let fit = fit_translations(&problem).map_err(Inconsistency::Convex)?;
    let residuals: Vec<f64> = fit.residuals.iter().zip(&averaged.residuals).map(|(t, r)| t.max(*r)).collect();
    let whole = gate_residuals(edges, &residuals, numbers);
    closed.and(whole)
}

/// Index of the candidate.
fn check(nodes: &[SE3], edges: &[CycleEdge]) -> Result<usize, Inconsistency> {
    let is_sigma = |sigma: f64| sigma > 0.0 && sigma.is_finite();
    let is_known = |node: u32| nodes.get(node as usize).is_some_and(SE3::is_finite);
    let is_good = |e: &CycleEdge| {
        let joins = e.a != e.b && is_known(e.a) && is_known(e.b);
        joins && e.b_from_a.is_finite() && is_sigma(e.sigma_m) && is_sigma(e.sigma_rad)
    };
    if let Some(edge) = edges.iter().position(|e| !is_good(e)) {
        return Err(Inconsistency::BadInput { edge });
    }
    let mut candidates = edges.iter().enumerate().filter(|(_, e)| e.kind == CycleEdgeKind::Candidate);
    match (candidates.next(), candidates.next()) {
        (Some((candidate, _)), None) => Ok(candidate),
        _ => Err(Inconsistency::BadInput { edge: edges.len() }),
    }
}

fn gate_rotation(
    edges: &[CycleEdge],
    candidate: usize,
    way: &Way,
    numbers: &mut LoopNumbers,
) -> Result<(), Inconsistency> {
    let loop_edge = &edges[candidate];
    let mut b_from_a = SO3::identity();
    let mut length_m = loop_edge.b_from_a.translation.norm();
    for &(edge, is_forward) in &way.steps {
        let rotation = edges[edge].b_from_a.rotation;
        b_from_a = if is_forward { rotation } else { rotation.inverse() } * b_from_a;
        length_m += edges[edge].b_from_a.translation.norm();
    }
    let closure = (loop_edge.b_from_a.rotation.inverse() * b_from_a.orthonormalized()).angle();
    let sigma = (way.weight + loop_edge.sigma_rad * loop_edge.sigma_rad).sqrt();
    numbers.cycle_edges = way.steps.len() + 1;
    numbers.cycle_length_m = length_m;
    numbers.rotation_closure_deg = closure.to_degrees();
    numbers.rotation_sigma_deg = sigma.to_degrees();
    let sigmas = closure / sigma;
    if sigmas * sigmas <= CHI2_CLOSURE {
        return Ok(());
    }
    Err(Inconsistency::Rotation { sigmas })
}

struct Averaged {
    /// node_from_world.
    rotations: Vec<SO3>,
    /// Per edge, sigma.
    residuals: Vec<f64>,
}

/// Rotations that fit the measured ones best, from the current estimates on.
fn average_rotations(nodes: &[SE3], edges: &[CycleEdge], candidate: usize, huber: f64) -> Averaged {
    let mut problem = PoseGraphProblem {
        poses: nodes.iter().map(|n| n.rotation).collect(),
        fixed: vec![false; nodes.len()],
        edges: Vec::with_capacity(edges.len()),
    };
    problem.fixed[edges[candidate].a as usize] = true;
    problem.edges.extend(edges.iter().map(|e| PoseGraphEdge {
        a: e.a,
        b: e.b,
        b_from_a: e.b_from_a.rotation,
        information: Mat3::from_diagonal_element(1.0 / (e.sigma_rad * e.sigma_rad)),
    }));
    let options = PoseGraphOptions { huber: Some(huber), ..Default::default() };
    let solution = refine_pose_graph(&problem, &options);
    Averaged { rotations: solution.poses, residuals: solution.chi_sq.iter().map(|c| c.sqrt()).collect() }
}

/// Translations along the world's axes, with the lever arms of rotation errors in their sigmas.
fn translations(
    nodes: &[SE3],
    edges: &[CycleEdge],
    candidate: usize,
    way: &Way,
    rotations: &[SO3],
) -> Vec<TranslationEdge> {
    let place = |e: &CycleEdge| 0.5 * (nodes[e.a as usize].center() + nodes[e.b as usize].center());
    let (mut weighted, mut weight) = (Vec3::zeros(), 0.0);
    for edge in way.steps.iter().map(|&(edge, _)| edge).chain([candidate]) {
        let variance = edges[edge].sigma_rad * edges[edge].sigma_rad;
        weighted += place(&edges[edge]) * variance;
        weight += variance;
    }
    let centroid = weighted / weight;
    let translation = |e: &CycleEdge| {
        // Where the averaged rotations differ from the measured one, halfway between both ends.
        let seen_from_b = rotations[e.b as usize].inverse() * e.b_from_a.translation;
        let seen_from_a = rotations[e.a as usize].inverse() * e.b_from_a.inverse().translation;
        0.5 * (seen_from_a - seen_from_b)
    };
    let edge = |e: &CycleEdge| TranslationEdge {
        a: e.a,
        b: e.b,
        translation: translation(e),
        sigma_m: e.sigma_m.hypot(e.sigma_rad * (place(e) - centroid).norm()),
    };
    edges.iter().map(edge).collect()
}

fn gate_translation(
    problem: &TranslationProblem,
    ends: &[(u32, u32)],
    candidate: usize,
    numbers: &mut LoopNumbers,
) -> Result<(), Inconsistency> {
    let variances: Vec<f64> = problem.edges.iter().map(|e| e.sigma_m * e.sigma_m).collect();
    let way = lightest_way(problem.n_nodes, ends, &variances, candidate).ok_or(Inconsistency::NoCycle)?;
    let mut closure = -problem.edges[candidate].translation;
    for &(edge, is_forward) in &way.steps {
        let translation = problem.edges[edge].translation;
        closure += if is_forward { translation } else { -translation };
    }
    numbers.translation_closure_m = closure.norm();
    numbers.translation_sigma_m = (way.weight + variances[candidate]).sqrt();
    let sigmas = numbers.translation_closure_m / numbers.translation_sigma_m;
    if sigmas * sigmas <= CHI2_CLOSURE {
        return Ok(());
    }
    Err(Inconsistency::Translation { sigmas })
}

fn gate_residuals(
    edges: &[CycleEdge],
    residuals: &[f64],
    numbers: &mut LoopNumbers,
) -> Result<(), Inconsistency> {
    let mut worst = (0, 0.0);
    for (edge, (e, &sigmas)) in edges.iter().zip(residuals).enumerate() {
        let of_kind = match e.kind {
            CycleEdgeKind::Candidate => &mut numbers.candidate_residual,
            CycleEdgeKind::EarlierLoop => &mut numbers.earlier_loop_residual,
            CycleEdgeKind::Odometry => &mut numbers.odometry_residual,
        };
        *of_kind = of_kind.max(sigmas);
        // A residual that is not a number is above any gate.
        if !(sigmas <= worst.1) {
            worst = (edge, sigmas);
        }
    }
    let (edge, sigmas) = worst;
    if sigmas <= CHI2_CLOSURE.sqrt() {
        return Ok(());
    }
    Err(Inconsistency::Residual { edge, kind: edges[edge].kind, sigmas })
}
