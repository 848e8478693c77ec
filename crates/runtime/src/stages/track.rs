//! The tracking stage: a frame and a state of the map give a record and a message to mapping.

use std::sync::Arc;

use crossbeam::channel::{Receiver, Sender};
use features::Frame;
use map::{PointCount, RelativePose};
use slam::{KeyframeRequest, Placement, TrackState, Tracked, Tracker};

use crate::events::{Event, FrameAnswer, FrameDetails};
use crate::failure::caught;
use crate::feed::FrameInfo;
use crate::journal::Seen;
use crate::live::Outbox;
use crate::lockstep::TrackLeft;
use crate::record::{FrameStatus, Unusable};
use crate::run::{Job, Plan};
use crate::snapshot::{Snapshots, View};
use crate::stages::fetch::{Extracted, Passing};
use crate::stages::motion::Motion;
use crate::timings::{FrameTimings, Stopwatch};

/// What tracking of a frame tells mapping.
pub(crate) struct Message {
    /// Position of the frame in the feed.
    pub(crate) n: usize,
    pub(crate) counts: Vec<PointCount>,
    pub(crate) keyframe: Option<KeyframeRequest>,
}

/// A frame after tracking.
pub(crate) struct TrackedFrame {
    pub(crate) answer: FrameAnswer,
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
    pub(crate) relocalizations: usize,
    /// Keyframes and points of the map that the last frame saw.
    map_size: (usize, usize),
}

/// The stage.
pub(crate) struct TrackStage {
    tracker: Tracker,
    motion: Motion,
    /// Whether an observer wants details.
    details: bool,
}

impl TrackStage {
    pub(crate) fn new(plan: &Plan) -> Self {
        let tracker = Tracker::new(plan.setup.slam.clone());
        TrackStage { tracker, motion: Motion::default(), details: plan.details }
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
    ) -> Result<(FrameAnswer, Option<Message>), E> {
        let Passing { n, info, content, mut watch } = extracted;
        let (frame, images) = match content {
            Ok(content) => content,
            Err(reason) => {
                let answer = log.without_tracking((info, reason), Seen::Unusable, watch, emit);
                return Ok((answer, None));
            }
        };
        let view = view(&mut watch)?;
        let extract_ms = watch.last("extract");
        let mut tracked =
            watch.time("track", |watch| self.tracker.track(&frame, &view.world, view.idle, watch));
        watch.add_to_last(extract_ms);
        let mut answer = answer(info, &frame, &tracked, &view, watch.last("track"));
        if let Some(world_from_cam) = &answer.world_from_cam {
            let last = (frame.index, tracked.pose, answer.keyframe.is_some());
            answer.last_from_cam = self.motion.to(&view.world.map, last, &world_from_cam.inverse());
        }
        emit(Event::Frame(Box::new(answer.clone())));
        note_relocalization(&tracked, &info, &view, log, emit);
        log.map_size = (answer.keyframes, answer.points);
        let timings = watch.finish();
        if self.details {
            let (answer, stages) = (answer.clone(), timings.stages.clone());
            let trust = self.tracker.trust(&view.world.map, &tracked.matched);
            let details = FrameDetails::new(answer, (frame, images), (&mut tracked, trust), &view, stages);
            emit(Event::Details(Arc::new(details)));
        }
        let seen = Seen::After(view.operation, view.idle);
        log.frames.push(TrackedFrame { answer: answer.clone(), relative: tracked.pose, seen, timings });
        Ok((answer, Some(Message { n, counts: tracked.counts, keyframe: tracked.keyframe })))
    }
}

impl TrackLog {
    /// Records a frame that was not tracked.
    pub(crate) fn without_tracking(
        &mut self,
        (info, reason): (FrameInfo, Unusable),
        seen: Seen,
        watch: Stopwatch,
        emit: &mut dyn FnMut(Event),
    ) -> FrameAnswer {
        let answer = FrameAnswer::without_pose(info, FrameStatus::Dropped(reason), self.map_size);
        emit(Event::Frame(Box::new(answer.clone())));
        let timings = watch.finish();
        self.frames.push(TrackedFrame { answer: answer.clone(), relative: None, seen, timings });
        answer
    }
}

/// Notices when a lost camera found its place again.
fn note_relocalization(
    tracked: &Tracked,
    info: &FrameInfo,
    view: &View,
    log: &mut TrackLog,
    emit: &mut dyn FnMut(Event),
) {
    if let (true, Some(keyframe)) = (tracked.stats.relocalized, tracked.pose.map(|pose| pose.keyframe)) {
        log.relocalizations += 1;
        let submap = view.world.map.submap_of(keyframe);
        emit(Event::Relocalized { frame: info.index, keyframe, submap });
    }
}

fn answer(info: FrameInfo, frame: &Frame, tracked: &Tracked, view: &View, track_ms: f64) -> FrameAnswer {
    let (status, map) = (status_of(tracked), &view.world.map);
    let pose = tracked.pose.filter(|_| status.has_pose()).map(|pose| pose.on_living(map));
    let cam_from_world = match tracked.keyframe.as_ref().map(|request| request.placement) {
        Some(Placement::NewSubmap { cam_from_world }) => Some(cam_from_world),
        _ => pose.and_then(|pose| pose.cam_from_world(map)),
    };
    FrameAnswer {
        world_from_cam: cam_from_world.map(|cam_from_world| cam_from_world.normalized().inverse()),
        submap: pose.and_then(|pose| map.submap_of(pose.keyframe)),
        assessment: tracked.assessment.clone(),
        keyframe: tracked.keyframe.as_ref().map(|request| request.reason),
        stats: tracked.stats,
        features: frame.len(),
        with_depth: frame.n_with_depth(),
        track_ms,
        ..FrameAnswer::without_pose(info, status, (map.n_keyframes(), map.n_points()))
    }
}

fn status_of(tracked: &Tracked) -> FrameStatus {
    match tracked.state {
        TrackState::NotReady(reason) => FrameStatus::NotReady(reason),
        TrackState::Started | TrackState::Tracked => FrameStatus::Tracked { inliers: tracked.stats.inliers },
        TrackState::Lost(reason) => FrameStatus::Lost(reason),
    }
}

/// Tracks until no frame comes, mapping is gone or the run is to stop.
pub(crate) fn track(
    job: &Job<'_>,
    extracted: Receiver<Extracted>,
    mut snapshots: Snapshots,
    mut outbox: Outbox,
    to_observer: Sender<Event>,
) -> TrackLeft {
    let mut log = TrackLog::default();
    let ended = caught("track", || {
        track_all(job, extracted, &mut snapshots, &mut outbox, &mut log, &to_observer);
    });
    outbox.close();
    TrackLeft { log, snapshots: Some(snapshots), failure: ended.err() }
}

fn track_all(
    job: &Job<'_>,
    extracted: Receiver<Extracted>,
    snapshots: &mut Snapshots,
    outbox: &mut Outbox,
    log: &mut TrackLog,
    to_observer: &Sender<Event>,
) {
    let mut stage = TrackStage::new(&job.plan);
    let mut faults = job.plan.faults("track");
    // Without an observer there is nobody to tell.
    let emit = &mut |event: Event| drop(to_observer.send(event));
    for extracted in extracted {
        faults.step();
        let n = extracted.n;
        note_skipped(job, n, log, emit);
        let view = |watch: &mut Stopwatch| watch.time("wait", |_| snapshots.at(n));
        match stage.step(extracted, view, log, emit) {
            Ok((_, Some(message))) => {
                if message.keyframe.is_some() {
                    snapshots.request(n);
                }
                if outbox.send(message).is_err() {
                    return;
                }
            }
            Ok((_, None)) => {}
            Err(_) => return,
        }
        if job.is_stopped() {
            return;
        }
    }
}

/// Records the frames before the `n`-th that were replaced by newer ones.
fn note_skipped(job: &Job<'_>, n: usize, log: &mut TrackLog, emit: &mut dyn FnMut(Event)) {
    for skipped in log.frames.len()..n {
        let info = job.feed.info(skipped);
        let watch = Stopwatch::new(info.index);
        log.without_tracking((info, Unusable::Skipped), Seen::Skipped, watch, emit);
    }
}
