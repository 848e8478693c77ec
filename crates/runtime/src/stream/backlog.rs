//! What waits for the writer without making anybody wait.

use std::collections::VecDeque;
use std::sync::Arc;

use crossbeam::channel::{Sender, TrySendError};
use events::Record;
use slam::World;

use super::worker::Item;

/// Items in their order. Records wait as long as it takes, of the map only its newest state, the rest not at all.
#[derive(Debug)]
pub(super) struct Backlog {
    sender: Sender<Item>,
    waiting: VecDeque<Item>,
    left_out: u64,
}

impl Backlog {
    pub(super) fn new(sender: Sender<Item>) -> Self {
        Backlog { sender, waiting: VecDeque::new(), left_out: 0 }
    }

    /// A record that must not be lost.
    pub(super) fn keep(&mut self, record: Record) {
        self.waiting.push_back(Item::Record(Box::new(record)));
        self.hand_on();
    }

    /// Something large that is left out while the writer is behind.
    pub(super) fn offer(&mut self, item: Item) {
        self.hand_on();
        if !self.waiting.is_empty() || self.sender.try_send(item).is_err() {
            self.left_out += 1;
        }
    }

    /// A state of the map; one that still waits is replaced by it.
    pub(super) fn show(&mut self, world: Arc<World>, frame: u32) {
        let before = self.waiting.len();
        self.waiting.retain(|item| !matches!(item, Item::Map { .. }));
        self.left_out += (before - self.waiting.len()) as u64;
        self.waiting.push_back(Item::Map { world, frame, is_last: false });
        self.hand_on();
    }

    /// The sender, everything that still waits, and how much was left out.
    pub(super) fn into_parts(self) -> (Sender<Item>, VecDeque<Item>, u64) {
        (self.sender, self.waiting, self.left_out)
    }

    fn hand_on(&mut self) {
        while let Some(item) = self.waiting.pop_front() {
            match self.sender.try_send(item) {
                Ok(()) => {}
                Err(TrySendError::Full(item)) => {
                    self.waiting.push_front(item);
                    return;
                }
                // The writer has panicked; what it would have written is lost.
                Err(TrySendError::Disconnected(_)) => self.waiting.clear(),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crossbeam::channel::bounded;
    use events::{Level, Text};

    fn text(text: &str) -> Record {
        Record::Text(Text { frame: None, level: Level::Info, text: text.to_owned() })
    }

    fn names(items: impl IntoIterator<Item = Item>) -> Vec<String> {
        let name = |item| match item {
            Item::Record(record) => match *record {
                Record::Text(text) => text.text,
                other => format!("{other:?}"),
            },
            Item::Map { frame, .. } => format!("map {frame}"),
            Item::Details(_) => "details".to_owned(),
        };
        items.into_iter().map(name).collect()
    }

    #[test]
    fn records_wait_in_order_and_of_the_map_only_the_newest_state() {
        let (sender, items) = bounded(2);
        let mut backlog = Backlog::new(sender);
        let world = Arc::new(World::default());
        ["a", "b", "c"].into_iter().for_each(|name| backlog.keep(text(name)));
        backlog.show(world.clone(), 3);
        backlog.keep(text("d"));
        backlog.show(world, 4);
        assert_eq!(names(items.try_iter()), ["a", "b"]);
        let (_, waiting, left_out) = backlog.into_parts();
        assert_eq!(names(waiting), ["c", "d", "map 4"]);
        assert_eq!(left_out, 1, "the older state of the map");
    }

    #[test]
    fn what_is_large_is_left_out_while_the_writer_is_behind() {
        let (sender, items) = bounded(1);
        let mut backlog = Backlog::new(sender);
        let large = || Item::Record(Box::new(text("large")));
        backlog.keep(text("a"));
        backlog.offer(large());
        backlog.keep(text("b"));
        assert_eq!(names(items.try_iter()), ["a"]);
        backlog.offer(large());
        assert_eq!(names(items.try_iter()), ["b"], "what waited comes first");
        backlog.offer(large());
        assert_eq!(names(items.try_iter()), ["large"]);
        assert_eq!(backlog.into_parts().2, 2);
    }

    #[test]
    fn without_a_writer_nothing_piles_up() {
        let (sender, items) = bounded(1);
        drop(items);
        let mut backlog = Backlog::new(sender);
        (0..9).for_each(|_| backlog.keep(text("a")));
        assert!(backlog.into_parts().1.is_empty());
    }
}
