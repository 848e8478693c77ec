//! A run as the schedules get it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use slam::World;

use crate::corrections::{GlobalService, LoopService, adjust, find_loops};
use crate::faults::StageFaults;
use crate::feed::FrameFeed;
use crate::mapping::MapStage;
use crate::service::Service;
use crate::setup::Setup;

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
    /// The first so many frames; `None`: until the feed ends.
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

    /// Frames to come, as far as is known.
    pub(crate) fn limit(&self) -> usize {
        self.frames.unwrap_or(usize::MAX)
    }
}
