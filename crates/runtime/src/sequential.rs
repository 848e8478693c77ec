//! `Sequential`: all stages in turn on the calling thread, frame after frame. The whole system, from top to bottom.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crossbeam::channel::{Sender, bounded};
use io::LoadedFrame;

use crate::events::{Event, FrameAnswer, Observer};
use crate::failure::{MapEnd, StageFailure, caught, map_caught};
use crate::faults::StageFaults;
use crate::feed::{FrameInfo, FrameMask};
use crate::lockstep::{joined, spawn};
use crate::outcome::{MapLog, Parts};
use crate::record::{RunError, RunOutcome, Unusable};
use crate::run::{Job, Plan};
use crate::setup::Setup;
use crate::snapshot::{EXACT_STATES, Published, Snapshots};
use crate::stages::extract::ExtractStage;
use crate::stages::fetch::{AHEAD, Fetched, Passing, ahead};
use crate::stages::map::{MapStage, Out};
use crate::stages::track::{Message, TrackLog, TrackStage};
use crate::timings::Stopwatch;

/// A run whose frames are pushed one by one: each is tracked, and the mapping that is due by the rule is done before
/// [`Sequential::step`] returns. Equal frames and setup give the bits of [`run`](crate::run) by the schedules `Sequential` and
/// `Lockstep`.
pub struct Sequential {
    plan: Arc<Plan>,
    extract: (ExtractStage, StageFaults),
    track: (TrackStage, StageFaults),
    snapshots: Snapshots,
    map: (MapStage, StageFaults),
    publish: Sender<Published>,
    tracking: TrackLog,
    mapping: MapLog,
    /// Frames taken so far.
    n_frames: usize,
    ended: Option<Ended>,
}

/// What ended the row of stages.
#[derive(Debug)]
enum Ended {
    /// A stage before mapping; the map can still be finished.
    Before(StageFailure),
    Map(MapEnd),
}

impl Ended {
    fn failure(&self) -> StageFailure {
        match self {
            Ended::Before(failure) => failure.clone(),
            // In turn, a service that is gone has failed.
            Ended::Map(end) => end.failure.clone().unwrap_or_else(|| StageFailure::gone("map")),
        }
    }
}

impl Sequential {
    /// A run that has seen no frame; its observers get no details. The setup's schedule has no meaning here.
    pub fn new(setup: Setup) -> Self {
        let disparity_offset_px = setup.stereo.disparity_offset_px;
        Self::of_plan(Arc::new(Plan::new(setup, disparity_offset_px, false)))
    }

    pub(crate) fn of_plan(plan: Arc<Plan>) -> Self {
        let (publish, states) = bounded(EXACT_STATES);
        Sequential {
            extract: (ExtractStage::new(&plan), plan.faults("extract")),
            track: (TrackStage::new(&plan), plan.faults("track")),
            snapshots: Snapshots::new(Some(plan.setup.rule()), plan.start(), states),
            map: (plan.mapping_in_turn(), plan.faults("map")),
            plan,
            publish,
            tracking: TrackLog::default(),
            mapping: MapLog::default(),
            n_frames: 0,
            ended: None,
        }
    }

    /// Takes the next frame; `images` may also be the reason why there are none, and a mask of this frame takes the place of the
    /// setup's. The answer is what observers get as [`Event::Frame`].
    ///
    /// # Errors
    /// The stage that panicked, at this frame or an earlier one; what was computed until then is left to
    /// [`Sequential::finish`].
    pub fn step(
        &mut self,
        info: FrameInfo,
        images: Result<LoadedFrame, Unusable>,
        mask: Option<FrameMask>,
        observer: &mut dyn Observer,
    ) -> Result<FrameAnswer, StageFailure> {
        let (content, watch) = (images.map(|images| (images, mask)), Stopwatch::new(info.index));
        self.take(Passing { n: self.n_frames, info, content, watch }, observer)
    }

    /// Brings in the corrections that are still to come, and puts the results together. Without any frame they are empty.
    pub fn finish(self, observer: &mut dyn Observer) -> RunOutcome {
        let plan = self.plan.clone();
        self.end(&AtomicBool::new(false), observer).outcome(&plan)
    }

    fn take(&mut self, fetched: Fetched, observer: &mut dyn Observer) -> Result<FrameAnswer, StageFailure> {
        if let Some(ended) = &self.ended {
            return Err(ended.failure());
        }
        self.n_frames += 1;
        self.frame(fetched, observer).map_err(|ended| self.ended.insert(ended).failure())
    }

    /// A frame through all stages.
    fn frame(&mut self, fetched: Fetched, observer: &mut dyn Observer) -> Result<FrameAnswer, Ended> {
        let n = fetched.n;
        let emit = &mut |event: Event| observer.event(&event);
        let (extract, faults) = &mut self.extract;
        let extracted = caught("extract", || {
            faults.step();
            extract.extract(fetched)
        });
        let extracted = extracted.map_err(Ended::Before)?;
        let ((track, faults), snapshots, log) = (&mut self.track, &mut self.snapshots, &mut self.tracking);
        let tracked = caught("track", || {
            faults.step();
            track.step(extracted, |_| snapshots.at(n), log, emit)
        });
        // In turn, the state of the rule is always there.
        let tracked = tracked.and_then(|tracked| tracked.map_err(|_| StageFailure::gone("track")));
        let (answer, message) = tracked.map_err(Ended::Before)?;
        if let Some(message) = message {
            if message.keyframe.is_some() {
                self.snapshots.request(n);
            }
            self.map(&message, emit).map_err(Ended::Map)?;
        }
        Ok(answer)
    }

    fn map(&mut self, message: &Message, emit: &mut dyn FnMut(Event)) -> Result<(), MapEnd> {
        let rule = self.plan.setup.rule();
        let ((map, faults), publish, log) = (&mut self.map, &self.publish, &mut self.mapping);
        map_caught(|| {
            faults.step();
            map.take_in(message, Some(rule), &mut Out { log, emit, publish: &mut shown_through(publish) })
        })
    }

    /// Everything that is still to come, unless the run is to stop.
    fn end(mut self, stop: &AtomicBool, observer: &mut dyn Observer) -> Parts {
        let (rule, map, log) = (self.plan.setup.rule(), &mut self.map.0, &mut self.mapping);
        let emit = &mut |event: Event| observer.event(&event);
        let mut publish = shown_through(&self.publish);
        let mut finish = |failure: Option<StageFailure>| {
            let mut out = Out { log, emit, publish: &mut publish };
            match map_caught(|| map.finish(rule, stop, &mut out)) {
                Ok(()) => MapEnd { is_whole: true, failure },
                Err(end) => MapEnd { failure: failure.or(end.failure), ..end },
            }
        };
        let end = match self.ended {
            None => finish(None),
            Some(Ended::Before(failure)) => finish(Some(failure)),
            Some(Ended::Map(end)) => end,
        };
        let world = if end.is_whole {
            self.map.0.mapper.into_world()
        } else {
            Arc::unwrap_or_clone(self.snapshots.newest())
        };
        let (tracking, mapping) = (self.tracking, self.mapping);
        Parts { tracking, mapping, world, frames: self.n_frames, failure: end.failure }
    }
}

/// Shows a state of the map to tracking.
fn shown_through(publish: &Sender<Published>) -> impl FnMut(Published) {
    |state: Published| {
        // There is always room: tracking takes what the rule demands before it asks for more.
        let _ = publish.try_send(state);
    }
}

/// Runs over a feed; only images are decoded ahead, on a thread of their own.
pub(crate) fn run(job: &Job<'_>, observer: &mut dyn Observer) -> Result<Parts, RunError> {
    std::thread::scope(|scope| {
        let (to_here, fetched) = bounded(AHEAD);
        let faults = job.plan.faults("decode");
        let decode = spawn(scope, "decode", move || ahead(job.feed, job.limit(), faults, &to_here))?;
        let mut line = Sequential::of_plan(job.plan.clone());
        for fetched in fetched {
            if line.take(fetched, observer).is_err() || job.is_stopped() {
                break;
            }
        }
        let mut parts = line.end(job.stop, observer);
        match joined(decode) {
            Ok(frames) => parts.frames = frames,
            Err(failure) => {
                parts.frames = job.limit();
                parts.failure = parts.failure.or(Some(failure));
            }
        }
        Ok(parts)
    })
}
