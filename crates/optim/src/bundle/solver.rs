//! Levenberg-Marquardt over cameras and points, for any camera model.

use super::BundleOptions;
use super::model::{ObservationModel, Point};
use super::schur::{Estimate, System};
use super::structure::Structure;
use crate::descent::Attempt;
use crate::report::StopReason;
use crate::robust::Loss;
use simd::Simd;

/// One observation of a point by a camera.
#[derive(Clone, Copy, Debug)]
pub struct Edge<O> {
    /// Index of the camera.
    pub camera: u32,
    /// Index of the point.
    pub point: u32,
    /// The measurement.
    pub observation: O,
}

/// A bundle adjustment problem for any camera model.
#[derive(Clone, Debug)]
pub struct Graph<K, O> {
    /// Initial cameras.
    pub cameras: Vec<K>,
    /// Per camera whether it must not move.
    pub fixed: Vec<bool>,
    /// Initial points.
    pub points: Vec<Point>,
    /// Observations in any order.
    pub edges: Vec<Edge<O>>,
}

/// Where [`minimize`] ended.
#[derive(Clone, Debug)]
pub struct Minimum<K> {
    /// Cameras at the end.
    pub cameras: Vec<K>,
    /// Points at the end.
    pub points: Vec<Point>,
    /// Half the sum of robust squared errors at the start.
    pub initial_cost: f64,
    /// The same at the end.
    pub final_cost: f64,
    /// Linear systems solved.
    pub iterations: usize,
    /// Why it stopped.
    pub stop: StopReason,
}

/// Minimizes half the sum of (robust) squared errors over all points and free cameras.
///
/// Levenberg-Marquardt with Marquardt's diagonal scaling and Nielsen's gain-ratio damping (Madsen, Nielsen, Tingleff,
/// "Methods for non-linear least squares problems", 2004, section 3.2). Each observation
/// that its camera cannot evaluate counts a squared error of 1e6.
///
/// # Panics
/// When an edge names a camera or point that does not exist, or `fixed` has another length than `cameras`.
pub fn minimize<M, const C: usize>(
    model: &M,
    graph: Graph<M::Camera, M::Observation>,
    options: &BundleOptions,
) -> Minimum<M::Camera>
where
    M: ObservationModel<C>,
{
    minimize_with(model, graph, options, Simd::detect())
}

/// [`minimize`] with given instructions.
pub(crate) fn minimize_with<M, const C: usize>(
    model: &M,
    graph: Graph<M::Camera, M::Observation>,
    options: &BundleOptions,
    simd: Simd,
) -> Minimum<M::Camera>
where
    M: ObservationModel<C>,
{
    let (n_cameras, n_points) = (graph.cameras.len(), graph.points.len());
    assert_eq!(n_cameras, graph.fixed.len(), "one `fixed` flag per camera");
    let is_known = |e: &Edge<_>| (e.camera as usize) < n_cameras && (e.point as usize) < n_points;
    assert!(graph.edges.iter().all(is_known), "an observation names a camera or point that does not exist");
    let loss = if options.huber.is_some() { Loss::Huber } else { Loss::Squared };
    let (structure, matrix) = Structure::new::<C>(&graph.fixed, graph.points.len(), &graph.edges);
    let mut system = System::new(structure, matrix, simd);
    let mut current = Estimate { cameras: graph.cameras, points: graph.points };
    let mut trial = current.clone();
    let initial_cost = system.cost(model, &current, loss);
    let mut cost = initial_cost;
    let (iterations, stop) = if graph.edges.is_empty() {
        (0, StopReason::NoData)
    } else {
        options.descent().run(|lambda| {
            system.linearize(model, &current, loss, lambda);
            let predicted = system.solve_step(model, &current, &mut trial)?;
            let (last, next) = (cost, system.cost(model, &trial, loss));
            let decrease = last.decrease_to(&next);
            if decrease > 0.0 {
                std::mem::swap(&mut current, &mut trial);
                cost = next;
            }
            Some(Attempt { cost: last.defined, decrease, predicted })
        })
    };
    Minimum {
        cameras: current.cameras,
        points: current.points,
        initial_cost: initial_cost.total(),
        final_cost: cost.total(),
        iterations,
        stop,
    }
}
