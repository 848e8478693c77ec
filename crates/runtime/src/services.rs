//! The two services of mapping, loops and global bundle adjustment: stages that answer questions in their order, on a thread of their
//! own or in turn when the answer is wanted.

use std::sync::Arc;

use crossbeam::channel::{Receiver, Sender, bounded};
use map::KeyframeId;
use slam::{GlobalSolution, LoopCloser, LoopOutcome, World, adjust_globally};

use crate::failure::{Halt, caught};
use crate::faults::StageFaults;
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

/// Where questions go.
pub(crate) enum Service<Q, A> {
    /// Answers are computed when they are waited for.
    InTurn(&'static str, Box<dyn FnMut(Q) -> A + Send>),
    /// Answers are computed on a thread that reads this channel.
    Thread(Sender<Asked<Q, A>>),
}

/// A question with the way back for its answer. The way back holds one answer, so that answering never blocks.
pub(crate) type Asked<Q, A> = (Q, Sender<A>);

/// An answer to come.
pub(crate) enum Answer<Q, A> {
    /// Not yet computed.
    Open(Q),
    /// Computed elsewhere.
    Coming(Receiver<A>),
}

impl<Q, A> Service<Q, A> {
    /// Asks; blocks only while many questions are waiting.
    pub(crate) fn ask(&self, question: Q) -> Result<Answer<Q, A>, Halt> {
        match self {
            Service::InTurn(..) => Ok(Answer::Open(question)),
            Service::Thread(asked) => {
                let (back, answer) = bounded(1);
                asked.send((question, back)).map_err(|_| Halt::Gone)?;
                Ok(Answer::Coming(answer))
            }
        }
    }

    /// Waits for the answer. Answers must be waited for in the order of the questions, or be dropped.
    pub(crate) fn wait(&mut self, answer: Answer<Q, A>) -> Result<A, Halt> {
        match (self, answer) {
            (Service::InTurn(stage, work), Answer::Open(question)) => {
                caught(stage, || work(question)).map_err(Halt::Failed)
            }
            (_, Answer::Coming(answer)) => answer.recv().map_err(|_| Halt::Gone),
            (Service::Thread(_), Answer::Open(_)) => Err(Halt::Gone),
        }
    }
}

impl<Q, A> Answer<Q, A> {
    /// The channel that the answer comes through, if it does.
    pub(crate) fn channel(&self) -> Option<&Receiver<A>> {
        match self {
            Answer::Open(_) => None,
            Answer::Coming(answer) => Some(answer),
        }
    }
}

/// Answers every question, in order.
pub(crate) fn serve<Q, A>(asked: &Receiver<Asked<Q, A>>, mut work: impl FnMut(Q) -> A) {
    for (question, back) in asked {
        // Whoever asked may not want to know any more.
        let _ = back.send(work(question));
    }
}

/// Answers the newest question; older ones were discarded.
pub(crate) fn serve_newest<Q, A>(asked: &Receiver<Asked<Q, A>>, mut work: impl FnMut(Q) -> A) {
    for mut next in asked {
        next = asked.try_iter().last().unwrap_or(next);
        let _ = next.1.send(work(next.0));
    }
}
