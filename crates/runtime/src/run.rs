//! A run: all frames by the schedule asked for.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use slam::World;

use crate::events::{Event, Observer};
use crate::faults::StageFaults;
use crate::feed::FrameFeed;
use crate::outcome::Parts;
use crate::record::{RunError, RunOutcome};
use crate::rule::Rule;
use crate::services::{GlobalService, LoopService, Service, adjust, find_loops};
use crate::setup::{Schedule, Setup};
use crate::stages::map::MapStage;
use crate::{lockstep, sequential};

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
    let frames = feed.size_hint();
    observer.event(&Event::Started { frames });
    let plan = Arc::new(Plan::new(setup.clone(), setup.stereo.disparity_offset_px, observer.wants_details()));
    let parts = execute(&Job { feed, frames, stop, plan: plan.clone() }, observer)?;
    Ok(parts.outcome(&plan))
}

fn execute(job: &Job<'_>, observer: &mut dyn Observer) -> Result<Parts, RunError> {
    match job.plan.setup.schedule {
        Schedule::Sequential => sequential::run(job, observer),
        Schedule::Lockstep | Schedule::Live { .. } => lockstep::run(job, observer),
    }
}

/// What the stages of a run are made from.
pub(crate) struct Plan {
    pub(crate) setup: Setup,
    pub(crate) disparity_offset_px: f64,
    /// The world to begin with.
    pub(crate) world: World,
    /// Whether an observer wants details.
    pub(crate) details: bool,
}

/// What is to be run.
pub(crate) struct Job<'a> {
    pub(crate) feed: &'a dyn FrameFeed,
    /// This many frames from the start; `None`: until the feed ends.
    pub(crate) frames: Option<usize>,
    pub(crate) stop: &'a AtomicBool,
    pub(crate) plan: Arc<Plan>,
}

impl Plan {
    pub(crate) fn new(setup: Setup, disparity_offset_px: f64, details: bool) -> Self {
        let world = setup.world();
        Plan { setup, disparity_offset_px, world, details }
    }

    pub(crate) fn faults(&self, stage: &'static str) -> StageFaults {
        self.setup.faults.of(stage)
    }

    /// A snapshot of the world to begin with.
    pub(crate) fn start(&self) -> Arc<World> {
        Arc::new(self.world.clone())
    }

    /// Whether loops are looked for at all.
    pub(crate) fn wants_loops(&self) -> bool {
        self.setup.slam.loops.enabled && self.setup.vocabulary.is_some()
    }

    /// The mapping stage with services that run in turn.
    pub(crate) fn mapping_in_turn(&self) -> MapStage {
        let loops: LoopService =
            Service::InTurn("loop", Box::new(find_loops(&self.setup, self.faults("loop"))));
        let global: GlobalService =
            Service::InTurn("global", Box::new(adjust(&self.setup, self.faults("global"))));
        let loops = Some(loops).filter(|_| self.wants_loops());
        MapStage::new(self, loops, global)
    }
}

impl Job<'_> {
    /// Whether the run should end after this frame.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// The rule that tracking and mapping go by; `None` for a live run.
    pub(crate) fn exact_rule(&self) -> Option<Rule> {
        let is_live = matches!(self.plan.setup.schedule, Schedule::Live { .. });
        (!is_live).then(|| self.plan.setup.rule())
    }

    /// Frames to come, as far as is known.
    pub(crate) fn limit(&self) -> usize {
        self.frames.unwrap_or(usize::MAX)
    }
}
