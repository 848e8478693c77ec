//! The 6x6 normal equations of one pose over all observations, four at a time.

use geometry::{SE3, StereoRig};

use super::PoseObservation;
use super::lanes::F4;
use crate::bundle::rig::MIN_DEPTH_M;
use crate::robust::{CHI2_MONO, CHI2_STEREO, Loss, MAX_CHI_SQ};
use simd::{Simd, Task};

/// Four observations, structure of arrays.
#[derive(Clone, Copy, Default)]
struct Pack {
    point: [F4; 3],
    u: F4,
    v: F4,
    right_u: F4,
    weight: F4,
    /// Weight of the right measurement, 0 where there is none.
    right_weight: F4,
    /// Chi-square limit; 0 in lanes without a usable observation.
    limit: F4,
    /// 1 where the observation takes part, else 0.
    active: F4,
}

/// Cost, gradient and Hessian (lower triangle) of a pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Normal {
    pub(super) cost: f64,
    pub(super) gradient: [f64; 6],
    pub(super) hessian: [[f64; 6]; 6],
}

/// All observations of a frame with the rig that made them.
pub(super) struct Packs {
    packs: Vec<Pack>,
    rig: StereoRig,
    n: usize,
    simd: Simd,
}

/// Camera-frame point, inverse depth, residuals and squared error of four observations; zero where undefined.
struct Residual {
    p: [F4; 3],
    inv_z: F4,
    r: [F4; 3],
    chi_sq: F4,
    defined: F4,
}

impl Packs {
    /// Packs the observations; those with a number that is not finite never take part.
    pub(super) fn new(rig: &StereoRig, observations: &[PoseObservation], simd: Simd) -> Self {
        let mut packs = vec![Pack::default(); observations.len().div_ceil(4)];
        for (i, o) in observations.iter().enumerate() {
            let (pack, l) = (&mut packs[i / 4], i % 4);
            let has_right = !o.right_u.is_nan();
            let right_u = if has_right { o.right_u } else { 0.0 };
            let numbers = [o.point_world.x, o.point_world.y, o.point_world.z, o.pixel.x, o.pixel.y, right_u];
            if !(numbers.iter().all(|x| x.is_finite()) && o.inv_sigma_sq > 0.0 && o.inv_sigma_sq.is_finite())
            {
                continue;
            }
            for k in 0..3 {
                pack.point[k].0[l] = o.point_world[k];
            }
            (pack.u.0[l], pack.v.0[l], pack.right_u.0[l]) = (o.pixel.x, o.pixel.y, right_u);
            pack.weight.0[l] = o.inv_sigma_sq;
            pack.right_weight.0[l] = if has_right { o.inv_sigma_sq } else { 0.0 };
            pack.limit.0[l] = if has_right { CHI2_STEREO } else { CHI2_MONO };
            pack.active.0[l] = 1.0;
        }
        Self { packs, rig: *rig, n: observations.len(), simd }
    }

    /// Lets the chosen observations take part.
    pub(super) fn set_active(&mut self, active: &[bool]) {
        for (i, &a) in active.iter().enumerate() {
            self.packs[i / 4].active.0[i % 4] = f64::from(u8::from(a));
        }
    }

    /// Normal equations at a pose over the active observations.
    pub(super) fn normal(&self, cam_from_world: &SE3, loss: Loss) -> Normal {
        self.simd.run(NormalKernel { packs: self, camera: Camera::new(cam_from_world), loss })
    }

    /// Per observation whether its error lies within `factor` times its chi-square limit.
    pub(super) fn within(&self, cam_from_world: &SE3, factor: f64) -> Vec<bool> {
        let mut within =
            self.simd.run(WithinKernel { packs: self, camera: Camera::new(cam_from_world), factor });
        within.truncate(self.n);
        within
    }

    #[inline(always)]
    fn residual(&self, pack: &Pack, camera: &Camera) -> Residual {
        let x = &pack.point;
        let p: [F4; 3] = std::array::from_fn(|i| {
            let row = &camera.rotation[i];
            row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + camera.translation[i]
        });
        let (zero, one) = (F4::splat(0.0), F4::splat(1.0));
        let in_front = p[2].above(F4::splat(MIN_DEPTH_M));
        let inv_z = in_front.select(p[2], one).recip();
        let c = &self.rig.camera;
        let u = F4::splat(c.fx) * p[0] * inv_z + F4::splat(c.cx);
        let v = F4::splat(c.fy) * p[1] * inv_z + F4::splat(c.cy);
        let right_u = u - F4::splat(self.rig.bf()) * inv_z;
        let r = [u - pack.u, v - pack.v, right_u - pack.right_u];
        let chi_sq = pack.weight * (r[0] * r[0] + r[1] * r[1]) + pack.right_weight * (r[2] * r[2]);
        let cap = F4::splat(MAX_CHI_SQ);
        let defined = in_front.and(cap.above(chi_sq));
        Residual {
            p: p.map(|x| defined.select(x, zero)),
            inv_z: defined.select(inv_z, zero),
            r: r.map(|x| defined.select(x, zero)),
            chi_sq: defined.select(chi_sq, cap),
            defined: defined.select(one, zero),
        }
    }
}

/// A pose with each number in all lanes.
struct Camera {
    rotation: [[F4; 3]; 3],
    translation: [F4; 3],
}

impl Camera {
    fn new(cam_from_world: &SE3) -> Self {
        let m = cam_from_world.rotation.matrix();
        Self {
            rotation: std::array::from_fn(|r| std::array::from_fn(|c| F4::splat(m[(r, c)]))),
            translation: std::array::from_fn(|i| F4::splat(cam_from_world.translation[i])),
        }
    }
}

struct NormalKernel<'a> {
    packs: &'a Packs,
    camera: Camera,
    loss: Loss,
}

impl Task for NormalKernel<'_> {
    type Output = Normal;

    /// Sums J^T W J = [A, .; B, B [p]x^T] with B = [p]x A, as in the bundle's rig model.
    #[inline(always)]
    fn run(self) -> Normal {
        let Self { packs, camera, loss } = self;
        let (fx, fy, bf) = (packs.rig.camera.fx, packs.rig.camera.fy, packs.rig.bf());
        let (fx, fy, bf) = (F4::splat(fx), F4::splat(fy), F4::splat(bf));
        let mut cost = F4::default();
        let mut gradient = [F4::default(); 6];
        let mut block_a = [F4::default(); 5];
        let mut block_b = [[F4::default(); 3]; 3];
        let mut block_c = [F4::default(); 6];
        for pack in &packs.packs {
            let Residual { p, inv_z, r, chi_sq, defined } = packs.residual(pack, &camera);
            let (rho, weight) = huber(loss, chi_sq, pack.limit);
            cost += pack.active * rho;
            let weight = weight * pack.active * defined;
            let (w, wr) = (weight * pack.weight, weight * pack.right_weight);

            // Rows of J: (a, 0, b), (0, c, d), (a, 0, e).
            let (a, c) = (fx * inv_z, fy * inv_z);
            let zero = F4::default();
            let (b, d) = (zero - a * p[0] * inv_z, zero - c * p[1] * inv_z);
            let e = b + bf * inv_z * inv_z;
            let a00 = a * a * (w + wr);
            let a02 = a * (w * b + wr * e);
            let (a11, a12) = (w * c * c, w * c * d);
            let a22 = w * (b * b + d * d) + wr * (e * e);
            let g = [a * (w * r[0] + wr * r[2]), w * c * r[1], w * (b * r[0] + d * r[1]) + wr * e * r[2]];

            // Rows of B = [p]x A, with A's columns (a00, 0, a02), (0, a11, a12), (a02, a12, a22).
            let [x, y, z] = p;
            let rows = [
                [y * a02, y * a12 - z * a11, y * a22 - z * a12],
                [z * a00 - x * a02, zero - x * a12, z * a02 - x * a22],
                [zero - y * a00, x * a11, x * a12 - y * a02],
            ];
            for (sum, value) in block_a.iter_mut().zip([a00, a11, a02, a12, a22]) {
                *sum += value;
            }
            for i in 0..3 {
                for j in 0..3 {
                    block_b[i][j] += rows[i][j];
                }
            }
            // Row i of B [p]x^T is p x (row i of B).
            block_c[0] += y * rows[0][2] - z * rows[0][1];
            block_c[1] += y * rows[1][2] - z * rows[1][1];
            block_c[2] += z * rows[1][0] - x * rows[1][2];
            block_c[3] += y * rows[2][2] - z * rows[2][1];
            block_c[4] += z * rows[2][0] - x * rows[2][2];
            block_c[5] += x * rows[2][1] - y * rows[2][0];
            let torque = [y * g[2] - z * g[1], z * g[0] - x * g[2], x * g[1] - y * g[0]];
            for i in 0..3 {
                gradient[i] += g[i];
                gradient[i + 3] += torque[i];
            }
        }
        let [a00, a11, a02, a12, a22] = block_a.map(F4::sum);
        let [c00, c10, c11, c20, c21, c22] = block_c.map(F4::sum);
        let b = block_b.map(|row| row.map(F4::sum));
        Normal {
            cost: 0.5 * cost.sum(),
            gradient: gradient.map(F4::sum),
            hessian: [
                [a00, 0.0, 0.0, 0.0, 0.0, 0.0],
                [0.0, a11, 0.0, 0.0, 0.0, 0.0],
                [a02, a12, a22, 0.0, 0.0, 0.0],
                [b[0][0], b[0][1], b[0][2], c00, 0.0, 0.0],
                [b[1][0], b[1][1], b[1][2], c10, c11, 0.0],
                [b[2][0], b[2][1], b[2][2], c20, c21, c22],
            ],
        }
    }
}

struct WithinKernel<'a> {
    packs: &'a Packs,
    camera: Camera,
    factor: f64,
}

impl Task for WithinKernel<'_> {
    type Output = Vec<bool>;

    #[inline(always)]
    fn run(self) -> Vec<bool> {
        let Self { packs, camera, factor } = self;
        let mut out = vec![false; 4 * packs.packs.len()];
        for (pack, out) in packs.packs.iter().zip(out.chunks_exact_mut(4)) {
            let Residual { chi_sq, defined, .. } = packs.residual(pack, &camera);
            for l in 0..4 {
                let limit = pack.limit.0[l];
                out[l] = limit > 0.0 && defined.0[l] > 0.0 && chi_sq.0[l] <= factor * limit;
            }
        }
        out
    }
}

/// Loss and weight of four squared errors with delta^2 = limit.
#[inline(always)]
fn huber(loss: Loss, chi_sq: F4, limit: F4) -> (F4, F4) {
    let one = F4::splat(1.0);
    match loss {
        Loss::Squared => (chi_sq, one),
        Loss::Huber => {
            let beyond = chi_sq.above(limit);
            let root = (limit * chi_sq).sqrt();
            let weight = beyond.select(root.map2(chi_sq, |root, chi_sq| root / chi_sq), one);
            (beyond.select(root + root - limit, chi_sq), weight)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bundle::model::ObservationModel;
    use crate::bundle::rig::{RigCamera, RigModel, RigObservation};
    use crate::common::{frame, random, small_motion};

    /// The bundle's model is tested against numeric Jacobians.
    #[test]
    fn the_sums_equal_those_of_the_bundles_model() {
        let rig = crate::common::rig();
        let model = RigModel::new(&rig);
        for (seed, loss) in [(1, Loss::Squared), (2, Loss::Huber), (3, Loss::Huber)] {
            let (truth, observations) = frame(seed, 101, 1.0, 0.3, 0.5);
            let pose = small_motion(&mut random(seed), 0.1, 0.01) * truth;
            let normal = Packs::new(&rig, &observations, Simd::detect()).normal(&pose, loss);
            let (mut cost, mut gradient, mut hessian) = (0.0, [0.0; 6], [[0.0; 6]; 6]);
            for o in &observations {
                let observation = RigObservation::new(o.pixel.x, o.pixel.y, o.right_u, o.inv_sigma_sq);
                let (camera, point) = (RigCamera::new(pose), o.point_world.into());
                let chi_sq = model.chi_sq(&camera, &point, &observation);
                cost += 0.5 * loss.rho(chi_sq.unwrap_or(MAX_CHI_SQ), model.delta_sq(&observation));
                let Some(lin) = model.linearize(&camera, &point, &observation, loss) else { continue };
                for i in 0..6 {
                    gradient[i] += lin.camera_gradient[i];
                    for j in 0..=i {
                        hessian[i][j] += lin.camera_camera[i][j];
                    }
                }
            }
            let close = |a: f64, b: f64, scale: f64| assert!((a - b).abs() < 1e-12 * scale, "{a} {b}");
            close(normal.cost, cost, cost);
            for i in 0..6 {
                close(normal.gradient[i], gradient[i], 100.0 * hessian[i][i]);
                for j in 0..=i {
                    close(normal.hessian[i][j], hessian[i][j], (hessian[i][i] * hessian[j][j]).sqrt());
                }
            }
        }
    }
}
