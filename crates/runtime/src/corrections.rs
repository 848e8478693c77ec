//! The two services of mapping: loops, found keyframe after keyframe, and global bundle adjustment.

use std::sync::Arc;

use map::KeyframeId;
use slam::{GlobalSolution, LoopCloser, LoopOutcome, World, adjust_globally};

use crate::faults::StageFaults;
use crate::service::Service;
use crate::setup::Setup;
use crate::timings::Stopwatch;

/// Times of the stages of an answer, milliseconds.
pub(crate) type StageTimes = Vec<(&'static str, f64)>;

/// Whether a keyframe sees a place again, asked with the world right after its mapping.
pub(crate) type LoopQuestion = (KeyframeId, Arc<World>);
/// The answer.
pub(crate) type LoopAnswer = (LoopOutcome, StageTimes);
/// The service that finds loops.
pub(crate) type LoopService = Service<LoopQuestion, LoopAnswer>;

/// The world right after a loop was closed.
pub(crate) type GlobalQuestion = Arc<World>;
/// The adjusted world; `None` when there was nothing to adjust.
pub(crate) type GlobalAnswer = (Option<GlobalSolution>, StageTimes);
/// The service that adjusts the whole map.
pub(crate) type GlobalService = Service<GlobalQuestion, GlobalAnswer>;

/// Answers questions about loops; they must come in the order of the keyframes.
pub(crate) fn find_loops(
    setup: &Setup,
    mut faults: StageFaults,
) -> impl FnMut(LoopQuestion) -> LoopAnswer + use<> {
    let mut closer = LoopCloser::new(setup.slam.clone());
    move |(keyframe, world)| {
        faults.step();
        let mut watch = Stopwatch::new(0);
        let outcome = watch.time("loop", |watch| closer.detect(keyframe, &world, watch));
        (outcome, watch.finish().stages)
    }
}

/// Answers with adjusted worlds.
pub(crate) fn adjust(
    setup: &Setup,
    mut faults: StageFaults,
) -> impl FnMut(GlobalQuestion) -> GlobalAnswer + use<> {
    let params = setup.slam.clone();
    move |world| {
        faults.step();
        let mut watch = Stopwatch::new(0);
        let solution = watch.time("global", |watch| adjust_globally(&world, &params, watch));
        (solution, watch.finish().stages)
    }
}
