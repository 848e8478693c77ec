//! Unknowns that all observations share (a camera's calibration) as a border of the reduced camera system.
//!
//! With camera blocks S, coupling K and border block D after the points are eliminated, D' = D - K^T S^-1 K is the normal matrix
//! of the shared unknowns alone, and its inverse their covariance (Triggs et al. 2000, section 6.1).

use nalgebra::{SMatrix, SVector};

use super::super::model::{ObservationModel, Point};
use super::super::structure::NONE;
use super::{Estimate, System, damping_scale};
use crate::robust::Loss;

/// Whitened residual of one observation with its derivatives, one row per coordinate, weighted with the loss.
pub(crate) struct Rows<const C: usize, const S: usize> {
    pub(crate) residual: [f64; 3],
    pub(crate) by_camera: [[f64; C]; 3],
    pub(crate) by_point: [[f64; 3]; 3],
    pub(crate) by_shared: [[f64; S]; 3],
}

/// A camera model with `S` unknowns that all cameras share.
pub(crate) trait SharedModel<const C: usize, const S: usize>: ObservationModel<C> {
    /// `None` exactly where [`ObservationModel::chi_sq`] is.
    fn rows(
        &self,
        camera: &Self::Camera,
        point: &Point,
        observation: &Self::Observation,
        loss: Loss,
    ) -> Option<Rows<C, S>>;

    /// Gradient and diagonal of the prior at the present values.
    fn prior(&self) -> [(f64, f64); S];

    /// The model with changed shared unknowns.
    fn shared_moved(&self, step: &[f64; S]) -> Self;
}

/// The border of a [`System`].
pub(crate) struct Border<const C: usize, const S: usize> {
    block: SMatrix<f64, S, S>,
    gradient: [f64; S],
    damping: [f64; S],
    right_side: SVector<f64, S>,
    /// Per elimination position of a camera.
    coupling: Vec<[[f64; S]; C]>,
    /// W^T L^-T of each point, one row per coordinate.
    z: Vec<[[f64; S]; 3]>,
}

/// The normal matrix of the shared unknowns alone, and S^-1 K by columns.
struct Reduced<const C: usize, const S: usize> {
    normal: SMatrix<f64, S, S>,
    columns: Vec<Vec<[f64; C]>>,
}

impl<const C: usize, const S: usize> Border<C, S> {
    /// Builds the border; the system has been linearized at the same estimate with the same damping.
    pub(crate) fn linearize<M: SharedModel<C, S>>(
        system: &System<M::Observation, C>,
        model: &M,
        at: &Estimate<M::Camera>,
        loss: Loss,
        lambda: f64,
    ) -> Self {
        let n_points = system.points.len();
        let mut border = Self {
            block: SMatrix::zeros(),
            gradient: [0.0; S],
            damping: [0.0; S],
            right_side: SVector::zeros(),
            coupling: vec![[[0.0; S]; C]; system.matrix.n()],
            z: vec![[[0.0; S]; 3]; n_points],
        };
        let mut eliminated = SMatrix::<f64, S, S>::zeros();
        for point in 0..n_points {
            border.gather(system, model, at, loss, point);
            border.eliminate(system, point, &mut eliminated);
        }
        for (i, (gradient, information)) in model.prior().into_iter().enumerate() {
            border.gradient[i] += gradient;
            border.block[(i, i)] += information;
            border.damping[i] = lambda * damping_scale(border.block[(i, i)]);
            border.block[(i, i)] += border.damping[i];
            border.right_side[i] -= border.gradient[i];
        }
        border.block -= eliminated;
        border
    }

    fn gather<M: SharedModel<C, S>>(
        &mut self,
        system: &System<M::Observation, C>,
        model: &M,
        at: &Estimate<M::Camera>,
        loss: Loss,
        point: usize,
    ) {
        let structure = &system.structure;
        let edges = structure.point_edges[point] as usize..structure.point_edges[point + 1] as usize;
        for edge in &structure.edges[edges] {
            let camera = &at.cameras[edge.camera as usize];
            let Some(rows) = model.rows(camera, &at.points[point], &edge.observation, loss) else { continue };
            for row in 0..3 {
                let shared = &rows.by_shared[row];
                for i in 0..S {
                    self.gradient[i] += shared[i] * rows.residual[row];
                    for j in 0..S {
                        self.block[(i, j)] += shared[i] * shared[j];
                    }
                    for k in 0..3 {
                        self.z[point][k][i] += rows.by_point[row][k] * shared[i];
                    }
                }
                if edge.slot != NONE {
                    let position = structure.slot_position[edge.slot as usize] as usize;
                    for c in 0..C {
                        for i in 0..S {
                            self.coupling[position][c][i] += rows.by_camera[row][c] * shared[i];
                        }
                    }
                }
            }
        }
    }

    fn eliminate<O: Copy>(
        &mut self,
        system: &System<O, C>,
        point: usize,
        eliminated: &mut SMatrix<f64, S, S>,
    ) {
        let (structure, factor) = (&system.structure, &system.points[point]);
        let z = factor.solve_lower(&self.z[point]);
        for k in 0..3 {
            for i in 0..S {
                self.right_side[i] -= z[k][i] * factor.y[k];
                for j in 0..S {
                    eliminated[(i, j)] += z[k][i] * z[k][j];
                }
            }
        }
        for slot in structure.point_slots[point] as usize..structure.point_slots[point + 1] as usize {
            let position = structure.slot_position[slot] as usize;
            for k in 0..3 {
                for c in 0..C {
                    for i in 0..S {
                        self.coupling[position][c][i] -= system.z[slot][k][c] * z[k][i];
                    }
                }
            }
        }
        self.z[point] = z;
    }

    /// Factors the system and eliminates it; `None` where it is not positive definite.
    fn reduced<O: Copy>(&self, system: &mut System<O, C>) -> Option<Reduced<C, S>> {
        if !system.matrix.factor(system.simd) {
            return None;
        }
        let mut normal = self.block;
        let mut columns = Vec::with_capacity(S);
        for j in 0..S {
            let mut column: Vec<[f64; C]> =
                self.coupling.iter().map(|block| std::array::from_fn(|c| block[c][j])).collect();
            system.matrix.solve(&mut column);
            for (block, solved) in self.coupling.iter().zip(&column) {
                for c in 0..C {
                    for i in 0..S {
                        normal[(i, j)] -= block[c][i] * solved[c];
                    }
                }
            }
            columns.push(column);
        }
        Some(Reduced { normal, columns })
    }

    /// The normal matrix of the shared unknowns alone, the prior included.
    pub(crate) fn normal_matrix<O: Copy>(&self, system: &mut System<O, C>) -> Option<SMatrix<f64, S, S>> {
        self.reduced(system).map(|reduced| reduced.normal)
    }

    /// Solves system and border together; writes the stepped estimate to `to` and returns the stepped model with the decrease of
    /// cost that the quadratic model predicts.
    pub(crate) fn solve_step<M: SharedModel<C, S>>(
        &self,
        system: &mut System<M::Observation, C>,
        model: &M,
        from: &Estimate<M::Camera>,
        to: &mut Estimate<M::Camera>,
    ) -> Option<(M, f64)> {
        let Reduced { normal, columns } = self.reduced(system)?;
        system.matrix.solve(&mut system.step);
        let mut right_side = self.right_side;
        for (block, step) in self.coupling.iter().zip(&system.step) {
            for c in 0..C {
                for i in 0..S {
                    right_side[i] -= block[c][i] * step[c];
                }
            }
        }
        let shared = normal.cholesky()?.solve(&right_side);
        for (j, column) in columns.iter().enumerate() {
            for (step, solved) in system.step.iter_mut().zip(column) {
                for c in 0..C {
                    step[c] -= solved[c] * shared[j];
                }
            }
        }
        let mut predicted = 0.0;
        for i in 0..S {
            predicted += 0.5 * shared[i] * (self.damping[i] * shared[i] - self.gradient[i]);
        }
        for (factor, z) in system.points.iter_mut().zip(&self.z) {
            for k in 0..3 {
                for i in 0..S {
                    factor.y[k] -= z[k][i] * shared[i];
                }
            }
        }
        let moved = model.shared_moved(&shared.into());
        Some((moved, system.take_step(model, from, to, predicted)))
    }
}
