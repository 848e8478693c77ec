//! Linearises a problem point by point, eliminates each point at once (Schur complement) and solves for the cameras.
//!
//! With damped point block V = L L^T and camera-point blocks W, Z = W L^-T gives the reduced system
//! (U + damping - Z Z^T) dx = -g_c - Z y, y = -L^-1 g_p, and the point step dp = L^-T (y - Z^T dx).
//! (Triggs et al. 2000, section 6; each point's blocks stay in the first cache level.)

pub(crate) mod border;

use super::cholesky::BlockCholesky;
use super::model::{Linearization, ObservationModel, Point};
use super::point::{PointFactor, damping_scale};
use super::structure::{NONE, Structure};
use crate::robust::{Loss, MAX_CHI_SQ};
use simd::{Simd, Task};

/// Cameras and points under estimation.
#[derive(Clone)]
pub(crate) struct Estimate<K> {
    pub(crate) cameras: Vec<K>,
    pub(crate) points: Vec<Point>,
}

/// Half the sum of the robust squared errors, in two parts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cost {
    /// Of observations that are defined.
    pub(crate) defined: f64,
    /// Of those that are not and count their cap.
    undefined: f64,
}

impl Cost {
    /// With a cost that does not come from observations.
    pub(crate) fn plus(self, other: f64) -> Self {
        Self { defined: self.defined + other, ..self }
    }

    /// Both parts.
    pub(crate) fn total(&self) -> f64 {
        self.defined + self.undefined
    }

    /// How much lower `next` is; caps of those that stay undefined leave no rounding.
    pub(crate) fn decrease_to(&self, next: &Self) -> f64 {
        (self.defined - next.defined) + (self.undefined - next.undefined)
    }
}

/// The damped normal equations of a problem and their solution.
pub(crate) struct System<O, const C: usize> {
    structure: Structure<O>,
    matrix: BlockCholesky<C>,
    /// Per elimination position: camera block, its gradient and damping, and the right-hand side that becomes the step.
    camera_block: Vec<[[f64; C]; C]>,
    gradient: Vec<[f64; C]>,
    damping: Vec<[f64; C]>,
    step: Vec<[f64; C]>,
    /// Z^T per slot, one row per point coordinate.
    z: Vec<[[f64; C]; 3]>,
    points: Vec<PointFactor>,
    simd: Simd,
}

impl<O: Copy, const C: usize> System<O, C> {
    /// All buffers for a problem.
    pub(crate) fn new(structure: Structure<O>, matrix: BlockCholesky<C>, simd: Simd) -> Self {
        let n = matrix.n();
        Self {
            camera_block: vec![[[0.0; C]; C]; n],
            gradient: vec![[0.0; C]; n],
            damping: vec![[0.0; C]; n],
            step: vec![[0.0; C]; n],
            z: vec![[[0.0; C]; 3]; structure.slot_position.len()],
            points: vec![PointFactor::default(); structure.point_edges.len() - 1],
            structure,
            matrix,
            simd,
        }
    }

    /// The cost at `at`.
    pub(crate) fn cost<M>(&self, model: &M, at: &Estimate<M::Camera>, loss: Loss) -> Cost
    where
        M: ObservationModel<C, Observation = O>,
    {
        self.simd.run(CostKernel { structure: &self.structure, model, at, loss })
    }

    /// Builds the reduced camera system at `at`.
    pub(crate) fn linearize<M>(&mut self, model: &M, at: &Estimate<M::Camera>, loss: Loss, lambda: f64)
    where
        M: ObservationModel<C, Observation = O>,
    {
        let simd = self.simd;
        simd.run(Linearize { system: self, model, at, loss, lambda });
    }

    /// Solves the system and writes the stepped estimate to `to`; returns the decrease of cost that the quadratic model
    /// predicts, or `None` where the system is not positive definite.
    pub(crate) fn solve_step<M>(
        &mut self,
        model: &M,
        from: &Estimate<M::Camera>,
        to: &mut Estimate<M::Camera>,
    ) -> Option<f64>
    where
        M: ObservationModel<C, Observation = O>,
    {
        if !self.matrix.factor(self.simd) {
            return None;
        }
        self.matrix.solve(&mut self.step);
        Some(self.take_step(model, from, to, 0.0))
    }

    /// Writes the estimate after `step` to `to`; returns `predicted` with the decrease that the quadratic model predicts of cameras and
    /// points.
    fn take_step<M>(
        &self,
        model: &M,
        from: &Estimate<M::Camera>,
        to: &mut Estimate<M::Camera>,
        mut predicted: f64,
    ) -> f64
    where
        M: ObservationModel<C, Observation = O>,
    {
        for ((step, damping), gradient) in self.step.iter().zip(&self.damping).zip(&self.gradient) {
            for i in 0..C {
                predicted += 0.5 * step[i] * (damping[i] * step[i] - gradient[i]);
            }
        }
        for (camera, &position) in self.structure.position.iter().enumerate() {
            if position != NONE {
                to.cameras[camera] = model.moved(&from.cameras[camera], &self.step[position as usize]);
            }
        }
        predicted + self.simd.run(BackSubstitute { system: self, from: &from.points, to: &mut to.points })
    }
}

struct CostKernel<'a, M: ObservationModel<C>, const C: usize> {
    structure: &'a Structure<M::Observation>,
    model: &'a M,
    at: &'a Estimate<M::Camera>,
    loss: Loss,
}

impl<M: ObservationModel<C>, const C: usize> Task for CostKernel<'_, M, C> {
    type Output = Cost;

    #[inline(always)]
    fn run(self) -> Cost {
        let (mut defined, mut undefined) = (0.0, 0.0);
        for (point, range) in self.structure.point_edges.windows(2).enumerate() {
            let x = &self.at.points[point];
            for edge in &self.structure.edges[range[0] as usize..range[1] as usize] {
                let camera = &self.at.cameras[edge.camera as usize];
                let delta_sq = self.model.delta_sq(&edge.observation);
                match self.model.chi_sq(camera, x, &edge.observation) {
                    Some(chi_sq) => defined += self.loss.rho(chi_sq, delta_sq),
                    None => undefined += self.loss.rho(MAX_CHI_SQ, delta_sq),
                }
            }
        }
        Cost { defined: 0.5 * defined, undefined: 0.5 * undefined }
    }
}

struct Linearize<'a, M: ObservationModel<C>, const C: usize> {
    system: &'a mut System<M::Observation, C>,
    model: &'a M,
    at: &'a Estimate<M::Camera>,
    loss: Loss,
    lambda: f64,
}

impl<M: ObservationModel<C>, const C: usize> Task for Linearize<'_, M, C> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { system, model, at, loss, lambda } = self;
        system.matrix.blocks.fill([[0.0; C]; C]);
        system.camera_block.fill([[0.0; C]; C]);
        system.gradient.fill([0.0; C]);
        system.step.fill([0.0; C]);
        for point in 0..system.points.len() {
            let (block, gradient) = gather_point(system, model, at, loss, point);
            let factor = PointFactor::new(&block, &gradient, lambda);
            system.points[point] = factor;
            eliminate_point(system, &factor, point);
        }
        for position in 0..system.matrix.n() {
            let diagonal = system.matrix.diagonal(position);
            let (block, target) = (&system.camera_block[position], &mut system.matrix.blocks[diagonal]);
            for r in 0..C {
                for c in 0..C {
                    target[r][c] += block[r][c];
                }
                let damping = lambda * damping_scale(block[r][r]);
                system.damping[position][r] = damping;
                target[r][r] += damping;
                system.step[position][r] -= system.gradient[position][r];
            }
        }
    }
}

/// Sums the blocks of a point's observations: camera parts into the system, W^T into `z`, the point's own are returned.
#[inline(always)]
fn gather_point<M: ObservationModel<C>, const C: usize>(
    system: &mut System<M::Observation, C>,
    model: &M,
    at: &Estimate<M::Camera>,
    loss: Loss,
    point: usize,
) -> ([f64; 6], [f64; 3]) {
    let structure = &system.structure;
    let slots = structure.point_slots[point] as usize..structure.point_slots[point + 1] as usize;
    system.z[slots].fill([[0.0; C]; 3]);
    let mut block = [0.0; 6];
    let mut gradient = [0.0; 3];
    let edges = structure.point_edges[point] as usize..structure.point_edges[point + 1] as usize;
    for edge in &structure.edges[edges] {
        let camera = &at.cameras[edge.camera as usize];
        let Some(lin) = model.linearize(camera, &at.points[point], &edge.observation, loss) else { continue };
        let Linearization { camera_camera, point_camera, point_point, camera_gradient, point_gradient } = lin;
        for i in 0..6 {
            block[i] += point_point[i];
        }
        for i in 0..3 {
            gradient[i] += point_gradient[i];
        }
        if edge.slot == NONE {
            continue;
        }
        let position = structure.slot_position[edge.slot as usize] as usize;
        let (z, u) = (&mut system.z[edge.slot as usize], &mut system.camera_block[position]);
        for r in 0..3 {
            for c in 0..C {
                z[r][c] += point_camera[r][c];
            }
        }
        for r in 0..C {
            for c in 0..C {
                u[r][c] += camera_camera[r][c];
            }
            system.gradient[position][r] += camera_gradient[r];
        }
    }
    (block, gradient)
}

/// Turns W into Z and subtracts Z Z^T and Z y from the reduced system.
#[inline(always)]
fn eliminate_point<O, const C: usize>(system: &mut System<O, C>, factor: &PointFactor, point: usize) {
    let structure = &system.structure;
    let (first, end) = (structure.point_slots[point] as usize, structure.point_slots[point + 1] as usize);
    let y = &factor.y;
    for slot in first..end {
        let z = factor.solve_lower(&system.z[slot]);
        let rhs = &mut system.step[structure.slot_position[slot] as usize];
        for c in 0..C {
            rhs[c] -= z[0][c] * y[0] + z[1][c] * y[1] + z[2][c] * y[2];
        }
        system.z[slot] = z;
    }
    let z = &system.z[first..end];
    for a in 0..z.len() {
        let pairs = &structure.pair_block[structure.slot_pairs[first + a] as usize..][..z.len() - a];
        let za = z[a];
        for (zb, &pair) in z[a..].iter().zip(pairs) {
            subtract_outer(&mut system.matrix.blocks[pair as usize], zb, &za);
        }
    }
}

/// `block -= zb za^T`, both given transposed.
#[inline(always)]
fn subtract_outer<const C: usize>(block: &mut [[f64; C]; C], zb: &[[f64; C]; 3], za: &[[f64; C]; 3]) {
    for r in 0..C {
        let mut row = block[r];
        for c in 0..C {
            row[c] -= zb[0][r] * za[0][c] + zb[1][r] * za[1][c] + zb[2][r] * za[2][c];
        }
        block[r] = row;
    }
}

struct BackSubstitute<'a, O, const C: usize> {
    system: &'a System<O, C>,
    from: &'a [Point],
    to: &'a mut [Point],
}

impl<O, const C: usize> Task for BackSubstitute<'_, O, C> {
    type Output = f64;

    /// Steps all points; returns their part of the predicted decrease.
    #[inline(always)]
    fn run(self) -> f64 {
        let Self { system, from, to } = self;
        let structure = &system.structure;
        let mut predicted = 0.0;
        for (point, factor) in system.points.iter().enumerate() {
            let mut products = [[0.0; C]; 3];
            for slot in structure.point_slots[point] as usize..structure.point_slots[point + 1] as usize {
                let (z, dx) = (&system.z[slot], &system.step[structure.slot_position[slot] as usize]);
                for k in 0..3 {
                    for c in 0..C {
                        products[k][c] += z[k][c] * dx[c];
                    }
                }
            }
            let mut rest = factor.y;
            for k in 0..3 {
                for c in 0..C {
                    rest[k] -= products[k][c];
                }
            }
            let step = factor.solve_upper(&rest);
            for k in 0..3 {
                to[point][k] = from[point][k] + step[k];
                predicted += 0.5 * step[k] * (factor.damping[k] * step[k] - factor.gradient[k]);
            }
        }
        predicted
    }
}
