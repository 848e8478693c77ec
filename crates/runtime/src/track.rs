//! The tracking stage: a frame and a state of the map give a record and a message to mapping.

use std::sync::Arc;

use features::Frame;
use map::{PointCount, RelativePose};
use slam::{KeyframeRequest, TrackState, TrackStats, Tracked, Tracker};

use crate::details::FrameDetails;
use crate::events::Event;
use crate::extract::Extracted;
use crate::feed::FrameInfo;
use crate::job::Job;
use crate::journal::Seen;
use crate::record::FrameStatus;
use crate::timings::{FrameTimings, Stopwatch};
use crate::view::View;

/// What tracking of a frame tells mapping.
pub(crate) struct Message {
    /// Position of the frame in the feed.
    pub(crate) n: usize,
    pub(crate) counts: Vec<PointCount>,
    pub(crate) keyframe: Option<KeyframeRequest>,
}

/// A frame after tracking.
pub(crate) struct TrackedFrame {
    pub(crate) info: FrameInfo,
    pub(crate) status: FrameStatus,
    pub(crate) relative: Option<RelativePose>,
    pub(crate) seen: Seen,
    pub(crate) timings: FrameTimings,
}

/// What tracking leaves, complete up to the last frame even if the stage fails at the next.
#[derive(Default)]
pub(crate) struct TrackLog {
    /// By position in the feed, without a gap.
    pub(crate) frames: Vec<TrackedFrame>,
    /// Times that a lost camera, or one in a map from a file, found its place again.
    pub(crate) relocalisations: usize,
    /// Keyframes and points of the map that the last frame saw.
    map_size: (usize, usize),
}

/// Why a frame that came too early for tracking has no pose.
pub(crate) const SKIPPED: &str = "skipped: tracking was behind";

/// The stage.
pub(crate) struct TrackStage {
    tracker: Tracker,
    /// Whether an observer wants details.
    details: bool,
}

impl TrackStage {
    pub(crate) fn new(job: &Job<'_>) -> Self {
        TrackStage { tracker: Tracker::new(job.setup.slam.clone()), details: job.details }
    }

    /// Tracks a frame in what `view` gives; frames without usable images are recorded without asking for it.
    ///
    /// # Errors
    /// Those of `view`; the frame is then not recorded.
    pub(crate) fn step<E>(
        &mut self,
        extracted: Extracted,
        view: impl FnOnce(&mut Stopwatch) -> Result<View, E>,
        log: &mut TrackLog,
        emit: &mut dyn FnMut(Event),
    ) -> Result<Option<Message>, E> {
        let Extracted { n, info, frame, seen: looked_at, mut watch } = extracted;
        let frame = match frame {
            Ok(frame) => frame,
            Err(reason) => {
                log.without_tracking(info, FrameStatus::Dropped(reason), Seen::Unusable, watch, emit);
                return Ok(None);
            }
        };
        let view = view(&mut watch)?;
        let extract_ms = watch.last("extract");
        let mut tracked =
            watch.time("track", |watch| self.tracker.track(&frame, &view.world, view.idle, watch));
        watch.add_to_last(extract_ms);
        emit(frame_event(&frame, &tracked, &view, watch.last("track")));
        note_relocalisation(&tracked, &info, &view, log, emit);
        let map = &view.world.map;
        log.map_size = (map.n_keyframes(), map.n_points());
        let (status, timings) = (status_of(&tracked), watch.finish());
        if self.details {
            let stages = timings.stages.clone();
            let details =
                FrameDetails::new(info, status.clone(), (frame, looked_at), &mut tracked, &view, stages);
            emit(Event::Details(Arc::new(details)));
        }
        log.frames.push(TrackedFrame {
            info,
            status,
            relative: tracked.pose,
            seen: Seen::After(view.operation, view.idle),
            timings,
        });
        Ok(Some(Message { n, counts: tracked.counts, keyframe: tracked.keyframe }))
    }
}

impl TrackLog {
    /// Records a frame that was not tracked.
    pub(crate) fn without_tracking(
        &mut self,
        info: FrameInfo,
        status: FrameStatus,
        seen: Seen,
        watch: Stopwatch,
        emit: &mut dyn FnMut(Event),
    ) {
        emit(Event::Frame {
            index: info.index,
            timestamp_s: info.timestamp_s,
            status: status.clone(),
            stats: TrackStats::default(),
            features: 0,
            with_depth: 0,
            keyframes: self.map_size.0,
            points: self.map_size.1,
            track_ms: 0.0,
        });
        self.frames.push(TrackedFrame { info, status, relative: None, seen, timings: watch.finish() });
    }
}

/// Notices when a lost camera found its place again.
fn note_relocalisation(
    tracked: &Tracked,
    info: &FrameInfo,
    view: &View,
    log: &mut TrackLog,
    emit: &mut dyn FnMut(Event),
) {
    if let (true, Some(keyframe)) = (tracked.stats.relocalised, tracked.pose.map(|pose| pose.keyframe)) {
        log.relocalisations += 1;
        let submap = view.world.map.submap_of(keyframe);
        emit(Event::Relocalised { frame: info.index, keyframe, submap });
    }
}

fn frame_event(frame: &Arc<Frame>, tracked: &Tracked, view: &View, track_ms: f64) -> Event {
    Event::Frame {
        index: frame.index,
        timestamp_s: frame.timestamp_s,
        status: status_of(tracked),
        stats: tracked.stats,
        features: frame.len(),
        with_depth: frame.n_with_depth(),
        keyframes: view.world.map.n_keyframes(),
        points: view.world.map.n_points(),
        track_ms,
    }
}

fn status_of(tracked: &Tracked) -> FrameStatus {
    match tracked.state {
        TrackState::NotReady(reason) => FrameStatus::NotReady(reason),
        TrackState::Started | TrackState::Tracked => FrameStatus::Tracked { inliers: tracked.stats.inliers },
        TrackState::Lost(reason) => FrameStatus::Lost(reason),
    }
}
