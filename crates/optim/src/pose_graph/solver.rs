//! Levenberg-Marquardt over the poses of a graph.

use nalgebra::{SMatrix, SVector};

use super::edge::{EdgeLoss, Factor};
use super::structure::{STAYS, Structure};
use super::{PoseGraphOptions, PoseGraphProblem, PoseGraphSolution, PoseGroup};
use crate::descent::{Attempt, Descent};
use crate::report::{Report, StopReason};

/// The smallest diagonal that damping is relative to, so that directions without information are held.
const MIN_DIAGONAL: f64 = 1e-6;

/// See [`super::refine_pose_graph`].
pub(super) fn solve<G, const D: usize>(
    problem: &PoseGraphProblem<G>,
    options: &PoseGraphOptions,
) -> PoseGraphSolution<G>
where
    G: PoseGroup<Tangent = SVector<f64, D>, Matrix = SMatrix<f64, D, D>>,
{
    let prepared: Vec<Option<Factor<G, D>>> =
        problem.edges.iter().map(|edge| Factor::new(edge, &problem.poses)).collect();
    let factors: Vec<Factor<G, D>> = prepared.iter().flatten().copied().collect();
    let loss = EdgeLoss::new(options.huber);
    let initial_cost = cost(&factors, &problem.poses, &loss);
    let mut graph =
        Graph { factors: &factors, poses: problem.poses.clone(), cost: initial_cost, loss, iterations: 0 };
    let stop = match Structure::new(problem.poses.len(), &problem.fixed, &factors) {
        Some(mut structure) if structure.n_free > 0 => {
            let stop = graph.run(&mut structure, options);
            if graph.cost < initial_cost {
                graph.normalize(&structure);
            }
            stop
        }
        Some(_) => StopReason::NoData,
        None => StopReason::NoDescent,
    };
    let Graph { poses, cost: final_cost, iterations, .. } = graph;
    let chi_sq: Vec<f64> =
        prepared.iter().map(|f| f.as_ref().map_or(f64::NAN, |f| f.chi_sq(&poses))).collect();
    let n_inliers = chi_sq.iter().filter(|&&c| c <= G::CHI_SQ_LIMIT).count();
    PoseGraphSolution {
        poses,
        chi_sq,
        report: Report { initial_cost, final_cost, iterations, n_inliers, stop },
    }
}

/// Half the sum of robust squared errors.
fn cost<G, const D: usize>(factors: &[Factor<G, D>], poses: &[G], loss: &EdgeLoss) -> f64
where
    G: PoseGroup<Tangent = SVector<f64, D>, Matrix = SMatrix<f64, D, D>>,
{
    0.5 * factors.iter().map(|factor| loss.rho(factor.chi_sq(poses))).sum::<f64>()
}

struct Graph<'a, G, const D: usize> {
    factors: &'a [Factor<G, D>],
    poses: Vec<G>,
    cost: f64,
    loss: EdgeLoss,
    iterations: usize,
}

impl<G, const D: usize> Graph<'_, G, D>
where
    G: PoseGroup<Tangent = SVector<f64, D>, Matrix = SMatrix<f64, D, D>>,
{
    fn run(&mut self, structure: &mut Structure<D>, options: &PoseGraphOptions) -> StopReason {
        let descent = Descent {
            max_iterations: options.max_iterations,
            tolerance: options.relative_tolerance.max(f64::EPSILON),
            initial_damping: options.initial_damping,
        };
        let mut gradient = vec![SVector::zeros(); structure.n_free];
        let mut is_linearized = false;
        let mut diagonal = Vec::new();
        let (iterations, stop) = descent.run(|lambda| {
            if !is_linearized {
                self.linearize(structure, &mut gradient);
                diagonal = structure.matrix.diagonal_values();
                is_linearized = true;
            }
            let step = damped_step(structure, &gradient, &diagonal, lambda)?;
            let trial = self.moved(structure, &step.vector);
            let trial_cost = cost(self.factors, &trial, &self.loss);
            let (cost, decrease) = (self.cost, self.cost - trial_cost);
            if decrease > 0.0 {
                (self.poses, self.cost) = (trial, trial_cost);
                is_linearized = false;
            }
            Some(Attempt { cost, decrease, predicted: step.predicted })
        });
        self.iterations = iterations;
        stop
    }

    /// Fills the normal equations at the current poses.
    fn linearize(&self, structure: &mut Structure<D>, gradient: &mut [SVector<f64, D>]) {
        structure.matrix.clear();
        gradient.fill(SVector::zeros());
        for (factor, slots) in self.factors.iter().zip(&structure.slots) {
            let blocks = factor.blocks(&self.poses, &self.loss);
            if let Some((position, slot)) = slots.a {
                gradient[position] += blocks.gradient_a;
                structure.matrix.add_diagonal(slot, &blocks.aa);
            }
            if let Some((position, slot)) = slots.b {
                gradient[position] += blocks.gradient_b;
                structure.matrix.add_diagonal(slot, &blocks.bb);
            }
            if let Some(slot) = slots.ab {
                structure.matrix.add(slot, &blocks.ab);
            }
        }
    }

    /// The poses after a step.
    fn moved(&self, structure: &Structure<D>, step: &[SVector<f64, D>]) -> Vec<G> {
        let moved = self.poses.iter().zip(&structure.position).map(|(pose, &position)| {
            if position == STAYS { *pose } else { G::exp(&step[position as usize]) * *pose }
        });
        moved.collect()
    }

    /// Takes the rounding errors of many steps out of the rotations that moved.
    fn normalize(&mut self, structure: &Structure<D>) {
        for (pose, _) in self.poses.iter_mut().zip(&structure.position).filter(|(_, p)| **p != STAYS) {
            *pose = pose.normalized();
        }
        self.cost = cost(self.factors, &self.poses, &self.loss);
    }
}

struct Step<const D: usize> {
    /// By elimination position.
    vector: Vec<SVector<f64, D>>,
    /// Decrease of cost by the quadratic model.
    predicted: f64,
}

/// Solves (H + lambda diag(H)) x = -g; `None` when that is not positive definite.
fn damped_step<const D: usize>(
    structure: &mut Structure<D>,
    gradient: &[SVector<f64, D>],
    diagonal: &[SVector<f64, D>],
    lambda: f64,
) -> Option<Step<D>> {
    let damping = |d: &SVector<f64, D>| d.map(|v| lambda * v.max(MIN_DIAGONAL));
    structure.matrix.set_diagonal_values(diagonal.iter().map(|d| d + damping(d)));
    let mut vector: Vec<SVector<f64, D>> = gradient.iter().map(|g| -g).collect();
    if !structure.matrix.solve(&mut vector) {
        return None;
    }
    // x' H x = -g' x - x' (lambda diag(H)) x.
    let terms = vector.iter().zip(gradient.iter().zip(diagonal));
    let predicted =
        0.5 * terms.map(|(x, (g, d))| x.component_mul(&damping(d)).dot(x) - g.dot(x)).sum::<f64>();
    Some(Step { vector, predicted })
}
