//! From the axes of a camera (x right, y down, z forward) to those of a body in ROS (x forward, y left, z up): numbers change places and
//! signs, and no digit changes.

use bag::out::Pose;
use geometry::{Mat6, PoseCovariance, SE3, SO3, Vec3};

/// A vector along the axes of the camera, along those of ROS.
pub(super) fn vector(v: &Vec3) -> Vec3 {
    // Not -x, which would make -0 out of 0.
    Vec3::new(v.z, 0.0 - v.x, 0.0 - v.y)
}

/// Rotation from the axes of the camera to those of ROS.
fn turn() -> SO3 {
    SO3::from_matrix_unchecked(geometry::Mat3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0))
}

/// A pose between two frames with the axes of a camera as the pose between the same frames with those of ROS.
pub(super) fn pose(parent_from_child: &SE3) -> Pose {
    let q = parent_from_child.rotation.to_quaternion();
    Pose { position: vector(&parent_from_child.translation), quaternion: [q.k, 0.0 - q.i, 0.0 - q.j, q.w] }
}

/// The camera in the body: it lies in the body's origin.
pub(super) fn optical_in_body() -> Pose {
    let q = turn().to_quaternion();
    Pose { position: Vec3::zeros(), quaternion: [q.i, q.j, q.k, q.w] }
}

/// A covariance along and about the axes of a frame in ROS's axes; `parent_from_cam` leads to this frame with the axes of a camera.
pub(super) fn covariance(of_pose: &PoseCovariance, parent_from_cam: &SO3) -> Mat6 {
    of_pose.in_parent(&(turn() * *parent_from_cam))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forward_is_x_left_is_y_and_up_is_z() {
        assert_eq!(vector(&Vec3::z()), Vec3::x());
        assert_eq!(vector(&-Vec3::x()), Vec3::y());
        assert_eq!(vector(&-Vec3::y()), Vec3::z());
        assert_eq!(turn() * Vec3::new(1.0, 2.0, 3.0), vector(&Vec3::new(1.0, 2.0, 3.0)));
    }

    #[test]
    fn a_pose_in_other_axes_moves_points_likewise() {
        let parent_from_child = SE3::new(SO3::exp(&Vec3::new(0.3, -0.7, 0.2)), Vec3::new(1.0, -2.0, 3.0));
        let found = pose(&parent_from_child);
        let [x, y, z, w] = found.quaternion;
        let quaternion = geometry::Quaternion::from_quaternion([x, y, z, w].into());
        let in_ros = SE3::new(SO3::from_quaternion(&quaternion), found.position);
        let point = Vec3::new(0.5, 4.0, -1.5);
        let difference = in_ros * vector(&point) - vector(&(parent_from_child * point));
        assert!(difference.norm() < 1e-14, "{difference}");
        let q = parent_from_child.rotation.to_quaternion();
        assert_eq!(found.quaternion, [q.k, -q.i, -q.j, q.w], "no digit changes");
        let [x, y, z, w] = optical_in_body().quaternion;
        let quaternion = geometry::Quaternion::from_quaternion([x, y, z, w].into());
        assert!((SO3::from_quaternion(&quaternion) * Vec3::z() - Vec3::x()).norm() < 1e-15);
    }

    #[test]
    fn a_covariance_turns_with_the_camera() {
        // The depth is uncertain, and the turn about the axis of sight.
        let of_camera = Mat6::from_diagonal(&geometry::Vec6::new(1.0, 2.0, 9.0, 0.1, 0.2, 0.9));
        let of_camera = PoseCovariance::new(of_camera).unwrap();
        let ahead = covariance(&of_camera, &SO3::identity()).diagonal();
        assert_eq!(ahead.as_slice(), [9.0, 1.0, 2.0, 0.9, 0.1, 0.2]);
        // A quarter to the left: forward is now y.
        let left = SO3::exp(&Vec3::new(0.0, -std::f64::consts::FRAC_PI_2, 0.0));
        let found = covariance(&of_camera, &left).diagonal();
        let expected = geometry::Vec6::new(1.0, 9.0, 2.0, 0.1, 0.9, 0.2);
        assert!((found - expected).norm() < 1e-12, "{found}");
    }
}
