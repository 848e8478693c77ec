//! `link`, `unlink`, `merge_points`, `remove_point`, `count`, and the primitives that all mutations share.

use crate::covisibility::CovisibilityChange;
use crate::{FIRST_BELIEF, KeyframeId, Map, MapError, Observation, PointCount, PointId};

/// Outcome for a point that lost an observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointFate {
    /// It is still in the map.
    Kept,
    /// It had too few observations left and was removed.
    Removed,
}

impl Map {
    /// Adds an observation to a point.
    ///
    /// # Errors
    /// The point, keyframe or feature does not exist, the feature shows a point, or the keyframe observes the point.
    pub fn link(&mut self, point: PointId, observation: Observation) -> Result<(), MapError> {
        let keyframe = observation.keyframe;
        if let Some(feature) = self.need_point(point)?.feature_in(keyframe) {
            return Err(MapError::AlreadyObserved { point, keyframe, feature });
        }
        self.need_free_feature(observation)?;

        let mut change = CovisibilityChange::default();
        self.attach(point, observation, &mut change);
        self.apply_covisibility(change);
        self.refresh_point(point);
        self.revision += 1;
        Ok(())
    }

    /// Takes an observation from a point. A point left with none, or with one and not young, is removed.
    ///
    /// # Errors
    /// The point or keyframe does not exist, or the keyframe does not observe the point.
    pub fn unlink(&mut self, point: PointId, keyframe: KeyframeId) -> Result<PointFate, MapError> {
        self.need_keyframe(keyframe)?;
        if self.need_point(point)?.feature_in(keyframe).is_none() {
            return Err(MapError::NotObserved { point, keyframe });
        }

        let mut change = CovisibilityChange::default();
        self.detach(point, keyframe, &mut change);
        let fate = self.settle(point, &mut change);
        self.apply_covisibility(change);
        self.revision += 1;
        Ok(fate)
    }

    /// Makes two points one: `keep` takes over the observations of `drop` in keyframes that do not observe it yet, the
    /// others end. Position, reference and age stay those of `keep`, statistics and beliefs are added up, and
    /// [`resolve`](Map::resolve) leads from `drop` to `keep`.
    ///
    /// # Errors
    /// A point does not exist, or they are the same.
    pub fn merge_points(&mut self, keep: PointId, drop: PointId) -> Result<(), MapError> {
        if keep == drop {
            return Err(MapError::MergeWithItself { point: keep });
        }
        self.need_point(keep)?;
        self.need_point(drop)?;

        let mut change = CovisibilityChange::default();
        self.merge_into(keep, drop, &mut change);
        self.apply_covisibility(change);
        self.refresh_point(keep);
        self.revision += 1;
        Ok(())
    }

    /// Removes a point and its observations.
    ///
    /// # Errors
    /// The point does not exist.
    pub fn remove_point(&mut self, point: PointId) -> Result<(), MapError> {
        self.need_point(point)?;
        let mut change = CovisibilityChange::default();
        self.discard(point, None, &mut change);
        self.apply_covisibility(change);
        self.revision += 1;
        Ok(())
    }

    /// Adds to the statistics of points. A merged point passes its numbers on, a removed one is passed over, so that
    /// numbers gathered on an older snapshot can be added.
    ///
    /// # Errors
    /// A point never existed.
    pub fn count(&mut self, counts: &[PointCount]) -> Result<(), MapError> {
        for c in counts {
            self.need_known_point(c.point)?;
        }
        for c in counts {
            if let Some(id) = self.resolve(c.point) {
                let point = self.points.live_mut(id);
                point.seen = point.seen.saturating_add(c.seen);
                point.found = point.found.saturating_add(c.found);
                point.believe(c.evidence);
            }
        }
        self.revision += 1;
        Ok(())
    }

    /// Writes a valid observation on both sides.
    pub(crate) fn attach(&mut self, id: PointId, observation: Observation, change: &mut CovisibilityChange) {
        let point = self.points.live_mut(id);
        change.add(observation.keyframe, &point.observations, 1);
        let at = point.observations.partition_point(|o| o.keyframe < observation.keyframe);
        point.observations.insert(at, observation);
        self.keyframes.live_mut(observation.keyframe).set_point(observation.feature, Some(id));
    }

    /// Erases an existing observation on both sides; the first remaining observer becomes the reference if need be.
    pub(crate) fn detach(&mut self, id: PointId, keyframe: KeyframeId, change: &mut CovisibilityChange) {
        let point = self.points.live_mut(id);
        let at = point.observations.partition_point(|o| o.keyframe < keyframe);
        let observation = point.observations.remove(at);
        change.add(keyframe, &point.observations, -1);
        if point.reference == keyframe {
            point.reference = point.observations.first().map_or(keyframe, |o| o.keyframe);
        }
        self.keyframes.live_mut(keyframe).set_point(observation.feature, None);
    }

    /// Removes a point that has too few observations left, renews it otherwise.
    pub(crate) fn settle(&mut self, id: PointId, change: &mut CovisibilityChange) -> PointFate {
        if self.has_enough_observations(id) {
            self.refresh_point(id);
            PointFate::Kept
        } else {
            self.discard(id, None, change);
            PointFate::Removed
        }
    }

    /// Two observations, or one and young.
    pub(crate) fn has_enough_observations(&self, id: PointId) -> bool {
        let point = self.points.live(id);
        match point.observations.len() {
            0 => false,
            1 => self.is_young(point),
            _ => true,
        }
    }

    /// Takes a point out with all its observations.
    pub(crate) fn discard(
        &mut self,
        id: PointId,
        merged_into: Option<PointId>,
        change: &mut CovisibilityChange,
    ) {
        let observations = &self.points.live(id).observations;
        for (i, o) in observations.iter().enumerate() {
            change.add(o.keyframe, &observations[i + 1..], -1);
            self.keyframes.live_mut(o.keyframe).set_point(o.feature, None);
        }
        self.points.remove(id, merged_into);
    }

    /// Moves what can be moved from one living point to another and forwards the first; does not refresh.
    pub(crate) fn merge_into(&mut self, keep: PointId, drop: PointId, change: &mut CovisibilityChange) {
        let dropped = self.points.live(drop).clone();
        self.discard(drop, Some(keep), change);
        for o in dropped.observations {
            if self.points.live(keep).feature_in(o.keyframe).is_none() {
                self.attach(keep, o, change);
            }
        }
        let point = self.points.live_mut(keep);
        point.seen = point.seen.saturating_add(dropped.seen);
        point.found = point.found.saturating_add(dropped.found);
        point.believe(dropped.belief - FIRST_BELIEF);
    }
}
