//! "Bundle adjustment in the large" (Agarwal et al., ECCV 2010): camera model and file format.

use dsslam_optim::{Edge, Graph, Linearization, Loss, ObservationModel, Point};
use geometry::{Mat3, SO3, Vec3};

/// Rodrigues vector, translation, focal length and two radial coefficients; cameras look along -z.
#[derive(Clone, Debug)]
pub struct BalCamera {
    pub values: [f64; 9],
    rotation: Mat3,
    left_jacobian: Mat3,
}

impl BalCamera {
    pub fn new(values: [f64; 9]) -> Self {
        let omega = Vec3::new(values[0], values[1], values[2]);
        Self { values, rotation: *SO3::exp(&omega).matrix(), left_jacobian: SO3::left_jacobian(&omega) }
    }
}

pub struct BalModel;

struct Projection {
    rotated: Vec3,
    depth: f64,
    p: [f64; 2],
    n: f64,
    distortion: f64,
    r: [f64; 2],
}

impl BalModel {
    fn project(&self, camera: &BalCamera, point: &Point, pixel: &[f64; 2]) -> Projection {
        let [_, _, _, tx, ty, tz, f, k1, k2] = camera.values;
        let rotated = camera.rotation * Vec3::from(*point);
        let depth = rotated.z + tz;
        let p = [-(rotated.x + tx) / depth, -(rotated.y + ty) / depth];
        let n = p[0] * p[0] + p[1] * p[1];
        let distortion = 1.0 + k1 * n + k2 * n * n;
        let r = [f * distortion * p[0] - pixel[0], f * distortion * p[1] - pixel[1]];
        Projection { rotated, depth, p, n, distortion, r }
    }

    pub fn residual(&self, camera: &BalCamera, point: &Point, pixel: &[f64; 2]) -> [f64; 2] {
        self.project(camera, point, pixel).r
    }

    /// Jacobians of the two residuals in camera and point.
    pub fn jacobians(
        &self,
        camera: &BalCamera,
        point: &Point,
        pixel: &[f64; 2],
    ) -> ([[f64; 9]; 2], [[f64; 3]; 2]) {
        let [.., f, k1, k2] = camera.values;
        let Projection { rotated, depth, p, n, distortion, .. } = self.project(camera, point, pixel);
        let by_omega = -SO3::hat(&rotated) * camera.left_jacobian;
        let slope = 2.0 * (k1 + 2.0 * k2 * n);
        let (mut by_camera, mut by_point) = ([[0.0; 9]; 2], [[0.0; 3]; 2]);
        for i in 0..2 {
            let by_p = [0, 1].map(|j| f * (p[i] * slope * p[j] + if i == j { distortion } else { 0.0 }));
            // p = -(x, y) / z.
            let by_cam = [-by_p[0] / depth, -by_p[1] / depth, -(by_p[0] * p[0] + by_p[1] * p[1]) / depth];
            let by_cam = Vec3::from(by_cam).transpose();
            let (by_omega, by_x) = (by_cam * by_omega, by_cam * camera.rotation);
            for k in 0..3 {
                by_camera[i][k] = by_omega[k];
                by_camera[i][k + 3] = by_cam[k];
                by_point[i][k] = by_x[k];
            }
            by_camera[i][6] = distortion * p[i];
            by_camera[i][7] = f * n * p[i];
            by_camera[i][8] = f * n * n * p[i];
        }
        (by_camera, by_point)
    }
}

impl ObservationModel<9> for BalModel {
    type Camera = BalCamera;
    type Observation = [f64; 2];

    fn moved(&self, camera: &BalCamera, step: &[f64; 9]) -> BalCamera {
        BalCamera::new(std::array::from_fn(|i| camera.values[i] + step[i]))
    }

    fn chi_sq(&self, camera: &BalCamera, point: &Point, pixel: &[f64; 2]) -> Option<f64> {
        let r = self.residual(camera, point, pixel);
        Some(r[0] * r[0] + r[1] * r[1])
    }

    fn delta_sq(&self, _: &[f64; 2]) -> f64 {
        f64::INFINITY
    }

    fn linearize(
        &self,
        camera: &BalCamera,
        point: &Point,
        pixel: &[f64; 2],
        _: Loss,
    ) -> Option<Linearization<9>> {
        let (by_camera, by_point) = self.jacobians(camera, point, pixel);
        let r = self.residual(camera, point, pixel);
        Some(Linearization::from_jacobians(&r, &by_camera, &by_point, 1.0))
    }
}

/// Reads a problem: counts, then camera, point, x, y per observation, then all values.
pub fn parse(text: &str) -> Graph<BalCamera, [f64; 2]> {
    let mut numbers = text.split_ascii_whitespace().map(|word| word.parse::<f64>().expect("a number"));
    let mut next = || numbers.next().expect("another number");
    let [n_cameras, n_points, n] = [next() as usize, next() as usize, next() as usize];
    let edges = (0..n)
        .map(|_| Edge { camera: next() as u32, point: next() as u32, observation: [next(), next()] })
        .collect();
    let cameras = (0..n_cameras).map(|_| BalCamera::new(std::array::from_fn(|_| next()))).collect();
    let points = (0..n_points).map(|_| std::array::from_fn(|_| next())).collect();
    Graph { fixed: vec![false; n_cameras], cameras, points, edges }
}
