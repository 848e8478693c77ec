//! Covisibility, spanning trees and loop edges, recounted.

use super::Violation;
use crate::ids::Id;
use crate::validate::{is_scale, pose_defect};
use crate::{KeyframeId, Map};

impl Map {
    /// Recounts the shared points of every pair; a symmetric count makes symmetric weights.
    pub(super) fn check_covisibility(&self, found: &mut Vec<Violation>) {
        for (keyframe, k) in self.keyframes.iter() {
            let counts = self.count_shared(k);
            for &(missing, _) in k.covisible().iter().filter(|(c, _)| self.keyframe(*c).is_none()) {
                found.push(Violation::MissingKeyframe { keyframe, missing });
            }
            let order = |&(c, weight): &(KeyframeId, u32)| (std::cmp::Reverse(weight), c);
            for pair in k.covisible().windows(2).filter(|w| order(&w[0]) >= order(&w[1])) {
                found.push(Violation::CovisibilityEntry { keyframe, other: pair[1].0 });
            }
            let mut stored = vec![0_u32; counts.len()];
            for &(other, weight) in k.covisible() {
                if let Some(s) = stored.get_mut(other.index()) {
                    if weight == 0 || *s > 0 {
                        found.push(Violation::CovisibilityEntry { keyframe, other });
                    }
                    *s = s.saturating_add(weight);
                }
            }
            for i in (0..counts.len()).filter(|&i| stored[i] != counts[i]) {
                let other = KeyframeId::from_index(i);
                found.push(Violation::Covisibility {
                    keyframe,
                    other,
                    stored: stored[i],
                    counted: counts[i],
                });
            }
        }
    }

    pub(super) fn check_tree(&self, found: &mut Vec<Violation>) {
        let parentless: Vec<KeyframeId> =
            self.keyframes.iter().filter(|(_, k)| k.parent().is_none()).map(|(id, _)| id).collect();
        if parentless != self.roots() {
            found.push(Violation::Roots { roots: self.roots().to_vec(), parentless });
        }
        for (id, keyframe) in self.keyframes.iter() {
            if let Some(parent) = keyframe.parent() {
                match self.keyframe(parent) {
                    None => found.push(Violation::MissingKeyframe { keyframe: id, missing: parent }),
                    Some(p) if !p.children().contains(&id) => {
                        let parent = Some(parent);
                        let other = p.id;
                        found.push(Violation::ParentChild { child: id, parent, other, listed: false });
                    }
                    Some(_) => {}
                }
            }
            for &child in keyframe.children() {
                match self.keyframe(child).map(|c| c.parent()) {
                    None => found.push(Violation::MissingKeyframe { keyframe: id, missing: child }),
                    Some(parent) if parent != Some(id) => {
                        found.push(Violation::ParentChild { child, parent, other: id, listed: true });
                    }
                    Some(_) => {}
                }
            }
            check_order(id, keyframe.children(), found);
            if !self.reaches_top(id) {
                found.push(Violation::Cycle { keyframe: id });
            }
        }
    }

    /// Going from parent to parent ends.
    fn reaches_top(&self, keyframe: KeyframeId) -> bool {
        let mut at = keyframe;
        for _ in 0..self.keyframes.len() {
            match self.keyframe(at).and_then(|k| k.parent()) {
                Some(parent) => at = parent,
                None => return true,
            }
        }
        false
    }

    pub(super) fn check_loop_edges(&self, found: &mut Vec<Violation>) {
        for (from, keyframe) in self.keyframes.iter() {
            for &to in keyframe.loop_edges() {
                match self.keyframe(to) {
                    None => found.push(Violation::MissingKeyframe { keyframe: from, missing: to }),
                    Some(other) if to == from || !other.loop_edges().contains(&from) => {
                        found.push(Violation::LoopEdge { from, to });
                    }
                    Some(_) => {}
                }
            }
            check_order(from, keyframe.loop_edges(), found);
        }
    }

    /// What is kept of closed loops names ids that were given out, in order, with sound numbers.
    pub(super) fn check_closed_loops(&self, found: &mut Vec<Violation>) {
        let mut revision = 0;
        for closed in &self.loops {
            let before: Vec<KeyframeId> = closed.before.iter().map(|b| b.0).collect();
            let is_sorted = |list: &[KeyframeId]| {
                list.is_sorted_by(|a, b| a < b) && list.last().is_none_or(|&id| id < closed.next)
            };
            let (matched, keyframe) = (closed.matched, closed.keyframe);
            let fits = [&before, &closed.visit, &closed.near].into_iter().all(|list| is_sorted(list))
                && [matched, keyframe].iter().all(|end| before.binary_search(end).is_ok())
                && closed.before.iter().all(|b| pose_defect(&b.1).is_none() && is_scale(b.2))
                && closed.next <= self.next_keyframe_id()
                && (revision..=self.revision).contains(&closed.revision);
            revision = closed.revision;
            if !fits || matched == keyframe {
                found.push(Violation::ClosedLoop { matched, keyframe });
            }
        }
    }
}

fn check_order(keyframe: KeyframeId, list: &[KeyframeId], found: &mut Vec<Violation>) {
    for pair in list.windows(2).filter(|w| w[0] >= w[1]) {
        found.push(Violation::ListOrder { keyframe, entry: pair[1] });
    }
}
