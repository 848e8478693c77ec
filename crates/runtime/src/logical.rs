//! Mapping by the rule: the order of operations follows from the order of messages and from frame numbers alone.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::failure::Halt;
use crate::mapping::{MapStage, Out};
use crate::rule::{Moment, Rule};
use crate::track::Message;

impl MapStage {
    /// Everything that a message from tracking asks for.
    ///
    /// # Errors
    /// When a service is gone or fails.
    pub(crate) fn follow(&mut self, message: &Message, rule: Rule, out: &mut Out<'_>) -> Result<(), Halt> {
        self.count(message, out);
        let Some(request) = &message.keyframe else { return Ok(()) };
        self.bring_in(Moment::Insertion(message.n), rule, out)?;
        let keyframe = self.insert(message.n, request, out);
        self.publish(out);
        self.refine(message.n, request, keyframe, out);
        let world = self.publish(out);
        self.ask_for_loop(message.n, keyframe, world)
    }

    /// Brings in what is still to come at the end of a run; not if the run is to stop.
    ///
    /// # Errors
    /// When a service is gone or fails.
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
}
