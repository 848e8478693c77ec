//! Whether covariances are right: errors of motions over some frames in units of them (NEES, normalized estimation error squared;
//! Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", section 5.4).

use std::f64::consts::PI;

use anyhow::{Result, ensure};
use geometry::{Mat6, PoseCovariance, SE3, SO3, Vec6, median};
use io::Trajectory;

/// Ends of the middle 95 % of chi-square with 6 degrees of freedom.
pub const NEES_BOUNDS: [f64; 2] = [1.237, 14.449];
/// Median of chi-square with 6 degrees of freedom.
const CHI2_MEDIAN: f64 = 5.348;
/// Degrees of freedom.
const N: f64 = 6.0;
/// True poses further apart are not interpolated between, seconds.
const MAX_GAP_S: f64 = 0.1;
/// Times that differ by less are the same, seconds.
const SAME_TIME_S: f64 = 1e-5;

/// A frame with its estimate, its truth and its covariance.
#[derive(Clone, Copy, Debug)]
pub struct ConsistentFrame {
    /// Number of the frame.
    pub frame: u32,
    /// Estimated pose.
    pub estimate: SE3,
    /// True pose of the same body.
    pub truth: SE3,
    /// Covariance of the motion over [`ConsistencyOptions::delta`] frames that ends here, along the axes of the body.
    pub covariance: Option<PoseCovariance>,
}

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConsistencyOptions {
    /// Frames of a motion.
    pub delta: u32,
    /// Standard deviation of each true position in each direction, meters; added to the covariance for both ends.
    pub truth_sigma_m: f64,
    /// The same of each true rotation, degrees.
    pub truth_sigma_deg: f64,
}

/// The errors of all motions.
#[derive(Clone, Debug, PartialEq)]
pub struct Consistency {
    /// Number of the frame that each motion ends at, and its normalized error squared.
    pub nees: Vec<(u32, f64)>,
    /// Mean; 6 where the covariances are right.
    pub mean: f64,
    /// Median; 5.35 where they are right.
    pub median: f64,
    /// Share within [`NEES_BOUNDS`].
    pub inside: f64,
    /// Share above: the covariance is too small.
    pub above: f64,
    /// Share below: it is too large.
    pub below: f64,
    /// Per axis (x, y, z, rx, ry, rz) the root mean square of the error over its standard deviation.
    pub per_axis: [f64; 6],
}

impl Consistency {
    /// Of frames in order; pairs are those that are `delta` frame numbers apart and both have a truth.
    ///
    /// # Errors
    /// There is no such pair with a covariance.
    pub fn of(frames: &[ConsistentFrame], options: &ConsistencyOptions) -> Result<Self> {
        let mut nees = Vec::new();
        let mut squares = Vec6::zeros();
        for later in frames {
            let Some(start) = later.frame.checked_sub(options.delta) else { continue };
            let Ok(at) = frames.binary_search_by_key(&start, |frame| frame.frame) else { continue };
            let (Some(covariance), earlier) = (&later.covariance, &frames[at]) else { continue };
            let covariance = covariance.in_camera() + truth_noise(earlier, later, options);
            let Some(factor) = covariance.cholesky() else { continue };
            let error = motion_error(earlier, later);
            nees.push((later.frame, error.dot(&factor.solve(&error))));
            squares += error.component_mul(&error).component_div(&covariance.diagonal());
        }
        ensure!(
            !nees.is_empty(),
            "no frame with a covariance has a true pose, and one {} frames before",
            options.delta
        );
        let n = nees.len() as f64;
        let share = |is: &dyn Fn(f64) -> bool| nees.iter().filter(|(_, v)| is(*v)).count() as f64 / n;
        let mut values: Vec<f64> = nees.iter().map(|(_, v)| *v).collect();
        Ok(Self {
            mean: values.iter().sum::<f64>() / n,
            median: median(&mut values).unwrap_or(f64::NAN),
            inside: share(&|v| (NEES_BOUNDS[0]..=NEES_BOUNDS[1]).contains(&v)),
            above: share(&|v| v > NEES_BOUNDS[1]),
            below: share(&|v| v < NEES_BOUNDS[0]),
            per_axis: (squares / n).map(f64::sqrt).into(),
            nees,
        })
    }

    /// The factor on standard deviations with which the mean would be right; by the median it is less drawn by single large errors.
    pub fn factors(&self) -> [f64; 2] {
        [(self.mean / N).sqrt(), (self.median / CHI2_MEDIAN).sqrt()]
    }
}

/// `e` of `true_motion = exp(e) * estimated_motion`, both `later_from_earlier`: in the tangent of the later body.
fn motion_error(earlier: &ConsistentFrame, later: &ConsistentFrame) -> Vec6 {
    let truth = later.truth.inverse() * earlier.truth;
    let estimate = later.estimate.inverse() * earlier.estimate;
    (truth * estimate.inverse()).log()
}

/// Covariance of the true motion, in the same tangent.
fn truth_noise(earlier: &ConsistentFrame, later: &ConsistentFrame, options: &ConsistencyOptions) -> Mat6 {
    let (m, rad) = (options.truth_sigma_m.powi(2), (options.truth_sigma_deg * PI / 180.0).powi(2));
    let each = Mat6::from_diagonal(&Vec6::new(m, m, m, rad, rad, rad));
    let adjoint = (later.estimate.inverse() * earlier.estimate).adjoint();
    each + adjoint * each * adjoint.transpose()
}

/// The pose at a time: that of the same time, else between the two around it, on the shortest way.
pub fn interpolated(truth: &Trajectory, timestamp_s: f64) -> Option<SE3> {
    let after = truth.poses.partition_point(|pose| pose.timestamp_s < timestamp_s - SAME_TIME_S);
    let next = truth.poses.get(after)?;
    if (next.timestamp_s - timestamp_s).abs() <= SAME_TIME_S {
        return Some(next.world_from_cam);
    }
    let previous = &truth.poses[after.checked_sub(1)?];
    let gap_s = next.timestamp_s - previous.timestamp_s;
    if gap_s > MAX_GAP_S {
        return None;
    }
    let share = (timestamp_s - previous.timestamp_s) / gap_s;
    let (a, b) = (previous.world_from_cam, next.world_from_cam);
    let turn = (a.rotation.inverse() * b.rotation).log();
    let rotation = a.rotation * SO3::exp(&(turn * share));
    Some(SE3::new(rotation, a.translation.lerp(&b.translation, share)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vec3;
    use io::StampedPose;

    /// Frames on a bend whose motions over 3 frames have errors of exactly these covariances: column `i` of the root times
    /// the square root of 6, in turn.
    fn frames(scale: f64) -> Vec<ConsistentFrame> {
        let root = Mat6::from_fn(|r, c| {
            if r == c {
                0.01
            } else if r > c {
                0.003
            } else {
                0.0
            }
        });
        let covariance = PoseCovariance::new(root * root.transpose() * scale);
        let step = SE3::exp(&Vec6::new(0.1, 0.0, 1.0, 0.02, 0.05, -0.01));
        let truth: Vec<SE3> =
            std::iter::successors(Some(SE3::identity()), |pose| Some(*pose * step)).take(63).collect();
        let mut estimate: Vec<SE3> = truth[..3].to_vec();
        for i in 3..truth.len() {
            let error: Vec6 = root.column(i % 6) * 6_f64.sqrt();
            let motion = truth[i].inverse() * truth[i - 3];
            // later = earlier * (later_from_earlier)^-1, with true = exp(e) * estimated.
            let estimated = SE3::exp(&(-error)) * motion;
            estimate.push(estimate[i - 3] * estimated.inverse());
        }
        let frame = |(i, (truth, estimate)): (usize, (&SE3, &SE3))| ConsistentFrame {
            frame: i as u32,
            estimate: *estimate,
            truth: *truth,
            covariance,
        };
        truth.iter().zip(&estimate).enumerate().map(frame).collect()
    }

    const OPTIONS: ConsistencyOptions =
        ConsistencyOptions { delta: 3, truth_sigma_m: 0.0, truth_sigma_deg: 0.0 };

    #[test]
    fn errors_of_the_stated_covariance_have_a_mean_of_six() {
        let right = Consistency::of(&frames(1.0), &OPTIONS).unwrap();
        assert_eq!(right.nees.len(), 60);
        assert!((right.mean - 6.0).abs() < 1e-6 && (right.median - 6.0).abs() < 1e-6, "{right:?}");
        assert_eq!((right.inside, right.above, right.below), (1.0, 0.0, 0.0));
        assert!(right.per_axis.iter().all(|v| (v - 1.0).abs() < 1e-6), "{right:?}");
        let small = Consistency::of(&frames(0.25), &OPTIONS).unwrap();
        assert!((small.mean - 24.0).abs() < 1e-5 && small.above == 1.0);
        assert!((small.factors()[0] - 2.0).abs() < 1e-6);
        let large = Consistency::of(&frames(16.0), &OPTIONS).unwrap();
        assert!((large.mean - 0.375).abs() < 1e-6 && large.below == 1.0);
    }

    #[test]
    fn a_rough_truth_is_added_for_both_ends() {
        let rough = ConsistencyOptions { truth_sigma_m: 1.0, truth_sigma_deg: 50.0, ..OPTIONS };
        assert!(Consistency::of(&frames(1.0), &rough).unwrap().mean < 0.01);
    }

    #[test]
    fn frames_without_a_partner_are_left_out() {
        let mut all = frames(1.0);
        all.retain(|frame| frame.frame != 20);
        all[30].covariance = None;
        let found = Consistency::of(&all, &OPTIONS).unwrap();
        assert_eq!(found.nees.len(), 57, "frames 20 (gone), 23 (its start gone) and 31 (no covariance)");
        let none = Consistency::of(&all[..2], &OPTIONS).unwrap_err();
        assert_eq!(none.to_string(), "no frame with a covariance has a true pose, and one 3 frames before");
    }

    #[test]
    fn the_truth_is_interpolated_in_place_and_in_angle() {
        let pose = |timestamp_s: f64, angle: f64| StampedPose {
            timestamp_s,
            world_from_cam: SE3::new(SO3::exp(&Vec3::new(0.0, angle, 0.0)), Vec3::new(angle, 0.0, 1.0)),
        };
        let truth = Trajectory { poses: vec![pose(1.0, 0.0), pose(1.05, 0.2), pose(2.0, 0.4)] };
        let between = interpolated(&truth, 1.0125).unwrap();
        assert!((between.log() - pose(0.0, 0.05).world_from_cam.log()).norm() < 1e-3);
        assert!(
            (between.rotation.angle() - 0.05).abs() < 1e-9 && (between.translation.x - 0.05).abs() < 1e-9
        );
        assert_eq!(interpolated(&truth, 1.050_001), Some(truth.poses[1].world_from_cam));
        assert_eq!(interpolated(&truth, 1.5), None, "too far from both");
        assert!(interpolated(&truth, 0.5).is_none() && interpolated(&truth, 2.5).is_none());
    }
}
