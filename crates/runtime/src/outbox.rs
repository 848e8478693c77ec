//! Tracking's end of the channel to mapping.

use std::collections::VecDeque;

use crossbeam::channel::{Sender, TrySendError};

use crate::failure::Halt;
use crate::track::Message;

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
