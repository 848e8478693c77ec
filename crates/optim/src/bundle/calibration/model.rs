//! How a rig with errors of its calibration sees a point, with derivatives by pose, point and errors.

use geometry::StereoRig;

use super::super::model::{Linearization, ObservationModel, Point};
use super::super::rig::{MIN_DEPTH_M, RigCamera, RigObservation};
use super::super::schur::border::{Rows, SharedModel};
use super::{CalibrationProblem, CalibrationVector, N_CALIBRATION};
use crate::robust::{Loss, MAX_CHI_SQ};

/// The rig with errors of its calibration.
#[derive(Clone, Copy, Debug)]
pub(super) struct CalibratedRig {
    rig: StereoRig,
    pub(super) errors: CalibrationVector,
    expected: CalibrationVector,
    information: CalibrationVector,
}

/// What a point is seen as, and what that is made from.
struct Seen {
    p: [f64; 3],
    inv_z: f64,
    /// Normalized places in the left and the right image: x, y and the column on the right.
    x: f64,
    y: f64,
    right_x: f64,
    r: [f64; 3],
    chi_sq: f64,
}

impl CalibratedRig {
    pub(super) fn new(problem: &CalibrationProblem) -> Self {
        Self {
            rig: problem.bundle.rig,
            errors: [0.0; N_CALIBRATION],
            expected: problem.expected,
            information: problem.sigma.map(|sigma| 1.0 / (sigma * sigma)),
        }
    }

    pub(super) fn prior_cost(&self) -> f64 {
        let terms =
            (0..N_CALIBRATION).map(|i| self.information[i] * (self.errors[i] - self.expected[i]).powi(2));
        0.5 * terms.sum::<f64>()
    }

    fn focal(&self) -> (f64, f64) {
        let factor = self.errors[0].exp();
        (self.rig.camera.fx * factor, self.rig.camera.fy * factor)
    }

    #[inline(always)]
    fn see(&self, camera: &RigCamera, point: &Point, o: &RigObservation) -> Option<Seen> {
        let p = camera.transform(point);
        if !(p[2] > MIN_DEPTH_M) {
            return None;
        }
        let [_, dcx, dcy, k1, offset, roll] = self.errors;
        let (fx, fy) = self.focal();
        let inv_z = 1.0 / p[2];
        let (x, y) = (p[0] * inv_z, p[1] * inv_z);
        let right_x = x - self.rig.baseline_m * inv_z;
        let radial = 1.0 + k1 * (x * x + y * y);
        let right_radial = 1.0 + k1 * (right_x * right_x + y * y);
        let r = o.residual([
            fx * x * radial + self.rig.camera.cx + dcx,
            fy * y * radial + self.rig.camera.cy + dcy,
            fx * (right_x * right_radial + roll * y) + self.rig.camera.cx + dcx + offset,
        ]);
        let [w, _, w_right] = o.information();
        let chi_sq = w * (r[0] * r[0] + r[1] * r[1]) + w_right * (r[2] * r[2]);
        (chi_sq <= MAX_CHI_SQ).then_some(Seen { p, inv_z, x, y, right_x, r, chi_sq })
    }
}

impl ObservationModel<6> for CalibratedRig {
    type Camera = RigCamera;
    type Observation = RigObservation;

    fn moved(&self, camera: &RigCamera, step: &[f64; 6]) -> RigCamera {
        camera.moved(step)
    }

    #[inline(always)]
    fn chi_sq(&self, camera: &RigCamera, point: &Point, observation: &RigObservation) -> Option<f64> {
        self.see(camera, point, observation).map(|seen| seen.chi_sq)
    }

    #[inline(always)]
    fn delta_sq(&self, observation: &RigObservation) -> f64 {
        observation.chi_sq_limit()
    }

    #[inline(always)]
    fn linearize(
        &self,
        camera: &RigCamera,
        point: &Point,
        observation: &RigObservation,
        loss: Loss,
    ) -> Option<Linearization<6>> {
        let rows = self.rows(camera, point, observation, loss)?;
        Some(Linearization::from_jacobians(&rows.residual, &rows.by_camera, &rows.by_point, 1.0))
    }
}

impl SharedModel<6, N_CALIBRATION> for CalibratedRig {
    #[inline(always)]
    fn rows(
        &self,
        camera: &RigCamera,
        point: &Point,
        o: &RigObservation,
        loss: Loss,
    ) -> Option<Rows<6, N_CALIBRATION>> {
        let Seen { p, inv_z, x, y, right_x, r, chi_sq } = self.see(camera, point, o)?;
        let root = o.information().map(|w| (w * loss.weight(chi_sq, o.chi_sq_limit())).sqrt());
        let [.., k1, _, roll] = self.errors;
        let (fx, fy) = self.focal();
        let (r_sq, right_r_sq) = (x * x + y * y, right_x * right_x + y * y);
        let (radial, right_radial) = (1.0 + k1 * r_sq, 1.0 + k1 * right_r_sq);
        let mixed = 2.0 * k1 * y;
        // By the normalized place (column of its own image, row).
        let by_place = [
            [fx * (radial + 2.0 * k1 * x * x), fx * mixed * x],
            [fy * mixed * x, fy * (radial + mixed * y)],
            [fx * (right_radial + 2.0 * k1 * right_x * right_x), fx * (mixed * right_x + roll)],
        ];
        let by_point_cam: [[f64; 3]; 3] = std::array::from_fn(|row| {
            let [a, b] = by_place[row];
            let column = if row == 2 { right_x } else { x };
            [a * inv_z, b * inv_z, -(a * column + b * y) * inv_z]
        });
        let by_errors = [
            [fx * x * radial, 1.0, 0.0, fx * x * r_sq, 0.0, 0.0],
            [fy * y * radial, 0.0, 1.0, fy * y * r_sq, 0.0, 0.0],
            [fx * (right_x * right_radial + roll * y), 1.0, 0.0, fx * right_x * right_r_sq, 1.0, fx * y],
        ];
        Some(Rows {
            residual: std::array::from_fn(|row| root[row] * r[row]),
            by_camera: std::array::from_fn(|row| {
                let [a, b, c] = by_point_cam[row].map(|v| root[row] * v);
                [a, b, c, p[1] * c - p[2] * b, p[2] * a - p[0] * c, p[0] * b - p[1] * a]
            }),
            by_point: std::array::from_fn(|row| {
                camera.turned_back(&by_point_cam[row].map(|v| root[row] * v))
            }),
            by_shared: std::array::from_fn(|row| by_errors[row].map(|v| root[row] * v)),
        })
    }

    fn prior(&self) -> [(f64, f64); N_CALIBRATION] {
        std::array::from_fn(|i| {
            (self.information[i] * (self.errors[i] - self.expected[i]), self.information[i])
        })
    }

    fn shared_moved(&self, step: &[f64; N_CALIBRATION]) -> Self {
        Self { errors: std::array::from_fn(|i| self.errors[i] + step[i]), ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{ERRORS, problem};
    use super::*;
    use crate::bundle::edge;

    #[test]
    fn derivatives_equal_differences() {
        let whole = problem(3, 0.5, 0.3);
        let model = CalibratedRig { errors: ERRORS, ..CalibratedRig::new(&whole) };
        let mut n_compared = 0;
        for o in whole.bundle.observations.iter().step_by(97) {
            let camera = RigCamera::new(whole.bundle.cameras[o.camera as usize]);
            let point: Point = whole.bundle.points[o.point as usize].into();
            let observation = edge(o).observation;
            let at = |model: &CalibratedRig, camera: &RigCamera, point: &Point| {
                model.rows(camera, point, &observation, Loss::Squared).unwrap()
            };
            let rows = at(&model, &camera, &point);
            let compare = |analytic: &dyn Fn(usize) -> f64, plus: [f64; 3], minus: [f64; 3], h: f64| {
                for row in 0..3 {
                    let numeric = (plus[row] - minus[row]) / (2.0 * h);
                    let analytic = analytic(row);
                    assert!(
                        (numeric - analytic).abs() < 1e-4 * (1.0 + analytic.abs()),
                        "{numeric} {analytic}"
                    );
                }
            };
            for i in 0..6 {
                let h = 1e-5;
                let step = |h: f64| std::array::from_fn(|k| if k == i { h } else { 0.0 });
                let moved = |h: f64| at(&model, &camera.moved(&step(h)), &point).residual;
                compare(&|row| rows.by_camera[row][i], moved(h), moved(-h), h);
                let changed = |h: f64| at(&model.shared_moved(&step(h)), &camera, &point).residual;
                compare(&|row| rows.by_shared[row][i], changed(h), changed(-h), h);
                if i < 3 {
                    let shifted = |h: f64| {
                        let mut point = point;
                        point[i] += h;
                        at(&model, &camera, &point).residual
                    };
                    compare(&|row| rows.by_point[row][i], shifted(h), shifted(-h), h);
                }
                n_compared += 1;
            }
        }
        assert!(n_compared > 300, "{n_compared}");
    }
}
