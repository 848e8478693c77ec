//! How far a pose may be off: its 6x6 covariance, in the axes of the camera or in those of any other frame.

use crate::aliases::{Mat3, Mat6, Vec3};
use crate::se3::SE3;
use crate::so3::SO3;

/// Covariance of a camera pose along and about the axes of the left camera (x right, y down, z forward), at its center.
///
/// The order is that of the tangent of [`SE3`]: translation x, y, z (m), then rotation x, y, z (rad), of the error `e` in
/// `true_cam_from_world = exp(e) * cam_from_world`, which is `true_world_from_cam = world_from_cam * exp(-e)`. A correction of the
/// map that moves the camera takes its axes along and leaves this covariance as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseCovariance(Mat6);

/// Names of the six errors, in order.
const AXES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

impl PoseCovariance {
    /// Numbers of one triangle of the matrix, the diagonal included.
    pub const N: usize = 21;

    /// The covariance with these numbers in the axes of the camera; `None` if they are not symmetric and positive definite.
    pub fn new(in_camera: Mat6) -> Option<Self> {
        let scale = in_camera.diagonal().amax();
        let is_symmetric = (in_camera - in_camera.transpose()).amax() <= 1e-9 * scale;
        let symmetric = 0.5 * (in_camera + in_camera.transpose());
        let is_finite = symmetric.iter().all(|v| v.is_finite());
        (is_finite && is_symmetric && symmetric.cholesky().is_some()).then_some(Self(symmetric))
    }

    /// The matrix, in the axes of the camera.
    pub fn in_camera(&self) -> Mat6 {
        self.0
    }

    /// The matrix in other axes, as ROS's `PoseWithCovariance` has it: position along the axes of the parent frame, then rotation
    /// about its fixed axes. `parent_from_cam` is the rotation of the pose.
    pub fn in_parent(&self, parent_from_cam: &SO3) -> Mat6 {
        let turn = both(parent_from_cam.matrix());
        turn * self.0 * turn.transpose()
    }

    /// The covariance of a body that the camera is fixed to, along the axes of the body at its origin.
    #[must_use]
    pub fn of_body(&self, body_from_cam: &SE3) -> Self {
        let adjoint = body_from_cam.adjoint();
        let moved = adjoint * self.0 * adjoint.transpose();
        Self(0.5 * (moved + moved.transpose()))
    }

    /// The upper triangle, row by row, as [`PoseCovariance::names`] names it.
    pub fn triangle(&self) -> [f64; Self::N] {
        let mut places = upper();
        std::array::from_fn(|_| places.next().map_or(0.0, |place| self.0[place]))
    }

    /// The covariance with this upper triangle; `None` if it is not positive definite.
    pub fn of_triangle(triangle: &[f64; Self::N]) -> Option<Self> {
        let mut matrix = Mat6::zeros();
        for ((row, column), &value) in upper().zip(triangle) {
            matrix[(row, column)] = value;
            matrix[(column, row)] = value;
        }
        Self::new(matrix)
    }

    /// Names of the numbers of [`PoseCovariance::triangle`]: `xx`, `xy`, up to `rzrz`.
    pub fn names() -> impl Iterator<Item = String> {
        upper().map(|(row, column)| format!("{}{}", AXES[row], AXES[column]))
    }

    /// Standard deviations along the axes of the camera, meters.
    pub fn sigma_m(&self) -> Vec3 {
        self.0.diagonal().fixed_rows::<3>(0).map(f64::sqrt)
    }

    /// Standard deviations about the axes of the camera, degrees.
    pub fn sigma_deg(&self) -> Vec3 {
        self.0.diagonal().fixed_rows::<3>(3).map(|variance| variance.sqrt().to_degrees())
    }
}

/// Places of the upper triangle, row by row.
fn upper() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|row| (row..6).map(move |column| (row, column)))
}

/// The rotation of translations and rotations alike.
fn both(rotation: &Mat3) -> Mat6 {
    let mut turn = Mat6::zeros();
    turn.fixed_view_mut::<3, 3>(0, 0).copy_from(rotation);
    turn.fixed_view_mut::<3, 3>(3, 3).copy_from(rotation);
    turn
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aliases::Vec6;

    fn covariance() -> PoseCovariance {
        let root =
            Mat6::from_fn(|r, c| if r == c { 0.1 + r as f64 } else { 0.05 * (r as f64 - 2.0 * c as f64) });
        PoseCovariance::new(root * root.transpose()).unwrap()
    }

    /// `v` with `E[v v^T] = matrix` as the mean over the columns of its root, times six.
    fn roots(matrix: &Mat6) -> Vec<Vec6> {
        let root = matrix.cholesky().unwrap().l();
        (0..6).map(|i| root.column(i).into_owned()).collect()
    }

    #[test]
    fn the_triangle_gives_the_matrix_again_and_has_its_names() {
        let covariance = covariance();
        assert_eq!(PoseCovariance::of_triangle(&covariance.triangle()), Some(covariance));
        let names: Vec<String> = PoseCovariance::names().collect();
        assert_eq!(names.len(), PoseCovariance::N);
        assert_eq!((names[0].as_str(), names[8].as_str(), names[20].as_str()), ("xx", "yrx", "rzrz"));
        assert_eq!(covariance.triangle()[8], covariance.in_camera()[(1, 3)]);
    }

    /// Errors `e` of the stated form, carried out on poses, scatter as the conversion says.
    #[test]
    fn conversions_follow_from_the_error_of_the_pose() {
        let covariance = covariance();
        let world_from_cam = SE3::exp(&Vec6::new(4.0, -2.0, 7.0, 0.4, -1.1, 0.7));
        let body_from_cam = SE3::exp(&Vec6::new(1.0, 0.5, -2.0, 0.3, 0.9, -0.2));
        let (mut in_parent, mut of_body) = (Mat6::zeros(), Mat6::zeros());
        let step = 1e-6;
        for root in roots(&covariance.in_camera()) {
            let truth = world_from_cam * SE3::exp(&(-step * root));
            let turned = (truth.rotation * world_from_cam.rotation.inverse()).log() / step;
            let moved = (truth.translation - world_from_cam.translation) / step;
            let e = Vec6::new(moved.x, moved.y, moved.z, turned.x, turned.y, turned.z);
            in_parent += e * e.transpose();
            let (body, true_body) =
                (world_from_cam * body_from_cam.inverse(), truth * body_from_cam.inverse());
            let e = -(body.inverse() * true_body).log() / step;
            of_body += e * e.transpose();
        }
        let close = |a: Mat6, b: Mat6| assert!((a - b).amax() < 1e-4 * b.amax(), "{a} {b}");
        close(covariance.in_parent(&world_from_cam.rotation), in_parent);
        close(covariance.of_body(&body_from_cam).in_camera(), of_body);
    }

    #[test]
    fn what_is_no_covariance_is_refused() {
        let good = covariance().in_camera();
        let mut skew = good;
        skew[(0, 4)] += 1.0;
        let mut flat = good;
        flat[(2, 2)] = -1e-3;
        for bad in [skew, flat, good * f64::NAN, Mat6::zeros()] {
            assert_eq!(PoseCovariance::new(bad), None);
        }
    }
}
