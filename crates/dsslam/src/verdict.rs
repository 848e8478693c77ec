//! Whether a run came to something, and if not, the reason of most of its frames.

use std::fmt;

use runtime::{FrameRecord, FrameStatus};

/// How many frames have a pose, and why the others have none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Verdict {
    /// Frames with a pose of their own.
    pub tracked: usize,
    /// Frames whose images could be used.
    pub usable: usize,
    /// Frames that were read.
    pub frames: usize,
    /// Reasons without numbers, each with the number of frames that have it, the most frequent first; of equals the one that came first.
    pub causes: Vec<(&'static str, usize)>,
}

impl Verdict {
    /// The verdict on the frames of a run.
    pub fn of(records: &[FrameRecord]) -> Self {
        let mut causes: Vec<(&'static str, usize)> = Vec::new();
        for cause in records.iter().filter_map(|record| record.status.cause()) {
            match causes.iter_mut().find(|(known, _)| *known == cause) {
                Some((_, n)) => *n += 1,
                None => causes.push((cause, 1)),
            }
        }
        causes.sort_by_key(|&(_, n)| std::cmp::Reverse(n));
        let is_dropped = |record: &&FrameRecord| matches!(record.status, FrameStatus::Dropped(_));
        Self {
            tracked: records.iter().filter(|record| record.status.has_pose()).count(),
            usable: records.len() - records.iter().filter(is_dropped).count(),
            frames: records.len(),
            causes,
        }
    }

    /// Whether at least half of the usable frames have a pose.
    pub fn is_success(&self) -> bool {
        self.tracked > 0 && 2 * self.tracked >= self.usable
    }
}

/// `3 of 400 usable frames have a pose; 312 of 400 frames: too little parallax`.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.tracked {
            0 => f.write_str("no frame has a pose")?,
            n => write!(f, "{n} of {} usable frames have a pose", self.usable)?,
        }
        match self.causes.first() {
            Some((cause, n)) => write!(f, "; {n} of {} frames: {cause}", self.frames),
            None if self.frames == 0 => f.write_str("; the sequence is empty"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::Unusable;

    fn frames(statuses: &[(FrameStatus, usize)]) -> Vec<FrameRecord> {
        let all = statuses.iter().flat_map(|(status, n)| std::iter::repeat_n(status.clone(), *n));
        let record = |(index, status)| FrameRecord::new(index, f64::from(index), status, None);
        (0..).zip(all).map(record).collect()
    }

    #[test]
    fn the_reason_is_that_of_the_most_frames_and_not_of_the_first() {
        let dropped = |unusable| FrameStatus::Dropped(unusable);
        let records = frames(&[
            (dropped(Unusable::Missing("left")), 1),
            (dropped(Unusable::Skipped), 5),
            (dropped(Unusable::Missing("right")), 2),
            (FrameStatus::Tracked { inliers: 9 }, 1),
        ]);
        let verdict = Verdict::of(&records);
        assert_eq!(verdict.causes, [("tracking was behind", 5), ("an image is missing", 3)]);
        assert_eq!((verdict.tracked, verdict.usable, verdict.frames), (1, 1, 9));
        assert_eq!(
            verdict.to_string(),
            "1 of 1 usable frames have a pose; 5 of 9 frames: tracking was behind"
        );
        assert_eq!(
            Verdict::of(&records[..6]).to_string(),
            "no frame has a pose; 5 of 6 frames: tracking was behind"
        );
        assert_eq!(Verdict::of(&[]).to_string(), "no frame has a pose; the sequence is empty");
    }

    #[test]
    fn half_of_the_usable_frames_is_a_success_and_less_is_not() {
        let lost = FrameStatus::Lost(slam::Lost::TooFewMatches { found: 3, needed: 15 });
        let verdict = |tracked, others: usize, dropped| {
            Verdict::of(&frames(&[
                (FrameStatus::Tracked { inliers: 9 }, tracked),
                (lost.clone(), others),
                (FrameStatus::Dropped(Unusable::Skipped), dropped),
            ]))
        };
        assert!(verdict(5, 5, 0).is_success() && verdict(5, 5, 90).is_success());
        assert!(!verdict(4, 5, 0).is_success() && !verdict(0, 0, 9).is_success());
    }
}
