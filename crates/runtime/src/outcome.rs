//! From what the stages left to the results: every frame in the final map.

use map::{KeyframeId, Map, RelativePose};
use slam::World;

use crate::failure::StageFailure;
use crate::journal::{Journal, Operation};
use crate::record::{FrameRecord, LoopRecord, RunOutcome, Statistics};
use crate::run::Plan;
use crate::services::StageTimes;
use crate::stages::track::{TrackLog, TrackedFrame};
use crate::timings::Timings;

/// What a schedule leaves.
pub(crate) struct Parts {
    pub(crate) tracking: TrackLog,
    pub(crate) mapping: MapLog,
    /// The final world, or the last one that there is.
    pub(crate) world: World,
    /// Frames that were to come.
    pub(crate) frames: usize,
    pub(crate) failure: Option<StageFailure>,
}

impl Parts {
    /// Puts the results together.
    pub(crate) fn outcome(self, plan: &Plan) -> RunOutcome {
        let (setup, disparity_offset_px) = (&plan.setup, plan.disparity_offset_px);
        let Parts { tracking, mapping, world, frames, failure } = self;
        let slam::World { map, calibration, .. } = world;
        let interrupted = tracking.frames.len() < frames || mapping.cut_short;
        let mut statistics = mapping.statistics;
        statistics.relocalizations = tracking.relocalizations;
        let journal = Journal::new(
            setup.fingerprint(),
            disparity_offset_px,
            tracking.frames.iter().map(|frame| frame.seen).collect(),
            mapping.operations.clone(),
        );
        let mut timings =
            Timings { rows: tracking.frames.iter().map(|frame| frame.timings.clone()).collect() };
        for (n, times) in &mapping.times {
            if let Some(row) = timings.rows.get_mut(*n) {
                row.stages.extend(times);
            }
        }
        RunOutcome {
            frames: records(tracking.frames, &mapping, &map),
            map,
            loops: mapping.loops,
            statistics,
            disparity_offset_px,
            calibration,
            timings,
            journal,
            interrupted,
            failure,
        }
    }
}

/// Every frame re-expressed in the final map; frames that became keyframes through these.
fn records(tracked: Vec<TrackedFrame>, mapping: &MapLog, map: &Map) -> Vec<FrameRecord> {
    let keyframe_of = |n: usize| -> Option<KeyframeId> {
        let at = mapping.inserted.binary_search_by_key(&n, |inserted| inserted.n).ok()?;
        // After a failure of mapping the map may be older than the keyframe.
        Some(mapping.inserted[at].keyframe).filter(|keyframe| map.resolve_keyframe(*keyframe).is_some())
    };
    let mut last: Option<RelativePose> = None;
    let mut records = Vec::with_capacity(tracked.len());
    for (n, TrackedFrame { answer, relative, .. }) in tracked.into_iter().enumerate() {
        let known = keyframe_of(n).map(RelativePose::of_keyframe).or(relative);
        // Frames that were not tracked repeat the last pose.
        let relative = known.or(last.filter(|_| !answer.status.has_pose()));
        records.push(FrameRecord {
            index: answer.index,
            timestamp_s: answer.timestamp_s,
            status: answer.status,
            world_from_cam: relative
                .and_then(|relative| relative.cam_from_world(map))
                .map(|cam_from_world| cam_from_world.normalized().inverse()),
            submap: relative.and_then(|relative| map.submap_of(relative.keyframe)),
            assessment: answer.assessment,
        });
        last = relative.or(last);
    }
    records
}

/// A frame that became a keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InsertedFrame {
    /// Position in the feed.
    pub(crate) n: usize,
    /// Number in its sequence.
    pub(crate) index: u32,
    pub(crate) keyframe: KeyframeId,
}

/// Complete up to the last operation, even if the stage fails at the next.
#[derive(Default)]
pub(crate) struct MapLog {
    pub(crate) operations: Vec<Operation>,
    /// In the order of their ids.
    pub(crate) inserted: Vec<InsertedFrame>,
    pub(crate) loops: Vec<LoopRecord>,
    pub(crate) statistics: Statistics,
    /// Times by position of the frame that they belong to.
    pub(crate) times: Vec<(usize, StageTimes)>,
    /// Whether corrections were still to come when the run was interrupted.
    pub(crate) cut_short: bool,
}
