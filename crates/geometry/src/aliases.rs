//! Short names for the fixed-size vectors and matrices of the whole system; all of them hold `f64`.

use nalgebra::{SMatrix, SVector, UnitQuaternion};

/// Two numbers, most often a pixel or a normalized image point.
pub type Vec2 = SVector<f64, 2>;
/// Three numbers, most often a point or a direction.
pub type Vec3 = SVector<f64, 3>;
/// Four numbers, most often a homogeneous point.
pub type Vec4 = SVector<f64, 4>;
/// A tangent vector of [`crate::SE3`]: translation part, then rotation part.
pub type Vec6 = SVector<f64, 6>;
/// A tangent vector of [`crate::Sim3`]: translation part, rotation part, logarithm of the scale.
pub type Vec7 = SVector<f64, 7>;
/// A 2 by 2 matrix.
pub type Mat2 = SMatrix<f64, 2, 2>;
/// A 3 by 3 matrix.
pub type Mat3 = SMatrix<f64, 3, 3>;
/// A 4 by 4 matrix, most often homogeneous.
pub type Mat4 = SMatrix<f64, 4, 4>;
/// A 6 by 6 matrix, acting on tangent vectors of [`crate::SE3`].
pub type Mat6 = SMatrix<f64, 6, 6>;
/// A 7 by 7 matrix, acting on tangent vectors of [`crate::Sim3`].
pub type Mat7 = SMatrix<f64, 7, 7>;
/// A 2 by 3 matrix: the derivative of a pixel by a point.
pub type Mat2x3 = SMatrix<f64, 2, 3>;
/// A 3 by 6 matrix: the derivative of a point by a pose.
pub type Mat3x6 = SMatrix<f64, 3, 6>;
/// A 3 by 4 matrix: a projection matrix or a pose without its last row.
pub type Mat3x4 = SMatrix<f64, 3, 4>;
/// A rotation as a quaternion of unit length.
pub type Quaternion = UnitQuaternion<f64>;
