//! What `Live` does otherwise than `Lockstep`: frames at the pace of their timestamps, messages that never make tracking wait, and
//! mapping as things come, corrections as soon as they are there.

use std::collections::VecDeque;
use std::sync::atomic::AtomicBool;

use crossbeam::channel::{Receiver, Sender, TrySendError, never};
use crossbeam::select;

use crate::failure::Halt;
use crate::faults::StageFaults;
use crate::feed::FrameFeed;
use crate::rule::Rule;
use crate::services::{GlobalAnswer, LoopAnswer};
use crate::stages::fetch::{Fetched, fetch};
use crate::stages::map::{MapStage, Out};
use crate::stages::track::Message;
use crate::timings::Pace;

/// A frame is loaded this many times as long before it is due as loading has taken at most of late.
const LOADED_AHEAD: f64 = 2.0;
/// What a longer time of loading still counts one frame later.
const FORGETTING: f64 = 0.9;

/// Sends frames at the pace of their timestamps. Each is loaded shortly before it is due, since decoding right after the frame before
/// would take a core from its tracking. `slot` and `taken` are the ends of a channel for one frame: a frame
/// that nobody has taken by the time of the next one is replaced by it. Ends early when `reader_is_there` is closed. Returns how many
/// frames there are, as far as is known.
pub(crate) fn paced(
    feed: &dyn FrameFeed,
    frames: usize,
    mut faults: StageFaults,
    (slot, taken): (&Sender<Fetched>, &Receiver<Fetched>),
    reader_is_there: &Receiver<()>,
) -> usize {
    let pace = Pace::start();
    let mut loading_s = 0.0;
    for n in 0..frames {
        faults.step();
        if feed.ends_before(n) {
            return n;
        }
        let since_first = |feed: &dyn FrameFeed| feed.info(n).timestamp_s - feed.info(0).timestamp_s;
        let seconds = if feed.keeps_pace() { 0.0 } else { since_first(feed) };
        if !pace.wait(seconds - LOADED_AHEAD * loading_s, reader_is_there) {
            break;
        }
        let begun_s = pace.seconds();
        let fetched = fetch(feed, n);
        loading_s = f64::max(pace.seconds() - begun_s, FORGETTING * loading_s);
        if !pace.wait(seconds, reader_is_there) {
            break;
        }
        replace(slot, taken, fetched);
    }
    frames
}

/// Puts a value into a channel for one, replacing one that has not been taken yet.
pub(crate) fn replace<T>(slot: &Sender<T>, taken: &Receiver<T>, mut value: T) {
    while let Err(TrySendError::Full(back)) = slot.try_send(value) {
        // Either the reader has just taken the older value, or it is dropped here.
        drop(taken.try_recv());
        value = back;
    }
}

/// Messages that may wait in the channel.
pub(crate) const MESSAGES: usize = 32;

/// Sends messages in order; a live run keeps what does not fit and never waits.
pub(crate) struct Outbox {
    to_mapping: Sender<Message>,
    may_wait: bool,
    kept: VecDeque<Message>,
}

impl Outbox {
    pub(crate) fn new(to_mapping: Sender<Message>, may_wait: bool) -> Self {
        Outbox { to_mapping, may_wait, kept: VecDeque::new() }
    }

    /// Sends a message.
    ///
    /// # Errors
    /// When mapping is gone.
    pub(crate) fn send(&mut self, message: Message) -> Result<(), Halt> {
        if self.may_wait {
            return self.to_mapping.send(message).map_err(|_| Halt::Gone);
        }
        self.kept.push_back(message);
        while let Some(next) = self.kept.pop_front() {
            match self.to_mapping.try_send(next) {
                Ok(()) => {}
                Err(TrySendError::Full(next)) => {
                    self.kept.push_front(next);
                    break;
                }
                Err(TrySendError::Disconnected(_)) => return Err(Halt::Gone),
            }
        }
        Ok(())
    }

    /// At the end of a run: sends what was kept, and closes the channel.
    pub(crate) fn close(self) {
        for message in self.kept {
            if self.to_mapping.send(message).is_err() {
                return;
            }
        }
    }
}

impl MapStage {
    /// Works until tracking is gone, then brings in what is still to come.
    ///
    /// # Errors
    /// When a service thread has ended or fails.
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
                    self.take_in(&message, None, out)?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crossbeam::channel::bounded;

    fn message(n: usize) -> Message {
        Message { n, counts: Vec::new(), keyframe: None }
    }

    #[test]
    fn what_does_not_fit_is_kept_in_order() {
        let (sender, messages) = bounded(2);
        let mut outbox = Outbox::new(sender, false);
        (0..5).for_each(|n| outbox.send(message(n)).unwrap());
        assert_eq!(messages.len(), 2);
        let mut order: Vec<usize> = messages.try_iter().map(|message| message.n).collect();
        outbox.send(message(5)).unwrap();
        order.extend(messages.try_iter().map(|message| message.n));
        assert_eq!(order, [0, 1, 2, 3]);
        outbox.close();
        order.extend(messages.iter().map(|message| message.n));
        assert_eq!(order, [0, 1, 2, 3, 4, 5]);
    }

    #[test]
    fn without_mapping_nothing_is_sent() {
        for may_wait in [false, true] {
            let (sender, messages) = bounded(1);
            drop(messages);
            assert_eq!(Outbox::new(sender, may_wait).send(message(0)), Err(Halt::Gone));
        }
    }
}
