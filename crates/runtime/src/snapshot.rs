//! Which state of the map tracking sees: exactly the one of the rule, or simply the newest.

use std::sync::Arc;

use crossbeam::channel::Receiver;
use slam::World;

use crate::failure::Halt;
use crate::rule::Rule;

/// A state of the world that mapping shows to tracking.
#[derive(Clone)]
pub(crate) struct Published {
    pub(crate) world: Arc<World>,
    /// Operations that the map went through until then.
    pub(crate) operation: usize,
    /// Keyframes that were asked for and inserted by then.
    pub(crate) inserted: usize,
    /// Those of them whose slow work was done.
    pub(crate) refined: usize,
}

/// States that may wait for tracking under the rule: the last keyframe's finished mapping and both states of the next
/// one. Tracking asks for no further keyframe before it has seen the insertion of the last.
pub(crate) const EXACT_STATES: usize = 4;

/// Tracking's end of the channel of published states.
pub(crate) struct Snapshots {
    /// The state that each frame sees; `None`: the newest.
    rule: Option<Rule>,
    states: Receiver<Published>,
    current: Published,
    /// Keyframes asked for.
    requests: usize,
    /// The frame that asked for the last of them.
    last_request: Option<usize>,
}

/// What tracking of a frame sees.
pub(crate) struct View {
    pub(crate) world: Arc<World>,
    pub(crate) operation: usize,
    /// Whether mapping waits for work.
    pub(crate) idle: bool,
}

impl Snapshots {
    pub(crate) fn new(rule: Option<Rule>, start: Arc<World>, states: Receiver<Published>) -> Self {
        let current = Published { world: start, operation: 0, inserted: 0, refined: 0 };
        Snapshots { rule, states, current, requests: 0, last_request: None }
    }

    /// Frame `n` asks for a keyframe.
    pub(crate) fn request(&mut self, n: usize) {
        self.requests += 1;
        self.last_request = Some(n);
    }

    /// The state that frame `n` sees.
    ///
    /// # Errors
    /// When mapping ended before it came to that state.
    pub(crate) fn at(&mut self, n: usize) -> Result<View, Halt> {
        let idle = match self.rule {
            Some(rule) => {
                let idle = self.last_request.is_none_or(|k| rule.sees_refined(n, k));
                let refined = if idle { self.requests } else { self.requests - 1 };
                while (self.current.inserted, self.current.refined) != (self.requests, refined) {
                    self.current = self.states.recv().map_err(|_| Halt::Gone)?;
                }
                idle
            }
            None => {
                self.catch_up();
                self.current.refined == self.requests
            }
        };
        Ok(View { world: self.current.world.clone(), operation: self.current.operation, idle })
    }

    /// The newest state that there is, whether or not a frame will see it.
    pub(crate) fn newest(&mut self) -> Arc<World> {
        self.catch_up();
        self.current.world.clone()
    }

    fn catch_up(&mut self) {
        while let Ok(newer) = self.states.try_recv() {
            self.current = newer;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crossbeam::channel::bounded;

    #[test]
    fn a_frame_sees_the_insertion_at_once_and_the_mapping_after_the_lag() {
        let (publish, states) = bounded(EXACT_STATES);
        let world = Arc::new(World::default());
        let rule = Rule { lag: 3, loop_lag: 10 };
        let mut snapshots = Snapshots::new(Some(rule), world.clone(), states);
        let see = |n: usize, snapshots: &mut Snapshots| {
            let view = snapshots.at(n).unwrap();
            (view.operation, view.idle)
        };
        assert_eq!(see(0, &mut snapshots), (0, true));
        snapshots.request(0);
        for (operation, refined) in [(2, 0), (3, 1)] {
            publish.send(Published { world: world.clone(), operation, inserted: 1, refined }).unwrap();
        }
        let seen: Vec<_> = (1..5).map(|n| see(n, &mut snapshots)).collect();
        assert_eq!(seen, [(2, false), (2, false), (3, true), (3, true)]);
        // Another keyframe before the mapping of the last was seen: that state is passed over.
        snapshots.request(4);
        for (operation, inserted, refined) in [(8, 2, 1), (9, 2, 2)] {
            publish.send(Published { world: world.clone(), operation, inserted, refined }).unwrap();
        }
        assert_eq!(see(5, &mut snapshots), (8, false));
        drop(publish);
        assert_eq!(see(7, &mut snapshots), (9, true));
        snapshots.request(7);
        assert!(snapshots.at(8).is_err(), "mapping is gone");
    }

    #[test]
    fn the_newest_state_is_taken_without_waiting() {
        let (publish, states) = bounded(4);
        let world = Arc::new(World::default());
        let mut snapshots = Snapshots::new(None, world.clone(), states);
        snapshots.request(0);
        assert!(!snapshots.at(1).unwrap().idle);
        for refined in [0, 1] {
            publish.send(Published { world: world.clone(), operation: 2, inserted: 1, refined }).unwrap();
        }
        assert!(snapshots.at(2).unwrap().idle);
    }
}
