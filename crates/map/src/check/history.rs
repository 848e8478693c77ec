//! Revisions of insertion and the notes on probation, which later mutations go by.

use super::Violation;
use crate::ids::Id;
use crate::{KeyframeId, Map, PROBATION_KEYFRAMES};

impl Map {
    pub(super) fn check_history(&self, found: &mut Vec<Violation>) {
        let mut earliest = 1;
        for (keyframe, k) in self.keyframes.iter() {
            let inserted_at = k.inserted_at;
            if inserted_at < earliest || inserted_at > self.revision {
                found.push(Violation::InsertedAt { keyframe, inserted_at, revision: self.revision });
            }
            earliest = inserted_at.saturating_add(1);
        }
        self.check_probation(found);
    }

    /// For each of the newest keyframes: points from the noted one on are made by it or later, the others before.
    fn check_probation(&self, found: &mut Vec<Violation>) {
        let n_keyframes = self.keyframes.len();
        let n_newest = n_keyframes.min(PROBATION_KEYFRAMES);
        let mut at_least = None;
        for i in 0..n_newest.max(self.first_young.len()) {
            let keyframe = KeyframeId::from_index(n_keyframes - n_newest + i);
            let first = self.first_young.get(i).copied();
            let fits = first.is_some_and(|first| {
                let mut points = self.points.iter();
                let is_apart = points.all(|(id, p)| (id >= first) == (p.created_by >= keyframe));
                i < n_newest && Some(first) >= at_least && first <= self.next_point_id() && is_apart
            });
            if !fits {
                found.push(Violation::Probation { keyframe, first });
            }
            at_least = first;
        }
    }
}
