//! Covisibility: how many points each pair of keyframes shares, kept exactly and incrementally.

use crate::ids::Id;
use crate::keyframe::Keyframe;
use crate::{KeyframeId, Map, Observation};

/// Changes of weights that a mutation collects and applies at its end, one write per pair.
#[derive(Default)]
pub(crate) struct CovisibilityChange {
    /// (smaller id, larger id, change)
    pairs: Vec<(KeyframeId, KeyframeId, i32)>,
}

impl CovisibilityChange {
    /// A point with these observers gains (`+1`) or loses (`-1`) an observation in `keyframe`.
    pub(crate) fn add(&mut self, keyframe: KeyframeId, others: &[Observation], change: i32) {
        let others = others.iter().map(|o| o.keyframe).filter(|&k| k != keyframe);
        self.pairs.extend(others.map(|k| (keyframe.min(k), keyframe.max(k), change)));
    }
}

impl Map {
    /// Counts the points that a keyframe shares with each other one, by keyframe id, from its table and the points'
    /// observations alone.
    pub(crate) fn count_shared(&self, keyframe: &Keyframe) -> Vec<u32> {
        let mut counts = vec![0_u32; self.keyframes.len()];
        let shown = keyframe.points().iter().flatten().filter_map(|&p| self.point(p));
        for o in shown.flat_map(|p| p.observations()).filter(|o| o.keyframe != keyframe.id) {
            if let Some(count) = counts.get_mut(o.keyframe.index()) {
                *count += 1;
            }
        }
        counts
    }

    pub(crate) fn apply_covisibility(&mut self, change: CovisibilityChange) {
        let mut pairs = change.pairs;
        pairs.sort_unstable_by_key(|&(a, b, _)| (a, b));
        for same in pairs.chunk_by(|p, q| (p.0, p.1) == (q.0, q.1)) {
            let (a, b, _) = same[0];
            let sum: i32 = same.iter().map(|p| p.2).sum();
            if sum != 0 {
                change_weight(self.keyframes.live_mut(a), b, sum);
                change_weight(self.keyframes.live_mut(b), a, sum);
            }
        }
    }
}

/// Changes one weight in place, keeping the order (weight descending, id ascending).
fn change_weight(keyframe: &mut Keyframe, other: KeyframeId, change: i32) {
    let list = &mut keyframe.covisible;
    let old = list.iter().position(|(k, _)| *k == other).map_or(0, |at| list.remove(at).1);
    let new = old.checked_add_signed(change).expect("map is broken: covisibility below zero");
    if new > 0 {
        let at = list.partition_point(|&(k, w)| w > new || (w == new && k < other));
        list.insert(at, (other, new));
    }
}
