//! Consistency in time: a place must look alike from several keyframes in a row (ORB-SLAM, Mur-Artal et al. 2015,
//! section VII-A).

use std::cmp::Reverse;
use std::collections::BTreeSet;

use map::{KeyframeId, Map};

/// A candidate that was seen for long enough.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Row {
    pub(super) candidate: KeyframeId,
    /// Keyframes in a row before this one from which it looked alike.
    pub(super) length: usize,
    /// The keyframe that the row began with, and what looked alike from there.
    pub(super) began: (KeyframeId, KeyframeId),
}

/// Groups of candidates and for how many keyframes in a row each was seen.
#[derive(Clone, Debug, Default)]
pub(super) struct Consistency {
    groups: Vec<(BTreeSet<KeyframeId>, Row)>,
}

impl Consistency {
    /// Takes the candidates of the next keyframe; returns those that were seen `needed` times before in a row, and the
    /// longest such row of any candidate.
    pub(super) fn advance(
        &mut self,
        keyframe: KeyframeId,
        map: &Map,
        candidates: &[KeyframeId],
        needed: usize,
    ) -> (Vec<Row>, usize) {
        let mut now = Vec::with_capacity(candidates.len());
        for &candidate in candidates {
            let Some(there) = map.keyframe(candidate) else { continue };
            let group: BTreeSet<KeyframeId> =
                there.covisible().iter().map(|&(id, _)| id).chain(std::iter::once(candidate)).collect();
            let before = self.groups.iter().filter(|(earlier, _)| !earlier.is_disjoint(&group));
            // Of equals the one that began first.
            let longest = before.map(|g| g.1).max_by_key(|row| (row.length, Reverse(row.began)));
            let row = match longest {
                Some(Row { length, began, .. }) => Row { candidate, length: length + 1, began },
                None => Row { candidate, length: 0, began: (keyframe, candidate) },
            };
            now.push((group, row));
        }
        self.groups = now;
        let rows = || self.groups.iter().map(|g| g.1);
        (rows().filter(|row| row.length >= needed).collect(), rows().map(|row| row.length).max().unwrap_or(0))
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.groups.clear();
    }
}

#[cfg(test)]
#[path = "../../tests/steps/consistency.rs"]
mod tests;
