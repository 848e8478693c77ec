//! What tracking knows of its points beyond the map that it sees: the evidence of the frames which that map has not heard of.

use std::collections::BTreeMap;

use map::{Map, PointCount, PointId};

/// Most frames that are remembered for a point; a map that only localizes never hears of them.
const MOST_FRAMES: usize = 32;

/// Evidence that the map does not have yet.
#[derive(Clone, Debug, Default)]
pub(super) struct Beliefs {
    /// For each point, in order: how often it should have been seen once the map knows of the frame (which tells whether it does),
    /// and the evidence of the frame.
    unheard: BTreeMap<PointId, Vec<(u32, i32)>>,
}

impl Beliefs {
    /// Adds a frame's counts, gathered on this map, and forgets what the map has heard of.
    pub(super) fn add(&mut self, map: &Map, counts: &[PointCount]) {
        self.unheard.retain(|&id, frames| {
            let heard = map.point(id).map_or(u32::MAX, |point| point.seen);
            frames.retain(|&(seen, _)| seen > heard);
            !frames.is_empty()
        });
        for count in counts {
            let Some(point) = map.point(count.point) else { continue };
            let frames = self.unheard.entry(count.point).or_default();
            let before = frames.last().map_or(point.seen, |&(seen, _)| seen);
            if frames.len() == MOST_FRAMES {
                frames.remove(0);
            }
            frames.push((before.saturating_add(count.seen), count.evidence));
        }
    }

    /// Probability that a point stands still, of all that is known so far; 1 for one that is not in the map.
    pub(super) fn trust(&self, map: &Map, id: PointId) -> f32 {
        let unheard = self.unheard.get(&id).map_or(&[][..], Vec::as_slice);
        map.point(id)
            .map_or(1.0, |point| point.trust_after(unheard.iter().map(|&(_, evidence)| evidence)) as f32)
    }
}

#[cfg(test)]
#[path = "../../tests/steps/beliefs.rs"]
mod tests;
