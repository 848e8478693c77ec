//! Corrections of the map: loops that are asked for, found and closed, and global solutions.

use std::sync::Arc;

use map::KeyframeId;
use slam::{LoopCorrection, LoopOutcome, World};

use super::{MapStage, Out};
use crate::events::Event;
use crate::failure::Halt;
use crate::journal::Operation;
use crate::outcome::MapLog;
use crate::record::{LoopRecord, LoopResult};
use crate::services::{Answer, GlobalAnswer, GlobalQuestion, LoopAnswer, LoopQuestion, StageTimes};
use crate::timings::Stopwatch;

/// A loop that was asked for.
pub(crate) struct ComingLoop {
    /// Position of the keyframe's frame in the feed.
    pub(crate) n: usize,
    pub(crate) keyframe: KeyframeId,
    pub(crate) answer: Answer<LoopQuestion, LoopAnswer>,
}

/// A global solution that was asked for.
pub(crate) struct ComingGlobal {
    /// Position of the frame of the loop that started it.
    pub(crate) n: usize,
    /// The first frame at which it may be applied.
    pub(crate) due: usize,
    pub(crate) answer: Answer<GlobalQuestion, GlobalAnswer>,
}

/// A loop that was found and not closed yet.
pub(crate) struct FoundLoop {
    pub(crate) n: usize,
    pub(crate) found: Box<LoopCorrection>,
}

impl MapStage {
    /// Asks whether a keyframe sees a place again, in the world right after its mapping.
    pub(crate) fn ask_for_loop(
        &mut self,
        n: usize,
        keyframe: Option<KeyframeId>,
        world: Arc<World>,
    ) -> Result<(), Halt> {
        let (Some(loops), Some(keyframe)) = (&self.loops, keyframe) else { return Ok(()) };
        if world.map.keyframe(keyframe).is_none() {
            return Ok(());
        }
        let answer = loops.ask((keyframe, world))?;
        self.coming_loops.push_back(ComingLoop { n, keyframe, answer });
        Ok(())
    }

    /// Waits for the answer about the oldest keyframe that was asked for; a loop, if it is one.
    pub(crate) fn next_loop(&mut self, out: &mut Out<'_>) -> Result<Option<FoundLoop>, Halt> {
        let (Some(loops), Some(coming)) = (&mut self.loops, self.coming_loops.pop_front()) else {
            return Ok(None);
        };
        let (outcome, times) = loops.wait(coming.answer)?;
        Ok(self.judge(coming.n, coming.keyframe, outcome, times, out))
    }

    /// Records the outcome of the search for a loop.
    pub(crate) fn judge(
        &self,
        n: usize,
        keyframe: KeyframeId,
        outcome: LoopOutcome,
        times: StageTimes,
        out: &mut Out<'_>,
    ) -> Option<FoundLoop> {
        self.note_correction(n, times, out);
        match outcome {
            LoopOutcome::None(_) => None,
            LoopOutcome::Rejected { candidate, reason } => {
                let result = LoopResult::Rejected(reason.to_string());
                self.note_loop(keyframe, candidate, result, out);
                None
            }
            LoopOutcome::Closed(found) => {
                (out.emit)(Event::LoopFound { keyframe, matched: found.matched, inliers: found.inliers });
                Some(FoundLoop { n, found })
            }
        }
    }

    /// Closes a loop; whether the map took it.
    pub(crate) fn close_loop(&mut self, FoundLoop { n, found }: FoundLoop, out: &mut Out<'_>) -> bool {
        out.log.operations.push(Operation::CloseLoop(n));
        let mut watch = Stopwatch::new(0);
        let closed = self.mapper.close_loop(&found, &mut watch);
        self.note_correction(n, watch.finish().stages, out);
        let result = match closed {
            Err(error) => LoopResult::Refused(error.to_string()),
            Ok(_) => LoopResult::Closed {
                inliers: found.inliers,
                moved_m: found.moved_m,
                turned_deg: found.turned_deg,
                joined: found.joins_submaps,
            },
        };
        let is_closed = matches!(result, LoopResult::Closed { .. });
        self.note_loop(found.keyframe, found.matched, result, out);
        let by = self.frame_index(found.keyframe, out.log);
        for &(matched, keyframe) in found.correction.taken_back.iter().filter(|_| is_closed) {
            self.note_loop(keyframe, matched, LoopResult::TakenBack { by }, out);
        }
        is_closed
    }

    fn note_loop(&self, keyframe: KeyframeId, matched: KeyframeId, result: LoopResult, out: &mut Out<'_>) {
        let record = LoopRecord {
            frame: self.frame_index(keyframe, out.log),
            keyframe,
            matched_frame: self.frame_index(matched, out.log),
            matched,
            result,
        };
        let statistics = &mut out.log.statistics;
        match &record.result {
            LoopResult::Closed { joined, .. } => {
                statistics.loops_closed += 1;
                statistics.submaps_joined += usize::from(*joined);
            }
            LoopResult::Rejected(_) | LoopResult::Refused(_) => statistics.loops_rejected += 1,
            LoopResult::TakenBack { .. } => statistics.loops_taken_back += 1,
        }
        (out.emit)(Event::Loop(record.clone()));
        out.log.loops.push(record);
    }

    /// Number of the frame that became a keyframe; of one that was removed from a map from a file, of its heir.
    fn frame_index(&self, keyframe: KeyframeId, log: &MapLog) -> u32 {
        let map = &self.mapper.world().map;
        match log.inserted.binary_search_by_key(&keyframe, |inserted| inserted.keyframe) {
            Ok(at) => log.inserted[at].index,
            Err(_) => {
                let heir = map.resolve_keyframe(keyframe).and_then(|(heir, _)| map.keyframe(heir));
                heir.map_or(0, |heir| heir.frame.index)
            }
        }
    }

    /// Starts a global bundle adjustment after the loop of frame `n`; one that is under way is discarded.
    pub(crate) fn start_global(&mut self, n: usize, due: usize, out: &mut Out<'_>) -> Result<(), Halt> {
        if let Some(old) = self.coming_global.take() {
            self.discard(old.n, out);
        }
        let answer = self.ask_for_global()?;
        self.coming_global = Some(ComingGlobal { n, due, answer });
        Ok(())
    }

    /// Asks for a global bundle adjustment of the world as it is now.
    pub(crate) fn ask_for_global(&self) -> Result<Answer<GlobalQuestion, GlobalAnswer>, Halt> {
        self.global.ask(self.snapshot())
    }

    /// Notes that the global solution which the loop of frame `n` started was discarded.
    pub(crate) fn discard(&self, n: usize, out: &mut Out<'_>) {
        out.log.operations.push(Operation::Discard(n));
        out.log.statistics.globals_discarded += 1;
        (out.emit)(Event::GlobalDiscarded);
    }

    /// Waits for a global solution that the loop of frame `n` started and takes it over.
    pub(crate) fn adopt_answer(
        &mut self,
        n: usize,
        answer: Answer<GlobalQuestion, GlobalAnswer>,
        out: &mut Out<'_>,
    ) -> Result<(), Halt> {
        let answer = self.global.wait(answer)?;
        self.adopt(n, answer, out);
        Ok(())
    }

    /// Takes over a global solution.
    pub(crate) fn adopt(&mut self, n: usize, (solution, times): GlobalAnswer, out: &mut Out<'_>) {
        out.log.operations.push(Operation::Adopt(n));
        self.note_correction(n, times, out);
        let Some(solution) = solution else { return };
        match self.mapper.adopt(&solution) {
            Ok(()) => {
                out.log.statistics.globals_adopted += 1;
                (out.emit)(Event::GlobalAdopted { cost: solution.cost });
            }
            Err(error) => (out.emit)(Event::GlobalRefused { reason: error.to_string() }),
        }
    }
}
