//! The rectified stereo rig as a model of the Schur solver; a monocular measurement lacks the third residual.
//!
//! A camera moves by `cam_from_world <- exp([rho; phi]) cam_from_world`, so a point p in the camera moves by
//! rho + phi x p, and with A = J^T W J of the projection J = d(u, v, u_right)/dp (3x3), B = [p]x A and rotation R:
//! camera block [A, .; B, B [p]x^T], camera-point block [A; B] R, point block R^T A R.

use geometry::{Pinhole, SE3, StereoRig, Vec6};

use super::model::{Linearization, ObservationModel, Point};
use crate::robust::{CHI2_MONO, CHI2_STEREO, Loss, MAX_CHI_SQ};

/// Points nearer to the image plane than this count as behind the camera, meters.
pub(crate) const MIN_DEPTH_M: f64 = 1e-4;

/// A pose with its matrix unpacked.
#[derive(Clone, Copy, Debug)]
pub struct RigCamera {
    /// The pose.
    pub cam_from_world: SE3,
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

impl RigCamera {
    /// Unpacks a pose.
    pub fn new(cam_from_world: SE3) -> Self {
        let m = cam_from_world.rotation.matrix();
        let rotation = std::array::from_fn(|r| std::array::from_fn(|c| m[(r, c)]));
        Self { cam_from_world, rotation, translation: cam_from_world.translation.into() }
    }

    /// The point in the camera's frame, meters.
    #[inline(always)]
    pub fn transform(&self, point_world: &Point) -> [f64; 3] {
        let (r, t, x) = (&self.rotation, &self.translation, point_world);
        std::array::from_fn(|i| r[i][0] * x[0] + r[i][1] * x[1] + r[i][2] * x[2] + t[i])
    }
}

impl RigCamera {
    /// The camera moved by a step of its tangent space, `exp(step) cam_from_world`.
    pub(crate) fn moved(&self, step: &[f64; 6]) -> Self {
        Self::new((SE3::exp(&Vec6::from(*step)) * self.cam_from_world).normalized())
    }

    /// A row vector of the camera's frame in that of the world.
    #[inline(always)]
    pub(crate) fn turned_back(&self, row: &[f64; 3]) -> [f64; 3] {
        let r = &self.rotation;
        std::array::from_fn(|k| row[0] * r[0][k] + row[1] * r[1][k] + row[2] * r[2][k])
    }
}

/// One measurement of the rig.
#[derive(Clone, Copy, Debug)]
pub struct RigObservation {
    u: f64,
    v: f64,
    right_u: f64,
    inv_sigma_sq: f64,
    /// `inv_sigma_sq` where a right measurement exists, else 0.
    right_inv_sigma_sq: f64,
}

impl RigObservation {
    /// Pixel (u, v), column in the right image (NaN: none), inverse variance in 1/px^2.
    pub fn new(u: f64, v: f64, right_u: f64, inv_sigma_sq: f64) -> Self {
        let has_right = !right_u.is_nan();
        Self {
            u,
            v,
            right_u: if has_right { right_u } else { 0.0 },
            inv_sigma_sq,
            right_inv_sigma_sq: if has_right { inv_sigma_sq } else { 0.0 },
        }
    }

    /// Predicted minus measured left column, row and right column, pixels; the last does not count where its information is 0.
    #[inline(always)]
    pub(crate) fn residual(&self, [u, v, right_u]: [f64; 3]) -> [f64; 3] {
        [u - self.u, v - self.v, right_u - self.right_u]
    }

    /// Inverse variances of left column, row and right column, 1/px^2.
    #[inline(always)]
    pub(crate) fn information(&self) -> [f64; 3] {
        [self.inv_sigma_sq, self.inv_sigma_sq, self.right_inv_sigma_sq]
    }

    /// The 95 % limit of the squared whitened error.
    #[inline(always)]
    pub(crate) fn chi_sq_limit(&self) -> f64 {
        if self.right_inv_sigma_sq > 0.0 { CHI2_STEREO } else { CHI2_MONO }
    }
}

/// The intrinsics shared by all cameras of a problem.
#[derive(Clone, Copy, Debug)]
pub struct RigModel {
    camera: Pinhole,
    bf: f64,
    /// delta^2 of Huber's loss as a part of the 95 % limit.
    huber: f64,
}

/// Camera-frame point, inverse depth and residuals in pixels (predicted - measured).
struct Residual {
    p: [f64; 3],
    inv_z: f64,
    r: [f64; 3],
    chi_sq: f64,
}

impl RigModel {
    /// The model of a rig.
    pub fn new(rig: &StereoRig) -> Self {
        Self { camera: rig.camera, bf: rig.bf(), huber: 1.0 }
    }

    /// The model with another delta^2 of Huber's loss, as a part of the 95 % limit.
    #[must_use]
    pub fn with_huber(self, huber: f64) -> Self {
        Self { huber, ..self }
    }

    #[inline(always)]
    fn residual(&self, camera: &RigCamera, point: &Point, o: &RigObservation) -> Option<Residual> {
        let p = camera.transform(point);
        if !(p[2] > MIN_DEPTH_M) {
            return None;
        }
        let inv_z = 1.0 / p[2];
        let Pinhole { fx, fy, cx, cy } = self.camera;
        let u = fx * p[0] * inv_z + cx;
        let v = fy * p[1] * inv_z + cy;
        let r = [u - o.u, v - o.v, u - self.bf * inv_z - o.right_u];
        let chi_sq = o.inv_sigma_sq * (r[0] * r[0] + r[1] * r[1]) + o.right_inv_sigma_sq * (r[2] * r[2]);
        (chi_sq <= MAX_CHI_SQ).then_some(Residual { p, inv_z, r, chi_sq })
    }
}

#[inline(always)]
fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

impl ObservationModel<6> for RigModel {
    type Camera = RigCamera;
    type Observation = RigObservation;

    fn moved(&self, camera: &RigCamera, step: &[f64; 6]) -> RigCamera {
        camera.moved(step)
    }

    #[inline(always)]
    fn chi_sq(&self, camera: &RigCamera, point: &Point, observation: &RigObservation) -> Option<f64> {
        self.residual(camera, point, observation).map(|residual| residual.chi_sq)
    }

    #[inline(always)]
    fn delta_sq(&self, observation: &RigObservation) -> f64 {
        self.huber * observation.chi_sq_limit()
    }

    #[inline(always)]
    fn linearize(
        &self,
        camera: &RigCamera,
        point: &Point,
        o: &RigObservation,
        loss: Loss,
    ) -> Option<Linearization<6>> {
        let Residual { p, inv_z, r, chi_sq } = self.residual(camera, point, o)?;
        let robust = loss.weight(chi_sq, self.delta_sq(o));
        let (w, w_right) = (robust * o.inv_sigma_sq, robust * o.right_inv_sigma_sq);

        // Rows of J: (a, 0, b), (0, c, d), (a, 0, e).
        let (a, c) = (self.camera.fx * inv_z, self.camera.fy * inv_z);
        let (b, d) = (-a * p[0] * inv_z, -c * p[1] * inv_z);
        let e = b + self.bf * inv_z * inv_z;
        let a02 = a * (w * b + w_right * e);
        let a12 = w * c * d;
        let a22 = w * (b * b + d * d) + w_right * (e * e);
        let block_a = [[a * a * (w + w_right), 0.0, a02], [0.0, w * c * c, a12], [a02, a12, a22]];
        let g =
            [a * (w * r[0] + w_right * r[2]), w * c * r[1], w * (b * r[0] + d * r[1]) + w_right * e * r[2]];

        // B = [p]x A by columns (A is symmetric, so its rows serve).
        let b_t = [cross(&p, &block_a[0]), cross(&p, &block_a[1]), cross(&p, &block_a[2])];
        let block_b: [[f64; 3]; 3] = std::array::from_fn(|i| [b_t[0][i], b_t[1][i], b_t[2][i]]);
        let lower: [[f64; 3]; 3] = std::array::from_fn(|i| cross(&p, &block_b[i]));
        let camera_camera = std::array::from_fn(|i| {
            std::array::from_fn(|j| match (i < 3, j < 3) {
                (true, true) => block_a[i][j],
                (true, false) => 0.0,
                (false, true) => block_b[i - 3][j],
                (false, false) => lower[i - 3][j - 3],
            })
        });

        let rot = &camera.rotation;
        // (A R)^T and (B R)^T: row k holds the products with column k of R.
        let point_camera: [[f64; 6]; 3] = std::array::from_fn(|k| {
            std::array::from_fn(|i| {
                let row = if i < 3 { &block_a[i] } else { &block_b[i - 3] };
                row[0] * rot[0][k] + row[1] * rot[1][k] + row[2] * rot[2][k]
            })
        });
        let pp = |i: usize, j: usize| {
            rot[0][i] * point_camera[j][0] + rot[1][i] * point_camera[j][1] + rot[2][i] * point_camera[j][2]
        };
        let torque = cross(&p, &g);
        Some(Linearization {
            camera_camera,
            point_camera,
            point_point: [pp(0, 0), pp(1, 0), pp(1, 1), pp(2, 0), pp(2, 1), pp(2, 2)],
            camera_gradient: [g[0], g[1], g[2], torque[0], torque[1], torque[2]],
            point_gradient: std::array::from_fn(|k| rot[0][k] * g[0] + rot[1][k] * g[1] + rot[2][k] * g[2]),
        })
    }
}
