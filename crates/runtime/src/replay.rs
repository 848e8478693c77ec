//! A run done again from its journal, in turn: the same states seen by the same frames, the same order of operations.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use map::KeyframeId;
use slam::World;

use crate::events::{Event, Observer};
use crate::failure::{Halt, MapEnd, StageFailure, caught, map_caught};
use crate::feed::FrameFeed;
use crate::journal::{Journal, JournalError, Operation, Seen};
use crate::outcome::{MapLog, Parts};
use crate::record::{RunError, RunOutcome, Unusable};
use crate::run::{Job, Plan};
use crate::services::Answer;
use crate::services::{GlobalAnswer, GlobalQuestion};
use crate::setup::Setup;
use crate::snapshot::View;
use crate::stages::extract::ExtractStage;
use crate::stages::fetch::fetch;
use crate::stages::map::{MapStage, Out};
use crate::stages::track::{Message, TrackLog, TrackStage};
use crate::timings::Stopwatch;

/// Does the run of a journal again; equal frames and setup give the bits of that run. The setup's schedule and lags have no
/// meaning here.
///
/// # Errors
/// [`RunError::Journal`] when the journal does not belong to these frames and this setup.
pub fn replay(
    feed: &dyn FrameFeed,
    setup: &Setup,
    journal: &Journal,
    observer: &mut dyn Observer,
    stop: &AtomicBool,
) -> Result<RunOutcome, RunError> {
    if journal.setup != setup.fingerprint() {
        return Err(JournalError::OtherSetup.into());
    }
    let frames = journal.n_frames();
    if let Some(available) = feed.size_hint().filter(|&available| frames > available) {
        return Err(JournalError::TooLong { frames, available }.into());
    }
    let plan = Arc::new(Plan::new(setup.clone(), journal.disparity_offset_px(), observer.wants_details()));
    let job = Job { feed, frames: Some(frames), stop, plan: plan.clone() };
    observer.event(&Event::Started { frames: Some(frames) });
    let (mut tracking, mut mapping) = (TrackLog::default(), MapLog::default());
    let mut emit = |event: Event| observer.event(&event);
    let mut out = Out { log: &mut mapping, emit: &mut emit, publish: &mut |_| {} };
    let mut replay = Replay {
        journal,
        map: plan.mapping_in_turn(),
        done: 0,
        seen: (0, plan.start()),
        messages: BTreeMap::new(),
        keyframes: BTreeMap::new(),
        solutions: BTreeMap::new(),
        is_whole: true,
    };
    let failure = match replay.work(&job, &mut tracking, &mut out) {
        Ok(()) => None,
        Err(Stop::Journal(error)) => return Err(error.into()),
        Err(Stop::Stage(failure)) => Some(failure),
    };
    let world =
        if replay.is_whole { replay.map.mapper.into_world() } else { Arc::unwrap_or_clone(replay.seen.1) };
    Ok(Parts { tracking, mapping, world, frames, failure }.outcome(&plan))
}

/// Why a replay ends early.
enum Stop {
    Journal(JournalError),
    Stage(StageFailure),
}

struct Replay<'a> {
    journal: &'a Journal,
    map: MapStage,
    /// Operations done.
    done: usize,
    /// The world after this number of operations, as a frame saw it last.
    seen: (usize, Arc<World>),
    /// By position in the feed: what tracking told and mapping still needs.
    messages: BTreeMap<usize, Message>,
    /// By position in the feed: keyframes that were inserted and not refined yet.
    keyframes: BTreeMap<usize, Option<KeyframeId>>,
    /// By position of the loop's frame: global solutions that were started.
    solutions: BTreeMap<usize, Answer<GlobalQuestion, GlobalAnswer>>,
    /// Whether no operation has panicked.
    is_whole: bool,
}

impl Replay<'_> {
    fn work(&mut self, job: &Job<'_>, tracking: &mut TrackLog, out: &mut Out<'_>) -> Result<(), Stop> {
        let mut extract = ExtractStage::new(&job.plan);
        let mut track = TrackStage::new(&job.plan);
        for n in 0..self.journal.n_frames() {
            let view = match self.journal.frames[n] {
                Seen::Skipped => {
                    let info = job.feed.info(n);
                    let (skipped, watch) = ((info, Unusable::Skipped), Stopwatch::new(info.index));
                    tracking.without_tracking(skipped, Seen::Skipped, watch, out.emit);
                    continue;
                }
                Seen::Unusable => None,
                Seen::After(operation, idle) => Some(self.view(operation, idle, out)?),
            };
            let extracted = caught("extract", || extract.extract(fetch(job.feed, n))).map_err(Stop::Stage)?;
            let unusable = || misfit(format!("frame {n} was unusable in the recorded run"));
            let message =
                caught("track", || track.step(extracted, |_| view.ok_or_else(unusable), tracking, out.emit));
            match message.map_err(Stop::Stage)??.1 {
                Some(message) => drop(self.messages.insert(n, message)),
                None if self.journal.frames[n] == Seen::Unusable => {}
                None => return Err(misfit(format!("frame {n} is unusable in this run"))),
            }
            if job.is_stopped() {
                return Ok(());
            }
        }
        self.advance(self.journal.operations.len(), out)?;
        self.hear_the_rest(out)
    }

    /// The world after this number of operations.
    fn view(&mut self, operation: usize, idle: bool, out: &mut Out<'_>) -> Result<View, Stop> {
        self.advance(operation, out)?;
        if self.seen.0 != operation {
            self.seen = (operation, self.map.snapshot());
        }
        Ok(View { world: self.seen.1.clone(), operation, idle })
    }

    fn advance(&mut self, to: usize, out: &mut Out<'_>) -> Result<(), Stop> {
        let journal = self.journal;
        let operations = journal.operations.get(self.done..to).ok_or_else(|| {
            misfit(format!("a frame saw the map after {to} operations, {} were done by then", self.done))
        })?;
        for &operation in operations {
            self.done += 1;
            let mut fits = true;
            let ended = map_caught(|| {
                fits = self.apply(operation, out)?;
                Ok(())
            });
            self.note_end(ended)?;
            if !fits {
                return Err(misfit(format!("{operation:?} is impossible as operation {}", self.done)));
            }
        }
        Ok(())
    }

    /// Does an operation; `false` if it is not possible.
    fn apply(&mut self, operation: Operation, out: &mut Out<'_>) -> Result<bool, Halt> {
        match operation {
            Operation::Count(n) => {
                let Some(message) = self.messages.get(&n) else { return Ok(false) };
                self.map.count(message, out);
                if message.keyframe.is_none() {
                    self.messages.remove(&n);
                }
            }
            Operation::Insert(n) => {
                let request = self.messages.get(&n).and_then(|message| message.keyframe.as_ref());
                let Some(request) = request else { return Ok(false) };
                self.keyframes.insert(n, self.map.insert(n, request, out));
            }
            Operation::Refine(n) => {
                let (Some(message), Some(keyframe)) = (self.messages.remove(&n), self.keyframes.remove(&n))
                else {
                    return Ok(false);
                };
                let Some(request) = &message.keyframe else { return Ok(false) };
                self.map.refine(n, request, keyframe, out);
                self.map.ask_for_loop(n, keyframe, self.map.snapshot())?;
            }
            Operation::CloseLoop(n) => return self.close_loop(n, out),
            Operation::Adopt(n) => {
                let Some(answer) = self.solutions.remove(&n) else { return Ok(false) };
                self.map.adopt_answer(n, answer, out)?;
            }
            Operation::Discard(n) => {
                if self.solutions.remove(&n).is_none() {
                    return Ok(false);
                }
                self.map.discard(n, out);
            }
            Operation::Settle => self.map.settle(out),
        }
        Ok(true)
    }

    /// Closes the loop of frame `n`. Which of several loops closed at once has started the global solution is seen by the
    /// operation that takes it over or gives it up.
    fn close_loop(&mut self, n: usize, out: &mut Out<'_>) -> Result<bool, Halt> {
        while self.map.coming_loops.front().is_some_and(|coming| coming.n <= n) {
            if let Some(found) = self.map.next_loop(out)? {
                if found.n != n {
                    return Ok(false);
                }
                if self.map.close_loop(found, out) {
                    self.solutions.insert(n, self.map.ask_for_global()?);
                }
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Receives the outcome of the keyframes at which no loop was closed, for the record only.
    fn hear_the_rest(&mut self, out: &mut Out<'_>) -> Result<(), Stop> {
        let ended = map_caught(|| {
            while !self.map.coming_loops.is_empty() {
                self.map.next_loop(out)?;
            }
            Ok(())
        });
        self.note_end(ended)
    }

    fn note_end(&mut self, ended: Result<(), MapEnd>) -> Result<(), Stop> {
        let Err(MapEnd { is_whole, failure }) = ended else { return Ok(()) };
        self.is_whole = is_whole;
        // In turn, a service that is gone has failed.
        Err(failure.map_or_else(|| misfit("a service thread has ended".into()), Stop::Stage))
    }
}

fn misfit(reason: String) -> Stop {
    Stop::Journal(JournalError::DoesNotFit(reason))
}
