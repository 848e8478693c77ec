//! A closed loop is taken back: the drive becomes what it was without it, with all that was mapped since attached.

use std::sync::Arc;

use geometry::SE3;

use crate::closed_loop::{ClosedLoop, Side, Sides};
use crate::covisibility::CovisibilityChange;
use crate::ids::Id;
use crate::keyframe::{insert_sorted, remove_sorted};
use crate::{
    Correction, KeyframeCorrection, KeyframeId, Map, MapError, NewPoint, Observation, PointId, RelativePose,
};

/// What became of a loop that was taken back, for poses that were noted while it stood.
#[derive(Clone, Debug)]
pub(crate) struct TakenBack {
    sides: Sides,
    /// The revision at which it was taken back.
    at: u64,
    /// `cam_from_world` and scale of every keyframe ever while the loop stood, by id.
    closed: Vec<(SE3, f64)>,
    /// Revision of insertion and id of the new visit's keyframes.
    visit: Vec<(u64, KeyframeId)>,
}

impl TakenBack {
    /// A pose that was noted on the new visit relative to a keyframe of the earlier one, relative to the newest keyframe of
    /// the new visit at that time instead; `None`: it stays as it is.
    pub(crate) fn moved(&self, pose: &RelativePose) -> Option<RelativePose> {
        let is_within = pose.revision >= self.sides.closed.revision
            && pose.revision < self.at.min(self.sides.until.1)
            && self.sides.of(pose.keyframe) == Side::Earlier;
        let newest = self.visit.partition_point(|v| v.0 <= pose.revision).saturating_sub(1);
        let &(_, keyframe) = self.visit.get(newest).filter(|_| is_within)?;
        let (kf_from_world, scale) = self.closed[pose.keyframe.index()];
        let (anchor_from_world, anchor_scale) = self.closed[keyframe.index()];
        let mut cam_from_keyframe = pose.cam_from_keyframe;
        cam_from_keyframe.translation *= scale / pose.scale;
        let cam_from_keyframe = cam_from_keyframe * kf_from_world * anchor_from_world.inverse();
        Some(RelativePose { keyframe, cam_from_keyframe, scale: anchor_scale, revision: pose.revision })
    }
}

impl Map {
    /// The pose `cam_from_world` that a keyframe would have if a loop was taken back and nothing was adjusted after it; `None` if
    /// the keyframe is gone.
    pub fn pose_without(&self, closed: &ClosedLoop, keyframe: KeyframeId) -> Option<SE3> {
        let now = self.keyframe(keyframe)?;
        let mut carrier = now;
        loop {
            if let Some((before, scale)) = closed.before_of(carrier.id) {
                let mut from_carrier = now.cam_from_world * carrier.cam_from_world.inverse();
                from_carrier.translation *= scale / carrier.scale;
                return Some(from_carrier * before);
            }
            // What came later follows its parent.
            let parent = carrier.parent().filter(|_| carrier.inserted_at > closed.revision);
            let Some(parent) = parent else { return Some(now.cam_from_world) };
            carrier = self.keyframes.live(parent);
        }
    }

    /// Takes back loops: points that both sides came to share are split, the spanning tree joins each side to itself,
    /// keyframes that were there before the first of the loops return to where they were, later ones follow their parents.
    pub(crate) fn take_back(&mut self, pairs: &[(KeyframeId, KeyframeId)]) -> Result<(), MapError> {
        let listed = self.find_loops(pairs)?;
        let Some(first) = listed.first().map(|&at| self.loops[at].clone()) else { return Ok(()) };
        for &at in &listed {
            let closed = self.loops[at].clone();
            let next = (at + 1..self.loops.len()).find(|i| !listed.contains(i)).map(|i| &self.loops[i]);
            let until = next.map_or((KeyframeId(u32::MAX), u64::MAX), |next| (next.next, next.revision));
            let sides = Sides { closed, until };
            let poses = (0..self.keyframes.len()).map(|i| self.pose_and_scale(KeyframeId::from_index(i)));
            let closed = poses.collect();
            self.split_points(&sides);
            self.part_trees(&sides);
            self.cut_loop_edge(&sides.closed);
            let visit = self.keyframes().filter(|k| sides.of(k.id) == Side::Visit);
            let visit = visit.map(|k| (k.inserted_at, k.id)).collect();
            self.taken_back.push(Arc::new(TakenBack { sides, at: self.revision + 1, closed, visit }));
        }
        let motion = self.motion_of(&self.undoing(&first))?;
        self.write_motion(&motion);
        for &at in listed.iter().rev() {
            self.loops.remove(at);
        }
        // What later loops would go back to must not have this one in it either.
        for at in listed[0]..self.loops.len() {
            let mut note = (*self.loops[at]).clone();
            for (id, cam_from_world, scale) in &mut note.before {
                (*cam_from_world, *scale) = self.pose_and_scale(*id);
            }
            self.loops[at] = Arc::new(note);
        }
        Ok(())
    }

    /// Positions in the list of loops, in order.
    pub(crate) fn find_loops(&self, pairs: &[(KeyframeId, KeyframeId)]) -> Result<Vec<usize>, MapError> {
        let find = |&(matched, keyframe): &(KeyframeId, KeyframeId)| {
            let at = self.loops.iter().position(|l| (l.matched, l.keyframe) == (matched, keyframe));
            at.ok_or(MapError::NoLoop { matched, keyframe })
        };
        let mut found = pairs.iter().map(find).collect::<Result<Vec<_>, _>>()?;
        found.sort_unstable();
        found.dedup();
        Ok(found)
    }

    /// Every keyframe that is left of those that a loop moved goes back to where it was.
    fn undoing(&self, first: &ClosedLoop) -> Correction {
        let back = |&(keyframe, cam_from_world, scale): &(KeyframeId, SE3, f64)| {
            let now = self.keyframe(keyframe)?;
            Some(KeyframeCorrection { keyframe, cam_from_world, scale: scale / now.scale })
        };
        let keyframes = first.before.iter().filter_map(back).collect();
        Correction { keyframes, seen_revision: first.revision, ..Correction::default() }
    }

    /// Where a keyframe is, living or removed, and its scale.
    fn pose_and_scale(&self, keyframe: KeyframeId) -> (SE3, f64) {
        let carried = self.resolve_keyframe(keyframe);
        let pose = carried.map_or(SE3::identity(), |(alive, kf_from_alive)| {
            kf_from_alive * self.keyframes.live(alive).cam_from_world
        });
        (pose, self.scale_of(keyframe))
    }

    /// Gives the earlier side points of its own where the loop made both sides share one. The new visit, where the camera
    /// is, keeps the old ids.
    fn split_points(&mut self, sides: &Sides) {
        let mut change = CovisibilityChange::default();
        for id in (0..self.points.len()).map(PointId::from_index) {
            let Some(point) = self.point(id) else { continue };
            let on = |side: Side| point.observations().iter().filter(move |o| sides.of(o.keyframe) == side);
            if on(Side::Visit).next().is_none() {
                continue;
            }
            let observations: Vec<Observation> = on(Side::Earlier).copied().collect();
            let position = point.position;
            if observations.is_empty() {
                continue;
            }
            for o in &observations {
                self.detach(id, o.keyframe, &mut change);
            }
            self.settle(id, &mut change);
            self.add_point(NewPoint { position, observations }, &mut change);
        }
        self.apply_covisibility(change);
    }

    /// Hangs every keyframe that hangs under the other side, living or removed, under the one before it on its own side.
    fn part_trees(&mut self, sides: &Sides) {
        for id in (0..self.keyframes.len()).map(KeyframeId::from_index).filter(|&id| sides.knows(id)) {
            let (other, carrier) = match (sides.of(id), self.keyframe(id)) {
                (Side::Neutral, _) => continue,
                (side, living) => {
                    let other = if side == Side::Visit { Side::Earlier } else { Side::Visit };
                    let carrier = match living {
                        Some(keyframe) => keyframe.parent(),
                        None => self.resolve_keyframe(id).map(|(alive, _)| alive),
                    };
                    (other, carrier)
                }
            };
            let crosses = carrier.is_some_and(|carrier| sides.of(carrier) == other);
            if crosses && let Some(anchor) = self.anchor(id, other, sides) {
                self.rehang(id, anchor);
            }
        }
    }

    /// The nearest older keyframe of the same sub-map that is not on the `other` side and does not hang under `id`; at worst
    /// the root.
    fn anchor(&self, id: KeyframeId, other: Side, sides: &Sides) -> Option<KeyframeId> {
        let root = self.submap_of(id)?;
        let hangs_under = |mut at: KeyframeId| loop {
            match self.keyframes.live(at).parent {
                _ if at == id => return true,
                Some(parent) => at = parent,
                None => return false,
            }
        };
        let older = (0..id.index()).rev().map(KeyframeId::from_index).filter(|&k| self.keyframe(k).is_some());
        let mut fit = older.filter(|&k| sides.of(k) != other && self.submap_of(k) == Some(root));
        fit.find(|&k| !hangs_under(k)).or(Some(root)).filter(|&k| k != id)
    }

    /// Gives a keyframe, living or removed, another parent; it stays where it is.
    fn rehang(&mut self, id: KeyframeId, parent: KeyframeId) {
        let (cam_from_world, _) = self.pose_and_scale(id);
        let parent_from_world = self.keyframes.live(parent).cam_from_world;
        if let Some(removed) = self.keyframes.forward_mut(id) {
            removed.parent = parent;
            removed.removed_from_parent = (cam_from_world * parent_from_world.inverse()).normalized();
            return;
        }
        if let Some(old) = self.keyframes.live_mut(id).parent.replace(parent) {
            remove_sorted(&mut self.keyframes.live_mut(old).children, id);
        }
        insert_sorted(&mut self.keyframes.live_mut(parent).children, id);
    }

    fn cut_loop_edge(&mut self, closed: &ClosedLoop) {
        for (id, other) in [(closed.matched, closed.keyframe), (closed.keyframe, closed.matched)] {
            if self.keyframe(id).is_some() {
                remove_sorted(&mut self.keyframes.live_mut(id).loop_edges, other);
            }
        }
    }
}
