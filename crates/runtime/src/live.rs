//! Mapping as things come: messages in their order, corrections as soon as they are there.

use std::sync::atomic::AtomicBool;

use crossbeam::channel::{Receiver, never};
use crossbeam::select;

use crate::corrections::{GlobalAnswer, LoopAnswer};
use crate::failure::Halt;
use crate::faults::StageFaults;
use crate::mapping::{MapStage, Out};
use crate::rule::Rule;
use crate::track::Message;

impl MapStage {
    /// Works until tracking is gone, then brings in what is still to come.
    ///
    /// # Errors
    /// When a service is gone or fails.
    pub(crate) fn live(
        &mut self,
        messages: &Receiver<Message>,
        (rule, stop): (Rule, &AtomicBool),
        faults: &mut StageFaults,
        out: &mut Out<'_>,
    ) -> Result<(), Halt> {
        loop {
            let loops: Receiver<LoopAnswer> =
                self.coming_loops.front().and_then(|c| c.answer.channel()).cloned().unwrap_or_else(never);
            let global: Receiver<GlobalAnswer> =
                self.coming_global.as_ref().and_then(|c| c.answer.channel()).cloned().unwrap_or_else(never);
            select! {
                recv(messages) -> message => {
                    let Ok(message) = message else { break };
                    faults.step();
                    self.take_in(&message, out)?;
                }
                recv(loops) -> answer => self.take_loop(answer.map_err(|_| Halt::Gone)?, out)?,
                recv(global) -> answer => {
                    let answer = answer.map_err(|_| Halt::Gone)?;
                    if let Some(coming) = self.coming_global.take() {
                        self.adopt(coming.n, answer, out);
                        self.publish(out);
                    }
                }
            }
        }
        self.finish(rule, stop, out)
    }

    fn take_in(&mut self, message: &Message, out: &mut Out<'_>) -> Result<(), Halt> {
        self.count(message, out);
        let Some(request) = &message.keyframe else { return Ok(()) };
        let keyframe = self.insert(message.n, request, out);
        self.publish(out);
        self.refine(message.n, request, keyframe, out);
        let world = self.publish(out);
        self.ask_for_loop(message.n, keyframe, world)
    }

    fn take_loop(&mut self, (outcome, times): LoopAnswer, out: &mut Out<'_>) -> Result<(), Halt> {
        let Some(coming) = self.coming_loops.pop_front() else { return Ok(()) };
        let Some(found) = self.judge(coming.n, coming.keyframe, outcome, times, out) else { return Ok(()) };
        let n = found.n;
        if self.close_loop(found, out) {
            self.publish(out);
            self.start_global(n, 0, out)?;
        }
        Ok(())
    }
}
