//! The logical schedule: what tracking sees and when corrections are applied, by frame numbers alone.
//!
//! Frames are numbered by their position in the feed. `Sequential` and `Lockstep` both follow this rule, which is why they
//! give the same bits: it knows no clock and no thread.

/// The numbers of the rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rule {
    /// The mapping of a keyframe is seen by tracking from this many frames later on.
    pub(crate) lag: usize,
    /// A loop found at a keyframe is closed at the first insertion this many frames later.
    pub(crate) loop_lag: usize,
}

/// Fewest frames between a loop and the adoption of the global solution that it started.
const MIN_GLOBAL_LAG: usize = 20;

/// A point of the run at which corrections may be applied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Moment {
    /// Before the insertion of the keyframe that this frame became.
    Insertion(usize),
    /// After the last frame: everything is due.
    End,
}

impl Rule {
    /// Whether frame `n` sees the finished mapping of the keyframe that frame `k` became; otherwise it sees the map right
    /// after that keyframe's insertion.
    pub(crate) fn sees_refined(&self, n: usize, k: usize) -> bool {
        n >= k + self.lag
    }

    /// Whether what was found at the keyframe of frame `k` is due.
    pub(crate) fn loop_is_due(&self, k: usize, moment: Moment) -> bool {
        moment.is_reached(k + self.loop_lag)
    }

    /// The frame from which on a global solution is due that was started by a loop closed at `moment`, with this many
    /// keyframes in the map. The larger the map, the longer the solution may take.
    pub(crate) fn global_due(moment: Moment, n_keyframes: usize) -> usize {
        match moment {
            Moment::Insertion(n) => n + MIN_GLOBAL_LAG.max(n_keyframes / 2),
            Moment::End => 0,
        }
    }
}

impl Moment {
    /// Whether frame `n` is reached.
    pub(crate) fn is_reached(self, n: usize) -> bool {
        match self {
            Moment::Insertion(now) => now >= n,
            Moment::End => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_a_lag_of_one_everything_is_done_before_the_next_frame() {
        let rule = Rule { lag: 1, loop_lag: 10 };
        assert!(!rule.sees_refined(7, 7) && rule.sees_refined(8, 7));
        let rule = Rule { lag: 3, loop_lag: 10 };
        assert!(!rule.sees_refined(9, 7) && rule.sees_refined(10, 7));
    }

    #[test]
    fn corrections_wait_for_their_frame_or_the_end() {
        let rule = Rule { lag: 1, loop_lag: 10 };
        assert!(!rule.loop_is_due(5, Moment::Insertion(14)));
        assert!(rule.loop_is_due(5, Moment::Insertion(15)) && rule.loop_is_due(5, Moment::End));
        assert_eq!(Rule::global_due(Moment::Insertion(100), 30), 120);
        assert_eq!(Rule::global_due(Moment::Insertion(100), 300), 250);
        assert!(Moment::End.is_reached(usize::MAX));
    }
}
