//! The mapping stage: the operations of the map, one method each, noted in the journal. Who calls them in which order is
//! the schedule's business. Loops and global solutions are in `corrections.rs`.

mod corrections;

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use map::KeyframeId;
use slam::{KeyframeRequest, Mapper, RefinedCalibration, World};

use crate::events::Event;
use crate::failure::Halt;
use crate::journal::Operation;
use crate::outcome::{InsertedFrame, MapLog};
use crate::rule::{Moment, Rule};
use crate::run::Plan;
use crate::services::{GlobalService, LoopService, StageTimes};
use crate::snapshot::Published;
use crate::stages::track::Message;
use crate::timings::Stopwatch;
pub(crate) use corrections::{ComingGlobal, ComingLoop};

/// The stage.
pub(crate) struct MapStage {
    pub(crate) mapper: Mapper,
    /// `None`: loops are not looked for.
    loops: Option<LoopService>,
    global: GlobalService,
    /// Loops that were asked for, in the order of their keyframes.
    pub(crate) coming_loops: VecDeque<ComingLoop>,
    pub(crate) coming_global: Option<ComingGlobal>,
    /// Keyframes asked for, and those whose mapping is done.
    requests: usize,
    refined: usize,
    /// Whether an observer wants details.
    details: bool,
}

/// Where the stage writes to.
pub(crate) struct Out<'o> {
    pub(crate) log: &'o mut MapLog,
    pub(crate) emit: &'o mut dyn FnMut(Event),
    pub(crate) publish: &'o mut dyn FnMut(Published),
}

impl MapStage {
    /// A stage that continues with the world of the plan.
    pub(crate) fn new(plan: &Plan, loops: Option<LoopService>, global: GlobalService) -> Self {
        MapStage {
            mapper: Mapper::new(plan.setup.slam.clone(), plan.world.clone()),
            loops,
            global,
            coming_loops: VecDeque::new(),
            coming_global: None,
            requests: 0,
            refined: 0,
            details: plan.details,
        }
    }

    /// Everything that a message from tracking asks for; with a rule after the corrections that are due by it.
    ///
    /// # Errors
    /// When a service thread has ended or fails.
    pub(crate) fn take_in(
        &mut self,
        message: &Message,
        rule: Option<Rule>,
        out: &mut Out<'_>,
    ) -> Result<(), Halt> {
        self.count(message, out);
        let Some(request) = &message.keyframe else { return Ok(()) };
        if let Some(rule) = rule {
            self.bring_in(Moment::Insertion(message.n), rule, out)?;
        }
        let keyframe = self.insert(message.n, request, out);
        self.publish(out);
        self.refine(message.n, request, keyframe, out);
        let world = self.publish(out);
        self.ask_for_loop(message.n, keyframe, world)
    }

    /// Brings in what is still to come at the end of a run; not if the run is to stop.
    ///
    /// # Errors
    /// When a service thread has ended or fails.
    pub(crate) fn finish(&mut self, rule: Rule, stop: &AtomicBool, out: &mut Out<'_>) -> Result<(), Halt> {
        // The second time brings in the global solution that the first may have started.
        for _ in 0..2 {
            let is_open = self.coming_global.is_some() || !self.coming_loops.is_empty();
            if is_open && stop.load(Ordering::Relaxed) {
                out.log.cut_short = true;
                return Ok(());
            }
            self.bring_in(Moment::End, rule, out)?;
        }
        self.settle(out);
        Ok(())
    }

    /// Takes over the global solution if it is due, then closes the loops that are due, in the order of their keyframes.
    fn bring_in(&mut self, moment: Moment, rule: Rule, out: &mut Out<'_>) -> Result<(), Halt> {
        if let Some(global) = self.coming_global.take_if(|global| moment.is_reached(global.due)) {
            self.adopt_answer(global.n, global.answer, out)?;
        }
        let mut closed = None;
        while self.coming_loops.front().is_some_and(|coming| rule.loop_is_due(coming.n, moment)) {
            let Some(found) = self.next_loop(out)? else { continue };
            let n = found.n;
            if self.close_loop(found, out) {
                closed = Some(n);
            }
        }
        if let Some(n) = closed {
            let due = Rule::global_due(moment, self.mapper.world().map.n_keyframes());
            self.start_global(n, due, out)?;
        }
        Ok(())
    }

    /// Shows the world as it is now to tracking; returns the snapshot.
    pub(crate) fn publish(&self, out: &mut Out<'_>) -> Arc<World> {
        let world = self.snapshot();
        if self.details {
            (out.emit)(Event::Published(world.clone()));
        }
        (out.publish)(Published {
            world: world.clone(),
            operation: out.log.operations.len(),
            inserted: self.requests,
            refined: self.refined,
        });
        world
    }

    /// The world as it is now.
    pub(crate) fn snapshot(&self) -> Arc<World> {
        Arc::new(self.mapper.world().clone())
    }

    /// Adds the statistics of a tracked frame.
    pub(crate) fn count(&mut self, message: &Message, out: &mut Out<'_>) {
        out.log.operations.push(Operation::Count(message.n));
        self.mapper.count(&message.counts);
    }

    /// Inserts a keyframe; `None` if the map refuses it.
    pub(crate) fn insert(
        &mut self,
        n: usize,
        request: &KeyframeRequest,
        out: &mut Out<'_>,
    ) -> Option<KeyframeId> {
        out.log.operations.push(Operation::Insert(n));
        self.requests += 1;
        let mut watch = Stopwatch::new(request.frame.index);
        let (inserted, index) = (self.mapper.insert(request, &mut watch), request.frame.index);
        self.note_times(n, index, watch.finish().stages, out);
        let keyframe = inserted?;
        out.log.inserted.push(InsertedFrame { n, index, keyframe });
        let map = &self.mapper.world().map;
        let is_root = map.keyframe(keyframe).is_some_and(|k| k.parent().is_none());
        if is_root && map.n_keyframes() > 1 {
            out.log.statistics.submaps_started += 1;
            (out.emit)(Event::SubmapStarted { frame: request.frame.index, keyframe });
        }
        Some(keyframe)
    }

    /// The slow work on a keyframe that was inserted, or on none.
    pub(crate) fn refine(
        &mut self,
        n: usize,
        request: &KeyframeRequest,
        keyframe: Option<KeyframeId>,
        out: &mut Out<'_>,
    ) {
        out.log.operations.push(Operation::Refine(n));
        self.refined += 1;
        let Some(id) = keyframe else { return };
        let before = self.mapper.world().calibration.clone();
        let mut watch = Stopwatch::new(request.frame.index);
        let report = watch.time("map", |watch| self.mapper.refine(id, watch));
        let frame = request.frame.index;
        self.note_times(n, frame, watch.finish().stages, out);
        (out.emit)(Event::Keyframe { id, frame, reason: request.reason, report });
        self.tell_calibration(before, frame, out);
    }

    /// Looks at the calibration once more after the last frame, if this run has changed the map.
    pub(crate) fn settle(&mut self, out: &mut Out<'_>) {
        let Some(last) = out.log.inserted.last() else { return };
        let (n, frame, mut watch) = (last.n, last.index, Stopwatch::new(last.index));
        out.log.operations.push(Operation::Settle);
        let before = self.mapper.world().calibration.clone();
        self.mapper.settle(&mut watch);
        self.note_times(n, frame, watch.finish().stages, out);
        self.tell_calibration(before, frame, out);
    }

    /// Tells of a calibration that is not the one `before`.
    fn tell_calibration(&self, before: Option<Arc<RefinedCalibration>>, frame: u32, out: &mut Out<'_>) {
        if let Some(calibration) = self.mapper.world().calibration.clone()
            && before.is_none_or(|before| !Arc::ptr_eq(&before, &calibration))
        {
            (out.emit)(Event::Calibrated { frame, calibration });
        }
    }

    /// Notes times of work that belongs to the frame at `n`, whose number is `frame`.
    fn note_times(&self, n: usize, frame: u32, stages: StageTimes, out: &mut Out<'_>) {
        if self.details {
            (out.emit)(Event::Stages { frame, stages: stages.clone() });
        }
        out.log.times.push((n, stages));
    }

    /// Notes times of a correction that the keyframe at `n` led to.
    fn note_correction(&self, n: usize, stages: StageTimes, out: &mut Out<'_>) {
        let inserted = &out.log.inserted;
        let at = inserted.binary_search_by_key(&n, |inserted| inserted.n);
        let frame = at.map_or(0, |at| inserted[at].index);
        self.note_times(n, frame, stages, out);
    }
}
