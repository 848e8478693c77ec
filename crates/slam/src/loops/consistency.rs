//! Consistency in time: a place must look alike from several keyframes in a row (ORB-SLAM, Mur-Artal et al. 2015,
//! section VII-A).

use std::collections::BTreeSet;

use map::{KeyframeId, Map};

/// Groups of candidates and for how many keyframes in a row each was seen.
#[derive(Clone, Debug, Default)]
pub(super) struct Consistency {
    groups: Vec<(BTreeSet<KeyframeId>, usize)>,
}

impl Consistency {
    /// Takes the candidates of the next keyframe; returns those that were seen `needed` times before in a row, and the
    /// longest such row of any candidate.
    pub(super) fn advance(
        &mut self,
        map: &Map,
        candidates: &[KeyframeId],
        needed: usize,
    ) -> (Vec<KeyframeId>, usize) {
        let mut now = Vec::with_capacity(candidates.len());
        let mut accepted = Vec::new();
        let mut longest = 0;
        for &candidate in candidates {
            let Some(keyframe) = map.keyframe(candidate) else { continue };
            let group: BTreeSet<KeyframeId> =
                keyframe.covisible().iter().map(|&(id, _)| id).chain(std::iter::once(candidate)).collect();
            let before = self.groups.iter().filter(|(earlier, _)| !earlier.is_disjoint(&group));
            let row = before.map(|&(_, row)| row + 1).max().unwrap_or(0);
            longest = longest.max(row);
            if row >= needed {
                accepted.push(candidate);
            }
            now.push((group, row));
        }
        self.groups = now;
        (accepted, longest)
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.groups.clear();
    }
}

#[cfg(test)]
#[path = "../../tests/steps/consistency.rs"]
mod tests;
