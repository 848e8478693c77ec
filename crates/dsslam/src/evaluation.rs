//! A run beside its ground truth: poses of one and the same body, and the errors between them.

use std::borrow::Cow;

use eval::{
    Alignment, Estimate, Evaluation, EvaluationOptions, Subject, TIMESTAMP_TOLERANCE_S, apply_alignment,
    estimate_alignment, positions,
};
use geometry::{SE3, Vec3};
use io::{Sensor, Sequence, StampedPose, Trajectory};
use runtime::FrameRecord;

use crate::Error;
use crate::trajectories::{body_records, of_left_camera, own_pose};

/// Estimate and truth of the same body: that of the ground truth, or the left camera where the way to the body has no scale.
#[derive(Clone, Debug)]
pub struct Compared<'a> {
    /// Whose poses both hold.
    pub subject: Subject,
    /// The frames of the run; `world_from_cam` is the pose of the subject.
    pub frames: Cow<'a, [FrameRecord]>,
    /// True poses of the subject.
    pub truth: Cow<'a, Trajectory>,
    sensor: Sensor,
}

impl<'a> Compared<'a> {
    /// The frames of a run, whose poses are those of the left camera, and the ground truth of its sequence; `None` without
    /// ground truth.
    pub fn new(frames: &'a [FrameRecord], sequence: &'a Sequence) -> Option<Self> {
        let Sequence { sensor, body_from_left, .. } = sequence;
        let truth = Cow::Borrowed(sequence.ground_truth.as_ref()?);
        let body = body_records(frames, *sensor, body_from_left);
        let (subject, truth) = match body {
            Some(_) => (Subject::Body, truth),
            None if *body_from_left == SE3::identity() => (Subject::LeftCamera, truth),
            None => (Subject::LeftCamera, Cow::Owned(of_left_camera(&truth, body_from_left))),
        };
        let frames = body.map_or(Cow::Borrowed(frames), Cow::Owned);
        Some(Self { subject, frames, truth, sensor: *sensor })
    }

    /// All errors, frames matched by their times. One camera does not know its scale, so the scale is aligned there; frames
    /// without a pose count in the drift, over segments of `lengths_m` meters, as if the last motion had gone on.
    ///
    /// # Errors
    /// No time matches, or fewer than three frames have a pose.
    pub fn evaluate(&self, lengths_m: &[f64]) -> Result<Evaluation, Error> {
        let alignment = match self.sensor {
            Sensor::Stereo | Sensor::Rgbd => Alignment::Se3,
            Sensor::Mono => Alignment::Sim3,
        };
        let options =
            EvaluationOptions { alignment, lengths_m: lengths_m.to_vec(), ..EvaluationOptions::default() };
        let estimate = Estimate::new(self.frames.iter().map(|frame| (frame.timestamp_s, own_pose(frame))));
        let evaluation = Evaluation::of(&estimate, &self.truth, &options)
            .map_err(|problem| Error::Evaluation(format!("{problem:#}")))?;
        Ok(Evaluation { compared: Some(self.subject), ..evaluation })
    }

    /// True poses of the subject at the frames that have one, with the frames' times.
    pub fn truth_at_frames(&self) -> Trajectory {
        let at = |frame: &FrameRecord| {
            let nearest = self.truth.find_nearest(frame.timestamp_s, TIMESTAMP_TOLERANCE_S)?;
            Some(StampedPose { timestamp_s: frame.timestamp_s, ..*nearest })
        };
        Trajectory { poses: self.frames.iter().filter_map(at).collect() }
    }
}

/// The scale of an estimate against the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Scale {
    /// Estimated over true lengths.
    pub ratio: f64,
    /// How far it may be off, since the estimate has errors of its own: what is left after the scale is taken out, over the spread of the
    /// poses. A short path does not tell a scale.
    pub uncertainty: f64,
}

impl Scale {
    /// Whether it is wrong by more than 5 % and by more than its uncertainty.
    pub fn is_off(&self) -> bool {
        const TOLERATED: f64 = 0.05;
        (self.ratio - 1.0).abs() > TOLERATED.max(self.uncertainty)
    }
}

/// The scale of the estimate; `None` for a free scale, and where the path is too short to tell.
pub fn scale_against_truth(evaluation: &Evaluation) -> Option<Scale> {
    /// Frames that tell, and how far they must spread over what is left when the estimate is scaled.
    const MIN_FRAMES: usize = 10;
    const MIN_SPREAD: f64 = 3.0;
    if evaluation.alignment != Alignment::Se3 {
        return None;
    }
    let (est, gt) = evaluation.matched.tracked();
    let gt_from_est = estimate_alignment(&est, &gt, Alignment::Sim3).ok()?;
    let (moved, truth) = (positions(&apply_alignment(&gt_from_est, &est)), positions(&gt));
    let n = truth.len() as f64;
    let middle = truth.iter().sum::<Vec3>() / n;
    let spread_sq: f64 = truth.iter().map(|position| (position - middle).norm_squared()).sum();
    let left_sq: f64 = moved.iter().zip(&truth).map(|(a, b)| (a - b).norm_squared()).sum();
    let tells = truth.len() >= MIN_FRAMES && spread_sq > MIN_SPREAD * MIN_SPREAD * left_sq;
    let scale = Scale { ratio: 1.0 / gt_from_est.scale, uncertainty: (left_sq / spread_sq).sqrt() };
    (tells && gt_from_est.scale > 0.0).then_some(scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::SO3;
    use runtime::FrameStatus;

    /// Frames on an arc, ten a second, and the sequence whose ground truth they are exactly, the body being elsewhere.
    fn arc(sensor: Sensor, body_from_left: SE3) -> (Vec<FrameRecord>, Sequence) {
        let mut body = SE3::identity();
        let (mut frames, mut poses) = (Vec::new(), Vec::new());
        for index in 0..60 {
            let (timestamp_s, status) = (f64::from(index) * 0.1, FrameStatus::Tracked { inliers: 100 });
            let world_from_cam = Some(body * body_from_left);
            frames.push(FrameRecord::new(index, timestamp_s, status, world_from_cam));
            // The truth is a little late, and has a pose between each two frames.
            poses.push(StampedPose { timestamp_s: timestamp_s + 0.002, world_from_cam: body });
            poses.push(StampedPose { timestamp_s: timestamp_s + 0.05, world_from_cam: SE3::identity() });
            body = body * SE3::new(SO3::exp(&Vec3::new(0.0, 0.05, 0.0)), Vec3::new(0.0, 0.0, 1.0));
        }
        let ground_truth = Some(Trajectory { poses });
        (frames, Sequence { sensor, body_from_left, ground_truth, ..Sequence::of_image("x.png".as_ref()) })
    }

    #[test]
    fn a_body_beside_the_camera_is_compared_with_itself() {
        let lever = SE3::new(SO3::exp(&Vec3::new(0.3, 0.2, -1.5)), Vec3::new(0.4, -0.7, 0.2));
        let (frames, sequence) = arc(Sensor::Stereo, lever);
        let compared = Compared::new(&frames, &sequence).unwrap();
        let evaluation = compared.evaluate(&[10.0]).unwrap();
        assert_eq!((compared.subject, evaluation.compared), (Subject::Body, Some(Subject::Body)));
        assert!(evaluation.ate_m.rmse < 1e-9 && evaluation.t_rel_percent.is_some_and(|t| t < 1e-9));
        let at_frames = compared.truth_at_frames();
        assert_eq!((at_frames.poses.len(), at_frames.poses[7].timestamp_s), (60, frames[7].timestamp_s));
        let estimate = compared.frames[7].world_from_cam.unwrap();
        assert!((at_frames.poses[7].world_from_cam.matrix() - estimate.matrix()).amax() < 1e-12);
        // As if the left camera were the body: the arc turns, so nothing can make up for it.
        let mistaken = Sequence { body_from_left: SE3::identity(), ..sequence };
        let evaluation = Compared::new(&frames, &mistaken).unwrap().evaluate(&[10.0]).unwrap();
        assert!(evaluation.ate_m.rmse > 1e-3 && evaluation.t_rel_percent.is_some_and(|t| t > 10.0));
    }

    #[test]
    fn one_camera_is_compared_with_the_true_left_camera() {
        let lever = SE3::new(SO3::identity(), Vec3::new(0.4, -0.7, 0.2));
        let (mut frames, sequence) = arc(Sensor::Mono, lever);
        // In a map of another scale the lever is as long as before, which no alignment of the body could undo.
        frames.iter_mut().filter_map(|f| f.world_from_cam.as_mut()).for_each(|pose| pose.translation *= 0.25);
        let compared = Compared::new(&frames, &sequence).unwrap();
        let evaluation = compared.evaluate(&[10.0]).unwrap();
        assert_eq!((compared.subject, evaluation.alignment), (Subject::LeftCamera, Alignment::Sim3));
        assert!(evaluation.ate_m.rmse < 1e-9 && (evaluation.scale - 4.0).abs() < 1e-9);
    }

    /// Situation: thirteen frames of a hand-held camera, 18 cm of path with 6 mm of error, were told that their unit is wrong.
    #[test]
    fn a_short_path_with_errors_tells_no_scale() {
        let (frames, sequence) = arc(Sensor::Stereo, SE3::identity());
        let of = |factor: f64, shake: f64| {
            let mut frames = frames[..20].to_vec();
            for (i, frame) in frames.iter_mut().enumerate() {
                let pose = frame.world_from_cam.as_mut().unwrap();
                pose.translation *= factor;
                pose.translation.y += if i % 2 == 0 { shake } else { -shake };
            }
            let evaluation = Compared::new(&frames, &sequence).unwrap().evaluate(&[10.0]).unwrap();
            scale_against_truth(&evaluation).unwrap()
        };
        let right = of(1.08, 0.01);
        assert!((right.ratio - 1.08).abs() < 1e-3 && right.is_off(), "{right:?}");
        let shaken = of(1.08, 0.6);
        assert!(!shaken.is_off() && shaken.uncertainty > 0.08, "{shaken:?}");
        assert!(of(1.9, 0.6).is_off() && !of(1.0, 0.01).is_off());
    }

    #[test]
    fn without_truth_or_poses_there_is_no_error() {
        let (mut frames, sequence) = arc(Sensor::Stereo, SE3::identity());
        assert!(Compared::new(&frames, &Sequence { ground_truth: None, ..sequence.clone() }).is_none());
        frames.iter_mut().skip(2).for_each(|frame| frame.world_from_cam = None);
        let error = Compared::new(&frames, &sequence).unwrap().evaluate(&[10.0]).unwrap_err();
        assert_eq!(error.to_string(), "alignment SE3 needs at least 3 matched poses, found 2");
    }
}
