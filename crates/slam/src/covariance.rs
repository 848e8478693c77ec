//! Covariance of a frame's pose, seen from where the camera was some frames before: its marginal in a small bundle of both, of
//! keyframes around them and of the points that they see.
//!
//! The earlier view is held. What the map is unsure of enters twice: each point is an unknown with its own noise, and so are the
//! poses of the keyframes that it was made from, so that errors which points have in common do not average out. With the points
//! eliminated (Schur complement), an observation of a point counts as one with the variance `sigma^2 I + J_p Sigma_p J_p^T`.

use geometry::{Mat3, Mat6, SE3, SO3, StereoRig, Vec3};

/// Keyframes beside the two views.
pub(crate) const MAX_KEYFRAMES: usize = 4;
/// Unknowns: six for each keyframe and for the frame.
const N: usize = 6 * (MAX_KEYFRAMES + 1);
/// Where nothing is known of a view: standard deviations that hold any answer, meters and radians.
const LOOSE_M: f64 = 10.0;
const LOOSE_RAD: f64 = 1.0;
/// A pivot this small against its diagonal holds no information.
const MIN_PIVOT_RATIO: f64 = 1e-12;
/// Points nearer to the image plane than this are not used, meters.
const MIN_DEPTH_M: f64 = 1e-3;
/// How well the lengths of a map without scale are taken to be known: they are what they are.
const SCALE_SIGMA: f64 = 1e-3;

/// A point seen in a view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    /// Index of the view.
    pub(crate) view: usize,
    /// Inverse variance of column and row in the left image, 1/px^2.
    pub(crate) pixel: f64,
    /// Inverse variance of the disparity, 1/px^2; 0 where it was not measured. Its error is independent of the pixel's, since both
    /// images place a corner off by the same.
    pub(crate) disparity: f64,
}

/// Normal equations of a small bundle, the points eliminated one after another.
pub(crate) struct Window {
    rig: StereoRig,
    /// `cam_from_world`: the earlier view, which is held, keyframes, and last the frame.
    views: Vec<SE3>,
    /// Lower triangle, of the views but the first.
    normal: Box<[[f64; N]; N]>,
}

/// What a point says of a view: W L^-T of the Schur complement, upper and lower three rows.
#[derive(Clone, Copy)]
struct Lever {
    block: usize,
    upper: Mat3,
    lower: Mat3,
}

impl Window {
    /// Without observations. `views` are `cam_from_world`, the held one first, the frame last.
    ///
    /// # Panics
    /// With fewer than two views, or more than two beside [`MAX_KEYFRAMES`].
    pub(crate) fn new(rig: StereoRig, views: Vec<SE3>) -> Self {
        assert!((2..=MAX_KEYFRAMES + 2).contains(&views.len()), "{} views", views.len());
        Window { rig, views, normal: Box::new([[0.0; N]; N]) }
    }

    /// Adds a point with the views that see it.
    pub(crate) fn add(&mut self, point_world: &Vec3, sights: &[Sight]) {
        let mut seen = Vec::with_capacity(sights.len());
        let mut block = Mat3::zeros();
        for sight in sights {
            let view = &self.views[sight.view];
            let point_cam = *view * *point_world;
            if point_cam.z < MIN_DEPTH_M {
                continue;
            }
            let local = self.local(&point_cam, sight);
            let rotation = view.rotation.matrix();
            block += rotation.tr_mul(&(local * rotation));
            seen.push((sight.view, point_cam, local));
        }
        let Some(inverse_root) = inverse_root(&block) else { return };
        let mut levers: Vec<Lever> = Vec::with_capacity(seen.len());
        for (view, point_cam, local) in seen {
            let Some(block) = view.checked_sub(1).map(|view| 6 * view) else { continue };
            let cross = SO3::hat(&point_cam);
            let upper = local * (self.views[view].rotation.matrix() * inverse_root);
            levers.push(Lever { block, upper, lower: cross * upper });
            let turned = cross * local;
            self.put(block, block, &local);
            self.put(block + 3, block, &turned);
            self.put(block + 3, block + 3, &(turned * cross.transpose()));
        }
        for (i, a) in levers.iter().enumerate() {
            for b in &levers[..=i] {
                let (a, b) = if a.block >= b.block { (a, b) } else { (b, a) };
                self.put(a.block, b.block, &(-a.upper * b.upper.transpose()));
                self.put(a.block, b.block + 3, &(-a.upper * b.lower.transpose()));
                self.put(a.block + 3, b.block, &(-a.lower * b.upper.transpose()));
                self.put(a.block + 3, b.block + 3, &(-a.lower * b.lower.transpose()));
            }
        }
    }

    /// J^T W J of pixel and disparity of a point, by the point in coordinates of the camera.
    fn local(&self, point_cam: &Vec3, sight: &Sight) -> Mat3 {
        let mono = self.rig.camera.project_jacobian(point_cam);
        let mut local = mono.tr_mul(&mono) * sight.pixel;
        let slope = self.rig.bf() / (point_cam.z * point_cam.z);
        local[(2, 2)] += sight.disparity * slope * slope;
        local
    }

    /// Takes the distance of two keyframes for known: the unit of length of a map without scale.
    pub(crate) fn hold_distance(&mut self, a: usize, b: usize) {
        let apart = self.views[a].center() - self.views[b].center();
        let length = apart.norm();
        if length <= 0.0 || length.is_nan() {
            return;
        }
        let weight = (SCALE_SIGMA * length).powi(-2);
        let slope = |view: usize, sign: f64| self.views[view].rotation.matrix() * (sign * apart / length);
        let slopes = [(a, slope(a, -1.0)), (b, slope(b, 1.0))];
        for (i, (view_i, slope_i)) in slopes.iter().enumerate() {
            for (view_j, slope_j) in &slopes[..=i] {
                if *view_i == 0 || *view_j == 0 {
                    continue;
                }
                let product = weight * slope_i * slope_j.transpose();
                let (row, column) = (6 * (view_i - 1), 6 * (view_j - 1));
                if row >= column {
                    self.put(row, column, &product)
                } else {
                    self.put(column, row, &product.transpose())
                }
            }
        }
    }

    fn put(&mut self, row: usize, column: usize, block: &Mat3) {
        for r in 0..3 {
            for c in 0..3 {
                self.normal[row + r][column + c] += block[(r, c)];
            }
        }
    }

    /// The covariance of the last view with the first one held, in the tangent of its `cam_from_world`; `None` where the
    /// observations do not determine it.
    pub(crate) fn marginal_of_last(&self) -> Option<Mat6> {
        let n = 6 * (self.views.len() - 1);
        let mut l = self.normal.clone();
        for i in 0..n {
            let loose = if i % 6 < 3 { LOOSE_M } else { LOOSE_RAD };
            l[i][i] += loose.powi(-2);
        }
        for c in 0..n {
            let diagonal = l[c][c];
            let pivot = diagonal - (0..c).map(|k| l[c][k] * l[c][k]).sum::<f64>();
            if !(pivot > MIN_PIVOT_RATIO * diagonal && pivot < f64::INFINITY) {
                return None;
            }
            l[c][c] = pivot.sqrt();
            let (above, below) = l.split_at_mut(c + 1);
            let row_c = &above[c];
            for row in below.iter_mut().take(n - c - 1) {
                let sum: f64 = row[..c].iter().zip(&row_c[..c]).map(|(a, b)| a * b).sum();
                row[c] = (row[c] - sum) / row_c[c];
            }
        }
        // Of the factor of an inverse only the last block enters that of the last view.
        let last = Mat6::from_fn(|r, c| if r >= c { l[n - 6 + r][n - 6 + c] } else { 0.0 });
        let inverse = last.try_inverse()?;
        Some(inverse.tr_mul(&inverse))
    }
}

/// `L^-T` of a block `L L^T`; `None` where its point is not determined.
fn inverse_root(block: &Mat3) -> Option<Mat3> {
    let d0 = block[(0, 0)];
    let i0 = 1.0 / d0.sqrt();
    let (l10, l20) = (block[(1, 0)] * i0, block[(2, 0)] * i0);
    let p1 = block[(1, 1)] - l10 * l10;
    let i1 = 1.0 / p1.sqrt();
    let l21 = (block[(2, 1)] - l20 * l10) * i1;
    let p2 = block[(2, 2)] - l20 * l20 - l21 * l21;
    let i2 = 1.0 / p2.sqrt();
    let is_determined =
        d0 > 0.0 && p1 > MIN_PIVOT_RATIO * block[(1, 1)] && p2 > MIN_PIVOT_RATIO * block[(2, 2)];
    let m10 = -l10 * i0 * i1;
    let m21 = -l21 * i1 * i2;
    let m20 = -(l20 * i0 + l21 * m10) * i2;
    is_determined.then(|| Mat3::new(i0, m10, m20, 0.0, i1, m21, 0.0, 0.0, i2))
}

#[cfg(test)]
#[path = "../tests/steps/covariance.rs"]
mod tests;
