//! Singular value decomposition of small square matrices by one-sided Jacobi rotations (Hestenes 1958).
//!
//! Precise for small singular values, too, bounded in its work, and the same bits everywhere.

use crate::aliases::{Mat3, Vec3};
use nalgebra::{Const, DimMin, Dyn, OMatrix, SMatrix, SVector};

/// The right half of `A = U S V^T`, singular values in descending order.
pub(crate) struct RightSvd<const N: usize> {
    /// `A V = U S`: orthogonal columns with the singular values as lengths.
    pub(crate) images: SMatrix<f64, N, N>,
    /// `V`.
    pub(crate) right: SMatrix<f64, N, N>,
    /// The singular values.
    pub(crate) values: SVector<f64, N>,
}

impl<const N: usize> RightSvd<N> {
    /// Decomposes a matrix; `None` if it has a number that is not finite.
    pub(crate) fn new(matrix: &SMatrix<f64, N, N>) -> Option<Self> {
        if !matrix.iter().all(|v| v.is_finite()) {
            return None;
        }
        let unit = matrix.amax();
        if unit == 0.0 {
            let (images, right, values) = (*matrix, SMatrix::identity(), SVector::zeros());
            return Some(Self { images, right, values });
        }
        let (images, right) = orthogonalised(matrix / unit);
        let norms: [f64; N] = std::array::from_fn(|i| images.column(i).norm());
        let mut order: [usize; N] = std::array::from_fn(|i| i);
        order.sort_by(|&i, &j| norms[j].total_cmp(&norms[i]));
        Some(Self {
            images: SMatrix::from_fn(|i, j| images[(i, order[j])] * unit),
            right: SMatrix::from_fn(|i, j| right[(i, order[j])]),
            values: SVector::from_fn(|j, _| norms[order[j]] * unit),
        })
    }

    /// The unit vector that the matrix shortens most.
    pub(crate) fn null_vector(&self) -> SVector<f64, N> {
        self.right.column(N - 1).into_owned()
    }
}

/// Rotates pairs of columns until all are orthogonal; returns them and the product of the rotations.
fn orthogonalised<const N: usize>(matrix: SMatrix<f64, N, N>) -> (SMatrix<f64, N, N>, SMatrix<f64, N, N>) {
    const MAX_SWEEPS: usize = 40;
    let tolerance = N as f64 * f64::EPSILON;
    let (mut images, mut right) = (matrix, SMatrix::<f64, N, N>::identity());
    for _ in 0..MAX_SWEEPS {
        let mut rotated = false;
        for p in 0..N {
            for q in p + 1..N {
                let (alpha, beta) = (images.column(p).norm_squared(), images.column(q).norm_squared());
                let gamma = images.column(p).dot(&images.column(q));
                if gamma.abs() <= tolerance * (alpha * beta).sqrt() {
                    continue;
                }
                let zeta = (beta - alpha) / (2.0 * gamma);
                let tangent = 1.0_f64.copysign(zeta) / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
                let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
                rotate_columns(&mut images, p, q, cosine, cosine * tangent);
                rotate_columns(&mut right, p, q, cosine, cosine * tangent);
                rotated = true;
            }
        }
        if !rotated {
            break;
        }
    }
    (images, right)
}

#[inline]
fn rotate_columns<const N: usize>(m: &mut SMatrix<f64, N, N>, p: usize, q: usize, cosine: f64, sine: f64) {
    for i in 0..N {
        let (a, b) = (m[(i, p)], m[(i, q)]);
        m[(i, p)] = cosine * a - sine * b;
        m[(i, q)] = sine * a + cosine * b;
    }
}

/// The triangular factor of a tall matrix (at least `N` rows), which has the same right singular vectors and values.
pub(crate) fn triangular_factor<const N: usize>(
    tall: OMatrix<f64, Dyn, Const<N>>,
) -> Option<SMatrix<f64, N, N>>
where
    Dyn: DimMin<Const<N>, Output = Dyn>,
{
    if tall.nrows() < N || !tall.iter().all(|v| v.is_finite()) {
        return None;
    }
    let r = tall.qr().unpack_r();
    Some(SMatrix::from_fn(|i, j| r[(i, j)]))
}

/// `A = U S V^T` with two rotations `U`, `V`; the third singular value takes the sign of `det(A)`.
pub(crate) struct RotationSvd {
    pub(crate) u: Mat3,
    pub(crate) values: Vec3,
    pub(crate) v: Mat3,
}

impl RotationSvd {
    /// Decomposes a matrix, with any choice of axes where its rank leaves one; `None` if a number is not finite.
    pub(crate) fn new(matrix: &Mat3) -> Option<Self> {
        let svd = RightSvd::new(matrix)?;
        let first = svd.images.column(0).try_normalize(0.0).unwrap_or_else(Vec3::x);
        let across = svd.images.column(1).into_owned();
        let second =
            across.try_normalize(f64::EPSILON * svd.values[0]).unwrap_or_else(|| any_orthogonal(&first));
        let (v1, v2) = (svd.right.column(0).into_owned(), svd.right.column(1).into_owned());
        let (u3, v3) = (first.cross(&second), v1.cross(&v2));
        let third = u3.dot(&(matrix * v3));
        Some(Self {
            u: Mat3::from_columns(&[first, second, u3]),
            values: Vec3::new(svd.values[0], svd.values[1], third),
            v: Mat3::from_columns(&[v1, v2, v3]),
        })
    }
}

fn any_orthogonal(unit: &Vec3) -> Vec3 {
    unit.cross(&Vec3::ith(unit.iamin(), 1.0)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check_right<const N: usize>(matrix: &SMatrix<f64, N, N>) {
        let svd = RightSvd::new(matrix).unwrap();
        assert!(svd.right.iter().chain(svd.images.iter()).all(|v| v.is_finite()));
        let unit = if matrix.amax() == 0.0 { 1.0 } else { matrix.amax() };
        assert!((svd.right.transpose() * svd.right - SMatrix::identity()).amax() < 1e-14);
        let (images, values) = (svd.images / unit, svd.values / unit);
        assert!((matrix / unit * svd.right - images).amax() < 1e-14);
        let gram = images.transpose() * images - SMatrix::from_diagonal(&values.map(|s| s * s));
        assert!(gram.amax() < 1e-14);
        assert!((1..N).all(|i| svd.values[i - 1] >= svd.values[i]));
    }

    proptest! {
        #[test]
        fn factors_multiply_to_the_matrix(entries in prop::array::uniform16(-1.0..1.0), small in 0..12) {
            let mut matrix = SMatrix::<f64, 4, 4>::from_row_slice(&entries);
            let dependent = matrix.column(0) + matrix.column(1);
            matrix.set_column(2, &(dependent + matrix.column(2) * 10.0_f64.powi(-2 * small)));
            check_right(&matrix);
            check_right(&(matrix * 1e-200));
        }

        #[test]
        fn rotations_on_both_sides_of_a_diagonal(entries in prop::array::uniform9(-1.0..1.0)) {
            let matrix = Mat3::from_row_slice(&entries);
            let svd = RotationSvd::new(&matrix).unwrap();
            for rotation in [svd.u, svd.v] {
                prop_assert!((rotation.determinant() - 1.0).abs() < 1e-14);
                prop_assert!((rotation.transpose() * rotation - Mat3::identity()).amax() < 1e-14);
            }
            prop_assert!((svd.u * Mat3::from_diagonal(&svd.values) * svd.v.transpose() - matrix).amax() < 1e-14);
            prop_assert!((svd.values.product() - matrix.determinant()).abs() < 1e-14);
        }
    }

    #[test]
    fn tiny_singular_values_keep_their_relative_precision() {
        let scale = SMatrix::<f64, 3, 3>::from_diagonal(&Vec3::new(1.0, 1e-9, 1e-18));
        let left = *crate::SO3::exp(&Vec3::new(0.3, -0.2, 0.9)).matrix();
        let values = RightSvd::new(&(left * scale)).unwrap().values;
        assert!((values[1] / 1e-9 - 1.0).abs() < 1e-14 && (values[2] / 1e-18 - 1.0).abs() < 1e-14);
    }

    #[test]
    fn rank_one_zero_and_broken_matrices_are_handled() {
        let rank_one = Vec3::new(1.0, 2.0, -1.0) * Vec3::new(0.5, 0.1, 3.0).transpose();
        for matrix in [rank_one, Mat3::zeros()] {
            check_right(&matrix);
            let svd = RotationSvd::new(&matrix).unwrap();
            assert!((svd.u * Mat3::from_diagonal(&svd.values) * svd.v.transpose() - matrix).amax() < 1e-14);
            assert!((svd.u.determinant() - 1.0).abs() < 1e-14 && (svd.v.determinant() - 1.0).abs() < 1e-14);
        }
        assert!(RightSvd::new(&Mat3::from_element(f64::NAN)).is_none());
        assert!(RotationSvd::new(&Mat3::from_element(f64::INFINITY)).is_none());
    }

    #[test]
    fn triangular_factor_keeps_lengths_of_images() {
        let tall = nalgebra::MatrixXx4::from_fn(11, |i, j| ((3 * i + 5 * j) as f64).sin());
        let r = triangular_factor(tall.clone()).unwrap();
        assert!((r.transpose() * r - tall.tr_mul(&tall)).amax() < 1e-13);
        assert!(triangular_factor(nalgebra::MatrixXx4::from_element(3, 1.0)).is_none());
    }
}
