//! What two trajectory files may have been mixed up in, told beside their figures.

use geometry::{Quaternion, SE3, SO3};
use io::{Stamps, TrajectoryFile, TrajectoryFormat};

use crate::{Alignment, Evaluation, ate};

/// Units of time that are taken for seconds, with how many of them make one.
const UNITS: [(f64, &str); 3] = [(1e9, "nanoseconds"), (1e6, "microseconds"), (1e3, "milliseconds")];
/// How far the spans of two files in the same unit may differ.
const SPANS: f64 = 20.0;
/// How many times better the rotations must agree with the quaternion's order changed.
const ORDER: f64 = 5.0;
/// Scale that one camera alone leaves open, and how many times better the positions must agree with it.
const SCALE: f64 = 1.25;
const SCALED: f64 = 3.0;

/// A file with the name that hints call it.
pub(super) struct Named<'a> {
    pub(super) name: String,
    pub(super) file: &'a TrajectoryFile,
}

/// Hints that need no comparison: units of time.
pub(super) fn of_files(est: &Named<'_>, gt: &Named<'_>) -> Vec<String> {
    let span = |named: &Named<'_>| {
        let poses = &named.file.trajectory.poses;
        (named.file.stamps == Stamps::Times)
            .then(|| Some(poses.last()?.timestamp_s - poses.first()?.timestamp_s))
            .flatten()
            .filter(|span| *span > 0.0)
    };
    let (Some(est_span), Some(gt_span)) = (span(est), span(gt)) else { return Vec::new() };
    let (longer, other, ratio) = match est_span > gt_span {
        true => (est, gt, est_span / gt_span),
        false => (gt, est, gt_span / est_span),
    };
    let unit = UNITS.iter().find(|(unit, _)| (unit / SPANS..unit * SPANS).contains(&ratio));
    let hint = |(_, word): &(f64, &str)| {
        format!(
            "the times of {} look like {word}: they span {ratio:.0} times as much as those of {}; expected are seconds \
             (--format euroc reads nanoseconds)",
            longer.name, other.name
        )
    };
    unit.map(hint).into_iter().collect()
}

/// Hints that the matched poses give: order of quaternions, a scale that was not aligned.
pub(super) fn of_poses(est: &Named<'_>, gt: &Named<'_>, evaluation: &Evaluation) -> Vec<String> {
    let (est_poses, gt_poses) = evaluation.matched.tracked();
    let mut found = Vec::new();
    found.extend(order(est, gt, &est_poses, &gt_poses));
    found.extend(scale(evaluation, &est_poses, &gt_poses));
    found
}

/// Whether the quaternions of one file agree with the other's when they are read with w first.
fn order(est: &Named<'_>, gt: &Named<'_>, est_poses: &[SE3], gt_poses: &[SE3]) -> Option<String> {
    let as_read = disagreement(est_poses, gt_poses);
    let sides = [
        (est, disagreement(&reordered(est_poses), gt_poses)),
        (gt, disagreement(est_poses, &reordered(gt_poses))),
    ];
    let is_mixed = |named: &Named<'_>, other: f64| {
        named.file.format == TrajectoryFormat::Tum
            && as_read > 0.2_f64.to_radians()
            && as_read > ORDER * other
    };
    let (named, _) = sides.into_iter().find(|(named, other)| is_mixed(named, *other))?;
    Some(format!(
        "the quaternions of {} agree with the other file when they are read as w x y z; a TUM file has x y z w",
        named.name
    ))
}

/// Poses whose quaternions had w in the place of x.
fn reordered(poses: &[SE3]) -> Vec<SE3> {
    let of = |pose: &SE3| {
        // Read as (x, y, z, w) = (w, x, y, z) of what was meant.
        let q = pose.rotation.to_quaternion();
        let q = nalgebra::Quaternion::new(q.i, q.j, q.k, q.w);
        SE3::new(SO3::from_quaternion(&Quaternion::from_quaternion(q)), pose.translation)
    };
    poses.iter().map(of).collect()
}

/// Mean angle between the turns since the first pose, and between the directions in which its camera sees the others, radians. A
/// straight drive tells by the second alone.
fn disagreement(est: &[SE3], gt: &[SE3]) -> f64 {
    let (Some(first_est), Some(first_gt)) = (est.first(), gt.first()) else { return 0.0 };
    let angle = |(e, g): (&SE3, &SE3)| {
        let (e, g) = (first_est.inverse() * *e, first_gt.inverse() * *g);
        let (a, b) = (e.translation, g.translation);
        (e.rotation.inverse() * g.rotation).angle() + a.cross(&b).norm().atan2(a.dot(&b))
    };
    est.iter().zip(gt).map(angle).sum::<f64>() / est.len() as f64
}

/// Whether the estimate is the ground truth in another scale.
fn scale(evaluation: &Evaluation, est: &[SE3], gt: &[SE3]) -> Option<String> {
    if evaluation.alignment == Alignment::Sim3 {
        return None;
    }
    let scaled = ate(est, gt, Alignment::Sim3).ok()?;
    let factor = scaled.gt_from_est.scale;
    let is_other = factor > 0.0 && factor.ln().abs() > SCALE.ln();
    let is_better = evaluation.ate_m.rmse > SCALED * scaled.error_m.rmse;
    (is_other && is_better).then(|| {
        format!(
            "the estimate is {:.3} times as large as the ground truth: one camera alone has no scale, --align sim3 aligns it; with two \
             cameras or depth the calibration is wrong",
            1.0 / factor
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Estimate, EvaluationOptions};
    use geometry::Vec3;
    use io::{StampedPose, Trajectory};

    /// A drive around a corner, as a TUM file; times in `unit` of a second, lengths times `scale`.
    fn drive(unit: f64, scale: f64) -> TrajectoryFile {
        let pose = |i: i32| {
            let turn = SO3::exp(&Vec3::new(0.01 * f64::from(i % 3), 0.02 * f64::from(i), 0.005));
            let position = Vec3::new((0.05 * f64::from(i)).sin() * 20.0, 0.1, f64::from(i)) * scale;
            StampedPose { timestamp_s: f64::from(i) * 0.1 * unit, world_from_cam: SE3::new(turn, position) }
        };
        let trajectory = Trajectory { poses: (0..60).map(pose).collect() };
        TrajectoryFile {
            trajectory,
            format: TrajectoryFormat::Tum,
            stamps: Stamps::Times,
            n_repeated_times: 0,
        }
    }

    fn hints(est: &TrajectoryFile, gt: &TrajectoryFile) -> Vec<String> {
        let named = |name: &str, file| Named { name: name.to_owned(), file };
        let (est, gt) = (named("est.txt", est), named("gt.txt", gt));
        let mut found = of_files(&est, &gt);
        let estimate = Estimate::of_file(est.file);
        if let Ok(evaluation) = Evaluation::of(&estimate, &gt.file.trajectory, &EvaluationOptions::default())
        {
            found.extend(of_poses(&est, &gt, &evaluation));
        }
        found
    }

    #[test]
    fn files_that_agree_get_no_hint() {
        assert_eq!(hints(&drive(1.0, 1.0), &drive(1.0, 1.0)), [""; 0]);
        assert_eq!(hints(&drive(1.0, 1.02), &drive(1.0, 1.0)), [""; 0]);
    }

    /// Situation: whole nanoseconds stand in a file of TUM's form.
    #[test]
    fn times_in_nanoseconds_are_hinted_at() {
        let found = hints(&drive(1.0, 1.0), &drive(1e9, 1.0));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("the times of gt.txt look like nanoseconds"), "{found:?}");
        assert!(
            hints(&drive(1e3, 1.0), &drive(1.0, 1.0))[0].starts_with("the times of est.txt look like milli")
        );
    }

    /// Situation: quaternions are written with w first, of a drive around a corner or straight ahead.
    #[test]
    fn quaternions_with_w_first_are_hinted_at() {
        let mut straight = drive(1.0, 1.0);
        straight.trajectory.poses.iter_mut().for_each(|pose| pose.world_from_cam.rotation = SO3::identity());
        for est in [drive(1.0, 1.0), straight] {
            check_order(&est);
        }
    }

    #[track_caller]
    fn check_order(est: &TrajectoryFile) {
        let mut gt = est.clone();
        for pose in &mut gt.trajectory.poses {
            // Written w x y z and read x y z w.
            let q = pose.world_from_cam.rotation.to_quaternion();
            let read = nalgebra::Quaternion::new(q.k, q.w, q.i, q.j);
            pose.world_from_cam.rotation = SO3::from_quaternion(&Quaternion::from_quaternion(read));
        }
        let found = hints(est, &gt);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with(
            "the quaternions of gt.txt agree with the other file when they are read as w x y z"
        ));
    }

    /// Situation: a monocular estimate is compared without aligning its scale.
    #[test]
    fn a_free_scale_is_hinted_at() {
        let found = hints(&drive(1.0, 0.1), &drive(1.0, 1.0));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            found[0].starts_with("the estimate is 0.100 times as large as the ground truth"),
            "{found:?}"
        );
    }
}
