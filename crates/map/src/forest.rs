//! The forest of sub-maps: one spanning tree each, its root, and how two of them become one.

use crate::keyframe::{insert_sorted, remove_sorted};
use crate::{KeyframeId, Map};

impl Map {
    /// Root of every sub-map, in order of their ids.
    pub fn roots(&self) -> &[KeyframeId] {
        &self.roots
    }

    /// The sub-map of a keyframe, named by its root; a removed keyframe is where the one is that carries its pose
    /// ([`resolve_keyframe`](Map::resolve_keyframe)). `None` if the id was never given out.
    pub fn submap_of(&self, keyframe: KeyframeId) -> Option<KeyframeId> {
        let (mut at, _) = self.resolve_keyframe(keyframe)?;
        while let Some(parent) = self.keyframes.live(at).parent {
            at = parent;
        }
        Some(at)
    }

    /// The keyframes of a keyframe's sub-map, in order of their ids; none if the id was never given out.
    pub fn submap_members(&self, keyframe: KeyframeId) -> Vec<KeyframeId> {
        let mut members = Vec::new();
        let mut open: Vec<KeyframeId> = self.submap_of(keyframe).into_iter().collect();
        while let Some(id) = open.pop() {
            members.push(id);
            open.extend(self.keyframes.live(id).children());
        }
        members.sort_unstable();
        members
    }

    /// Gives a new keyframe its place; without a parent it is the root of a sub-map.
    pub(crate) fn hang(&mut self, id: KeyframeId, parent: Option<KeyframeId>) {
        self.keyframes.live_mut(id).parent = parent;
        match parent {
            Some(parent) => insert_sorted(&mut self.keyframes.live_mut(parent).children, id),
            None => insert_sorted(&mut self.roots, id),
        }
    }

    /// Makes a keyframe the root of its tree, parents reversed along the path to the old root, and hangs it under a
    /// keyframe of another tree.
    pub(crate) fn hang_tree(&mut self, keyframe: KeyframeId, under: KeyframeId) {
        let (mut at, mut new_parent) = (keyframe, under);
        loop {
            let old_parent = self.keyframes.live_mut(at).parent.replace(new_parent);
            insert_sorted(&mut self.keyframes.live_mut(new_parent).children, at);
            let Some(old_parent) = old_parent else { break };
            remove_sorted(&mut self.keyframes.live_mut(old_parent).children, at);
            (at, new_parent) = (old_parent, at);
        }
        remove_sorted(&mut self.roots, at);
    }
}
