//! What the map keeps of a closed loop, so that it can be taken back: who was on which side, and where everything was.

use std::collections::BTreeSet;
use std::sync::Arc;

use geometry::SE3;

use crate::ids::Id;
use crate::{KeyframeId, Map};

/// Loops that can be taken back: the newest ones. A keyframe has at most 7 kB in all of them together, a quarter of what its own
/// features take.
const MAX_LOOPS: usize = 64;

/// A loop that was closed within a sub-map, with 112 bytes for each of its keyframes.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedLoop {
    /// The keyframe of the earlier visit.
    pub matched: KeyframeId,
    /// The keyframe that saw its place again.
    pub keyframe: KeyframeId,
    /// Revision of the map that the loop led to.
    pub(crate) revision: u64,
    /// The first keyframe that was inserted into the closed map.
    pub(crate) next: KeyframeId,
    /// The new visit as it was: keyframes that shared points with `keyframe` and not with `matched`, by id.
    pub(crate) visit: Vec<KeyframeId>,
    /// Others that shared points with the visit by themselves, those around `matched` only if it was with `keyframe`, by id.
    pub(crate) near: Vec<KeyframeId>,
    /// `cam_from_world` and scale of every keyframe of the sub-map before the loop, by id.
    pub(crate) before: Vec<(KeyframeId, SE3, f64)>,
}

/// Where a keyframe stands to a closed loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Before the place was seen again.
    Earlier,
    /// The new visit and what came after, up to the next loop.
    Visit,
    /// Neither: it shared points with the visit all along, or came after the next loop.
    Neutral,
}

/// A closed loop and where its influence ends.
#[derive(Clone, Debug)]
pub(crate) struct Sides {
    pub(crate) closed: Arc<ClosedLoop>,
    /// The first keyframe after the next loop that stands, and the revision that it led to.
    pub(crate) until: (KeyframeId, u64),
}

impl Sides {
    pub(crate) fn of(&self, keyframe: KeyframeId) -> Side {
        let ClosedLoop { keyframe: first, visit, near, .. } = &*self.closed;
        let has = |list: &[KeyframeId]| list.binary_search(&keyframe).is_ok();
        if keyframe >= self.until.0 || has(near) {
            Side::Neutral
        } else if keyframe >= *first || has(visit) {
            Side::Visit
        } else {
            Side::Earlier
        }
    }

    /// Whether the loop closed over the keyframe, or it came later; not if it had been removed before.
    pub(crate) fn knows(&self, keyframe: KeyframeId) -> bool {
        keyframe >= self.closed.next || self.closed.before_of(keyframe).is_some()
    }
}

impl ClosedLoop {
    /// Pose and scale of a keyframe before the loop was closed.
    pub(crate) fn before_of(&self, keyframe: KeyframeId) -> Option<(SE3, f64)> {
        let at = self.before.binary_search_by_key(&keyframe, |b| b.0).ok()?;
        Some((self.before[at].1, self.before[at].2))
    }

    /// Whether both keyframes were in the map when the loop was closed.
    pub fn closed_over(&self, a: KeyframeId, b: KeyframeId) -> bool {
        a.max(b) < self.next
    }
}

impl Map {
    /// The loops that stand and can be taken back, at most 64, in the order in which they were closed. When there are more, the oldest
    /// one stands for good: all of the later ones agreed with it. Those closed in a sub-map that has
    /// been joined to another one since stand for good, and so does the one that joined them.
    pub fn loops(&self) -> &[Arc<ClosedLoop>] {
        &self.loops
    }

    /// Keeps what is needed to take back loops that are about to be closed.
    pub(crate) fn note_loops(&mut self, pairs: &[(KeyframeId, KeyframeId)]) {
        for &(matched, keyframe) in pairs {
            if let (Some((matched, _)), Some((keyframe, _))) =
                (self.resolve_keyframe(matched), self.resolve_keyframe(keyframe))
                && matched != keyframe
                && self.submap_of(matched) == self.submap_of(keyframe)
            {
                let note = Arc::new(self.note_loop(matched, keyframe));
                self.loops.push(note);
            }
        }
        let too_old = self.loops.len().saturating_sub(MAX_LOOPS);
        self.loops.drain(..too_old);
    }

    fn note_loop(&self, matched: KeyframeId, keyframe: KeyframeId) -> ClosedLoop {
        let covisible = |id: KeyframeId| self.keyframes.live(id).covisible().iter().map(|&(other, _)| other);
        let later = (keyframe.index()..self.keyframes.len()).map(KeyframeId::from_index);
        let mut visit: BTreeSet<KeyframeId> = later.filter(|&id| self.keyframe(id).is_some()).collect();
        visit.extend(covisible(keyframe));
        let around: BTreeSet<KeyframeId> = covisible(matched).chain([matched]).collect();
        let both: Vec<KeyframeId> = visit.intersection(&around).copied().collect();
        visit.retain(|id| !around.contains(id));
        let near = visit.iter().flat_map(|&id| covisible(id)).filter(|id| !around.contains(id));
        let near: BTreeSet<KeyframeId> = near.chain(both).collect();
        let members = self.submap_members(keyframe).into_iter().map(|id| self.keyframes.live(id));
        ClosedLoop {
            matched,
            keyframe,
            revision: self.revision + 1,
            next: self.next_keyframe_id(),
            near: near.difference(&visit).copied().collect(),
            visit: visit.into_iter().collect(),
            before: members.map(|k| (k.id, k.cam_from_world, k.scale)).collect(),
        }
    }
}
