//! The pose of a calibrated camera from three points: Lambda Twist (Persson and Nordberg, ECCV 2018).
//!
//! With unit rays `y_i`, distances `l_i` and squared sides `a_ij`, the cosine theorem gives three conics
//! `l^T M_ij l = a_ij`. Two combinations without constant part, `D1` and `D2`, vanish on the solution; a pencil member
//! `D1 + g D2` of rank two splits into two lines, on each of which a quadratic equation remains.

use crate::aliases::{Mat3, Vec3};
use crate::se3::SE3;
use crate::so3::SO3;

/// Largest residual of the squared sides, relative to the longest, that a solution may keep.
const MAX_RESIDUAL: f64 = 1e-9;

/// Discriminants down to this fraction below zero count as double roots, the rest as no root.
const DOUBLE_ROOT_TOLERANCE: f64 = 1e-10;

/// All poses `cam_from_world`, at most four, that see the three world points along the rays (any length, camera frame).
///
/// Points have positive distances along the rays. Empty for points on one line or equal rays. Solutions agree with the data to
/// about rounding precision; their order depends on the input only.
pub fn p3p(rays: &[Vec3; 3], points_world: &[Vec3; 3]) -> Vec<SE3> {
    let Some(triangle) = Triangle::new(rays, points_world) else {
        return Vec::new();
    };
    let mut poses = Vec::with_capacity(4);
    for (normal, conic) in triangle.lines() {
        for direction in directions_on_line(&normal, &conic).into_iter().flatten() {
            if let Some(pose) =
                triangle.refined_distances(direction).and_then(|distances| triangle.pose(&distances))
            {
                poses.push(pose);
            }
        }
    }
    poses.truncate(4);
    poses
}

/// The unit rays and the sides of the world triangle, squared, in units of the longest.
struct Triangle<'a> {
    rays: [Vec3; 3],
    points_world: &'a [Vec3; 3],
    /// Conics of the sides 12, 13, 23.
    conics: [Mat3; 3],
    sides_sq: [f64; 3],
    unit: f64,
}

impl<'a> Triangle<'a> {
    fn new(rays: &[Vec3; 3], points_world: &'a [Vec3; 3]) -> Option<Self> {
        let rays = rays.map(|ray| ray.normalize());
        let [x1, x2, x3] = points_world;
        let lengths_sq = [(x1 - x2).norm_squared(), (x1 - x3).norm_squared(), (x2 - x3).norm_squared()];
        let longest = lengths_sq.iter().copied().fold(0.0, f64::max);
        let area = (x2 - x1).cross(&(x3 - x1)).norm();
        let finite = longest.is_finite() && rays.iter().all(|ray| ray.iter().all(|v| v.is_finite()));
        if !finite || area <= 1e-12 * longest {
            return None;
        }
        let conics = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| {
            let mut m = Mat3::zeros();
            (m[(i, i)], m[(j, j)]) = (1.0, 1.0);
            let cosine = rays[i].dot(&rays[j]);
            (m[(i, j)], m[(j, i)]) = (-cosine, -cosine);
            m
        });
        Some(Self {
            rays,
            points_world,
            conics,
            sides_sq: lengths_sq.map(|l| l / longest),
            unit: longest.sqrt(),
        })
    }

    /// Normals of the (at most two) planes through the origin that hold all solutions, each with a conic not zero there.
    fn lines(&self) -> Vec<(Vec3, Mat3)> {
        let [m12, m13, m23] = &self.conics;
        let [a12, a13, a23] = self.sides_sq;
        let d1 = m12 * a23 - m23 * a12;
        let d2 = m13 * a23 - m23 * a13;
        let Some(pencil) = degenerate_member(&d1, &d2) else {
            return Vec::new();
        };
        // On the lines D1 and D2 are proportional; the one with the smaller share in the member is the larger there.
        let conic = if pencil.share_1 > pencil.share_2 { d2 } else { d1 };
        split_conic(&pencil.matrix).into_iter().flatten().map(|normal| (normal, conic)).collect()
    }

    /// Scales the direction to the sides and polishes the distances by Newton's method on the three cosine theorems.
    fn refined_distances(&self, direction: Vec3) -> Option<Vec3> {
        const MAX_ITERATIONS: usize = 8;
        let form: f64 = self.conics.iter().map(|m| direction.dot(&(m * direction))).sum();
        let scale_sq = self.sides_sq.iter().sum::<f64>() / form;
        if !(scale_sq.is_finite() && scale_sq > 0.0) {
            return None;
        }
        let mut distances = direction * scale_sq.sqrt();
        let mut residual = self.residual(&distances);
        for _ in 0..MAX_ITERATIONS {
            let jacobian = Mat3::from_rows(&self.conics.map(|m| 2.0 * (m * distances).transpose()));
            let Some(inverse) = jacobian.try_inverse() else { break };
            let candidate = distances - inverse * residual;
            let candidate_residual = self.residual(&candidate);
            // A residual that is not a number ends the loop, too.
            let improved = candidate_residual.norm_squared() < residual.norm_squared();
            if !improved {
                break;
            }
            (distances, residual) = (candidate, candidate_residual);
        }
        (residual.amax() < MAX_RESIDUAL && distances.min() > 0.0).then_some(distances * self.unit)
    }

    fn residual(&self, distances: &Vec3) -> Vec3 {
        Vec3::from_fn(|k, _| distances.dot(&(self.conics[k] * distances)) - self.sides_sq[k])
    }

    /// The motion between the congruent triangles, through an orthonormal frame on each.
    fn pose(&self, distances: &Vec3) -> Option<SE3> {
        let points_cam: [Vec3; 3] = std::array::from_fn(|i| self.rays[i] * distances[i]);
        let rotation = triangle_frame(&points_cam)? * triangle_frame(self.points_world)?.transpose();
        let centroid = |p: &[Vec3; 3]| (p[0] + p[1] + p[2]) / 3.0;
        let translation = centroid(&points_cam) - rotation * centroid(self.points_world);
        Some(SE3::new(SO3::from_matrix_unchecked(rotation), translation))
    }
}

/// `share_1 D1 + share_2 D2`, singular.
struct PencilMember {
    matrix: Mat3,
    share_1: f64,
    share_2: f64,
}

/// A singular member of the pencil, from a real root of `det(D1 + g D2)` or, whichever is better posed, of `det(g D1 + D2)`.
fn degenerate_member(d1: &Mat3, d2: &Mat3) -> Option<PencilMember> {
    let (adjugate_1, adjugate_2) = (adjugate_symmetric(d1), adjugate_symmetric(d2));
    let (c0, c1) = (d1.determinant(), adjugate_1.dot(d2));
    let (c2, c3) = (adjugate_2.dot(d1), d2.determinant());
    let (share_1, share_2) = if c0 == 0.0 {
        (1.0, 0.0)
    } else if c3.abs() >= c0.abs() {
        (1.0, sharp_cubic_root(c2 / c3, c1 / c3, c0 / c3))
    } else {
        (sharp_cubic_root(c1 / c0, c2 / c0, c3 / c0), 1.0)
    };
    let norm = f64::hypot(share_1, share_2);
    let (share_1, share_2) = (share_1 / norm, share_2 / norm);
    let matrix = d1 * share_1 + d2 * share_2;
    matrix.iter().all(|v| v.is_finite()).then_some(PencilMember {
        matrix,
        share_1: share_1.abs(),
        share_2: share_2.abs(),
    })
}

/// The real root of `x^3 + b x^2 + c x + d` that lies apart from the others, where the slope is steepest.
///
/// Newton's method from a start outside the turning points, on the root's own side of the inflection: it converges
/// monotonically after at most one step.
fn sharp_cubic_root(b: f64, c: f64, d: f64) -> f64 {
    const MAX_ITERATIONS: usize = 60;
    let value = |x: f64| ((x + b) * x + c) * x + d;
    let slope = |x: f64| (3.0 * x + 2.0 * b) * x + c;
    let inflection = -b / 3.0;
    let height = value(inflection);
    let turning_sq = (b * b - 3.0 * c) / 9.0;
    let reach = if turning_sq > 0.0 { 2.0 * turning_sq.sqrt() } else { height.abs().cbrt() };
    let mut x = inflection - reach * height.signum();
    for _ in 0..MAX_ITERATIONS {
        let step = value(x) / slope(x);
        if !step.is_finite() {
            break;
        }
        x -= step;
        if step.abs() <= 2.0 * f64::EPSILON * x.abs() {
            break;
        }
    }
    x
}

/// Normals of the two planes into which a symmetric matrix of rank two splits as a quadratic form; `None` when not real.
fn split_conic(matrix: &Mat3) -> [Option<Vec3>; 2] {
    let rows: [Vec3; 3] = std::array::from_fn(|i| matrix.row(i).transpose());
    let crosses = [rows[0].cross(&rows[1]), rows[0].cross(&rows[2]), rows[1].cross(&rows[2])];
    let null_vector = crosses.into_iter().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
    let Some(e) = null_vector.and_then(|v| v.try_normalize(1e-14 * matrix.norm_squared())) else {
        // Rank one: the same plane twice.
        let longest = rows.into_iter().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
        return [longest, None];
    };
    let p = e.cross(&Vec3::ith(e.iamin(), 1.0)).normalize();
    let q = e.cross(&p);
    let (a, b, c) = (p.dot(&(matrix * p)), p.dot(&(matrix * q)), q.dot(&(matrix * q)));
    let Some(root) = root_of_discriminant(b, a, c) else {
        return [None, None];
    };
    let t = -(b + root.copysign(b));
    [p * a - q * t, p * t - q * c].map(|normal| normal.try_normalize(0.0))
}

/// The positive directions in the plane across `normal` on which the conic vanishes.
fn directions_on_line(normal: &Vec3, conic: &Mat3) -> [Option<Vec3>; 2] {
    // Eliminate the distance with the largest coefficient: l = u + x v.
    let pivot = normal.iamax();
    let (first, second) = ((pivot + 1) % 3, (pivot + 2) % 3);
    let basis = |i: usize| {
        let mut v = Vec3::ith(i, 1.0);
        v[pivot] = -normal[i] / normal[pivot];
        v
    };
    let (u, v) = (basis(first), basis(second));
    let (a, b, c) = (v.dot(&(conic * v)), u.dot(&(conic * v)), u.dot(&(conic * u)));
    let Some(root) = root_of_discriminant(b, a, c) else {
        return [None, None];
    };
    let t = -(b + root.copysign(b));
    let roots = if root == 0.0 { [t / a, f64::NAN] } else { [t / a, c / t] };
    roots.map(|x| {
        let direction = u + v * x;
        // A pivot slightly below zero may still be polished into a solution.
        (x > 0.0 && direction[pivot] > -1e-6 * direction.norm()).then_some(direction)
    })
}

/// The square root of `b^2 - a c`, zero for a slightly negative number, `None` otherwise.
fn root_of_discriminant(b: f64, a: f64, c: f64) -> Option<f64> {
    let discriminant = b * b - a * c;
    if discriminant >= 0.0 {
        Some(discriminant.sqrt())
    } else {
        (discriminant > -DOUBLE_ROOT_TOLERANCE * (b * b + (a * c).abs())).then_some(0.0)
    }
}

/// The adjugate of a symmetric matrix, `adj(A) A = det(A) I`: cross products of its rows.
fn adjugate_symmetric(m: &Mat3) -> Mat3 {
    let rows: [Vec3; 3] = std::array::from_fn(|i| m.row(i).transpose());
    Mat3::from_columns(&[rows[1].cross(&rows[2]), rows[2].cross(&rows[0]), rows[0].cross(&rows[1])])
}

/// Orthonormal axes: along the first side, in the plane across it, normal to the plane.
fn triangle_frame(points: &[Vec3; 3]) -> Option<Mat3> {
    let x = (points[1] - points[0]).try_normalize(0.0)?;
    let z = x.cross(&(points[2] - points[0])).try_normalize(0.0)?;
    Some(Mat3::from_columns(&[x, z.cross(&x), z]))
}
