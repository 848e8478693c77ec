//! A run: the calibration pass, if there is one, then all frames by the schedule asked for.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use geometry::Sensor;
use slam::{OffsetEstimate, estimate_disparity_offset};

use crate::events::{Event, Observer};
use crate::feed::FrameFeed;
use crate::job::{Job, Plan};
use crate::outcome::Parts;
use crate::record::{RunError, RunOutcome};
use crate::sequential;
use crate::setup::{Schedule, Setup};
use crate::threads::{self, Manner};

/// Runs over all frames of `feed`, or until `stop` becomes true; what was computed until then is returned. The same
/// frames and setup give the same bits with the schedules `Sequential` and `Lockstep`, whatever the number of threads.
///
/// # Errors
/// If the feed is empty or a thread cannot be started.
pub fn run(
    feed: &dyn FrameFeed,
    setup: &Setup,
    observer: &mut dyn Observer,
    stop: &AtomicBool,
) -> Result<RunOutcome, RunError> {
    if feed.size_hint() == Some(0) {
        return Err(RunError::NoFrames);
    }
    let calibration = calibrate(feed, setup, observer, stop)?;
    let disparity_offset_px =
        setup.stereo.disparity_offset_px + calibration.map_or(0.0, |estimate| estimate.offset_px);
    let frames = feed.size_hint();
    observer.event(&Event::Started { frames });
    let plan = Arc::new(Plan::new(setup.clone(), disparity_offset_px, observer.wants_details()));
    let parts = execute(&Job { feed, frames, stop, plan: plan.clone() }, setup.schedule, observer)?;
    Ok(RunOutcome { calibration, ..parts.outcome(&plan) })
}

fn execute(job: &Job<'_>, schedule: Schedule, observer: &mut dyn Observer) -> Result<Parts, RunError> {
    match schedule {
        Schedule::Sequential => sequential::run(job, observer),
        Schedule::Lockstep => threads::run(job, Manner::Lockstep, observer),
        Schedule::Live { realtime } => threads::run(job, Manner::Live { realtime }, observer),
    }
}

/// A first pass over the first frames whose only result is the disparity offset. It needs no loops, and never drops a
/// frame, also before a live run.
fn calibrate(
    feed: &dyn FrameFeed,
    setup: &Setup,
    observer: &mut dyn Observer,
    stop: &AtomicBool,
) -> Result<Option<OffsetEstimate>, RunError> {
    let frames =
        feed.size_hint().map_or(setup.stereo.calibration_frames, |n| n.min(setup.stereo.calibration_frames));
    if frames == 0 || setup.sensor != Sensor::Stereo {
        return Ok(None);
    }
    let pass = Setup { vocabulary: None, start: None, ..setup.clone() };
    let plan = Arc::new(Plan::new(pass, setup.stereo.disparity_offset_px, false));
    let job = Job { feed, frames: Some(frames), stop, plan };
    let schedule = match setup.schedule {
        Schedule::Sequential => Schedule::Sequential,
        Schedule::Lockstep | Schedule::Live { .. } => Schedule::Lockstep,
    };
    let parts = execute(&job, schedule, &mut PassProgress { observer, frames, done: 0 })?;
    if job.is_stopped() {
        return Ok(None);
    }
    let estimate = estimate_disparity_offset(&parts.world.map);
    observer.event(&Event::Calibrated { estimate });
    Ok(estimate)
}

/// Tells of the pass only how far it is.
struct PassProgress<'a> {
    observer: &'a mut dyn Observer,
    frames: usize,
    done: usize,
}

impl Observer for PassProgress<'_> {
    fn event(&mut self, event: &Event) {
        if let Event::Frame(_) = event {
            self.done += 1;
            self.observer.event(&Event::Calibrating { done: self.done, frames: self.frames });
        }
    }
}
