//! The place index: which keyframes look like this image?

mod segment;

use crate::vector::BowVector;
use segment::{Place, Segment};
use std::sync::Arc;

/// Places that are kept as they come before a segment is made of them.
const SEAL_AT: usize = 32;
/// Tier of the largest segments: each tier holds twice as many places as the one below, tier 0 the number above.
const TOP_TIER: u32 = 6;

/// An inverted file over the bag-of-words vectors of keyframes, in immutable segments.
///
/// A clone is a snapshot and costs a few dozen reference counts. Segments grow by merging, two of a size into one of the
/// next up to 2048 places, so a query visits few of them: what it costs is the memory that its word lists lie apart.
#[derive(Clone, Debug, Default)]
pub struct PlaceIndex {
    slots: Vec<Slot>,
    /// The newest places, not yet in a segment.
    recent: Vec<Place>,
}

/// A keyframe that shares words with the query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceMatch {
    /// The keyframe.
    pub keyframe: u32,
    /// Number of shared words.
    pub shared_words: u32,
    /// L1 score, 0 to 1, equal to [`BowVector::score`] bit for bit.
    pub score: f64,
}

/// The keyframe is in the index already.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("keyframe {0} is in the place index already")]
pub struct DuplicateKeyframe(pub u32);

/// A segment and which of its places are still there.
#[derive(Clone, Debug)]
struct Slot {
    tier: u32,
    segment: Arc<Segment>,
    alive: Arc<Vec<bool>>,
    n_alive: usize,
}

impl PlaceIndex {
    /// Number of keyframes.
    pub fn len(&self) -> usize {
        self.recent.len() + self.slots.iter().map(|slot| slot.n_alive).sum::<usize>()
    }

    /// Whether there is no keyframe.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The vector of a keyframe.
    pub fn vector(&self, keyframe: u32) -> Option<&Arc<BowVector>> {
        let recent = self.recent.iter().find(|place| place.keyframe == keyframe);
        let sealed = || self.slots.iter().find_map(|slot| Some(&slot.segment.places()[slot.find(keyframe)?]));
        recent.or_else(sealed).map(|place| &place.vector)
    }

    /// Adds a keyframe.
    ///
    /// # Errors
    /// [`DuplicateKeyframe`] when it is there already; nothing changes.
    pub fn add(&mut self, keyframe: u32, vector: Arc<BowVector>) -> Result<(), DuplicateKeyframe> {
        if self.vector(keyframe).is_some() {
            return Err(DuplicateKeyframe(keyframe));
        }
        self.recent.push(Place { keyframe, vector });
        if self.recent.len() == SEAL_AT {
            self.slots.push(Slot::new(0, std::mem::take(&mut self.recent)));
            self.merge();
        }
        Ok(())
    }

    /// Removes a keyframe; whether it was there.
    pub fn remove(&mut self, keyframe: u32) -> bool {
        if let Some(i) = self.recent.iter().position(|place| place.keyframe == keyframe) {
            self.recent.remove(i);
            return true;
        }
        let found = self.slots.iter().enumerate().find_map(|(i, slot)| Some((i, slot.find(keyframe)?)));
        let Some((i, place)) = found else { return false };
        let slot = &mut self.slots[i];
        Arc::make_mut(&mut slot.alive)[place] = false;
        slot.n_alive -= 1;
        // Half of it gone: the segment is made anew, so that memory follows the number of keyframes.
        if slot.n_alive == 0 {
            self.slots.remove(i);
        } else if 2 * slot.n_alive <= slot.alive.len() {
            *slot = Slot::new(slot.tier, slot.living().collect());
        }
        true
    }

    /// All keyframes that share a word with `query` and are not excluded: best score first, of equals the lower id.
    pub fn query(&self, query: &BowVector, exclude: impl Fn(u32) -> bool) -> Vec<PlaceMatch> {
        let mut matches = Vec::new();
        for slot in &self.slots {
            slot.segment.query(query, |i| slot.alive[i], &mut matches);
        }
        matches.extend(self.recent.iter().filter_map(|place| place.compare(query)));
        matches.retain(|found| !exclude(found.keyframe));
        matches.sort_unstable_by(|a, b| b.score.total_cmp(&a.score).then(a.keyframe.cmp(&b.keyframe)));
        matches
    }

    /// Merges the newest segment with the one before it as long as they are of one tier. Tiers never rise along the slots.
    fn merge(&mut self) {
        while let [.., before, newest] = self.slots.as_slice() {
            if before.tier != newest.tier || newest.tier == TOP_TIER {
                break;
            }
            let merged = Slot::new(newest.tier + 1, before.living().chain(newest.living()).collect());
            self.slots.truncate(self.slots.len() - 2);
            self.slots.push(merged);
        }
    }
}

impl Slot {
    fn new(tier: u32, places: Vec<Place>) -> Self {
        let n_alive = places.len();
        let alive = Arc::new(vec![true; n_alive]);
        Self { tier, segment: Arc::new(Segment::new(places)), alive, n_alive }
    }

    /// Position of a keyframe in the segment, if it still exists.
    fn find(&self, keyframe: u32) -> Option<usize> {
        self.segment.find(keyframe).filter(|&i| self.alive[i])
    }

    fn living(&self) -> impl Iterator<Item = Place> + '_ {
        let with_state = self.segment.places().iter().zip(self.alive.iter());
        with_state.filter(|&(_, &alive)| alive).map(|(place, _)| place.clone())
    }
}
