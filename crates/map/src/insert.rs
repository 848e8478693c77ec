//! `insert`: a keyframe with its matches and new points, as one batch.

use std::sync::Arc;

use features::Frame;
use geometry::{SE3, Vec3};

use crate::covisibility::CovisibilityChange;
use crate::derived::{representative_descriptor, viewing_geometry};
use crate::ids::Id;
use crate::validate::{find_twice, is_sane, valid_pose};
use crate::{
    FIRST_BELIEF, Keyframe, KeyframeId, Map, MapError, MapPoint, Observation, PROBATION_KEYFRAMES, PointId,
};

/// What to insert at once: a keyframe, new points, or both.
#[derive(Clone, Default)]
pub struct Batch {
    /// The new keyframe, which will be [`Map::next_keyframe_id`].
    pub keyframe: Option<NewKeyframe>,
    /// The new points, which will have the ids from [`Map::next_point_id`] on, in this order.
    pub points: Vec<NewPoint>,
}

/// A keyframe to insert.
#[derive(Clone)]
pub struct NewKeyframe {
    /// Its features.
    pub frame: Arc<Frame>,
    /// Its pose, meters.
    pub cam_from_world: SE3,
    /// Features that show points of the map.
    pub matches: Vec<(u32, PointId)>,
    /// Its place in the forest of sub-maps.
    pub parent: Parent,
}

/// Where a new keyframe hangs in the forest of sub-maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Parent {
    /// Under the keyframe that shares most points, else under the newest; the first keyframe of a map is a root.
    #[default]
    Closest,
    /// Under this one.
    Under(KeyframeId),
    /// Nowhere: it is the root of a new sub-map and shares no point with older keyframes.
    NewSubmap,
}

/// A point to insert.
#[derive(Clone, Debug)]
pub struct NewPoint {
    /// Position in the world, meters.
    pub position: Vec3,
    /// At least one observation, in any order, in keyframes of the map or the batch.
    pub observations: Vec<Observation>,
}

/// What `insert` did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Inserted {
    /// The new keyframe.
    pub keyframe: Option<KeyframeId>,
    /// The new points, in the order of the batch.
    pub points: Vec<PointId>,
}

impl Map {
    /// Inserts a batch. A new point is created by the newest inserted keyframe, the one of the batch if there is one,
    /// which is its reference if it observes it; otherwise the first observer is.
    ///
    /// # Errors
    /// An id or feature does not exist, a feature would show two points, a point would be observed twice by a keyframe
    /// or not at all, a number is not finite or a rotation not a rotation, or the first keyframe of a sub-map shares points
    /// with older ones.
    pub fn insert(&mut self, batch: Batch) -> Result<Inserted, MapError> {
        self.validate_batch(&batch)?;
        let mut change = CovisibilityChange::default();
        let matched: Vec<PointId> =
            batch.keyframe.iter().flat_map(|new| new.matches.iter().map(|m| m.1)).collect();
        let fallback_parent = self.newest_keyframe();
        let wanted_parent = batch.keyframe.as_ref().map_or(Parent::default(), |new| new.parent);

        let keyframe = batch.keyframe.map(|new| self.add_keyframe(new, &mut change));
        let points = batch.points.into_iter().map(|new| self.add_point(new, &mut change)).collect();
        self.apply_covisibility(change);
        matched.iter().for_each(|&p| self.refresh_point(p));
        if let Some(id) = keyframe {
            let best = self.keyframes.live(id).covisible.first().map(|&(k, _)| k);
            let parent = match wanted_parent {
                Parent::Closest => best.or(fallback_parent),
                Parent::Under(parent) => Some(parent),
                Parent::NewSubmap => None,
            };
            self.hang(id, parent);
            self.end_probation();
        }
        self.revision += 1;
        Ok(Inserted { keyframe, points })
    }

    fn validate_batch(&self, batch: &Batch) -> Result<(), MapError> {
        let mut claims = Vec::new();
        if let Some(new) = &batch.keyframe {
            self.validate_keyframe(new)?;
            let keyframe = self.next_keyframe_id();
            if new.parent == Parent::NewSubmap && shares_points(keyframe, new, &batch.points) {
                return Err(MapError::SubmapMatched { keyframe });
            }
            claims.extend(new.matches.iter().map(|&(feature, _)| Observation { keyframe, feature }));
        }
        for (index, new) in batch.points.iter().enumerate() {
            self.validate_point(index, new, batch.keyframe.as_ref())?;
            claims.extend(&new.observations);
        }
        match find_twice(claims.into_iter()) {
            Some(Observation { keyframe, feature }) => Err(MapError::FeatureTwice { keyframe, feature }),
            None => Ok(()),
        }
    }

    fn validate_keyframe(&self, new: &NewKeyframe) -> Result<(), MapError> {
        let keyframe = self.next_keyframe_id();
        valid_pose(keyframe, &new.cam_from_world)?;
        if let Parent::Under(parent) = new.parent {
            self.need_keyframe(parent)?;
        }
        for &(feature, point) in &new.matches {
            need_feature(keyframe, &new.frame, feature)?;
            self.need_point(point)?;
        }
        match find_twice(new.matches.iter().map(|m| m.1)) {
            Some(point) => Err(MapError::PointTwice { point }),
            None => Ok(()),
        }
    }

    fn validate_point(
        &self,
        index: usize,
        new: &NewPoint,
        keyframe: Option<&NewKeyframe>,
    ) -> Result<(), MapError> {
        if !is_sane(&new.position) {
            return Err(MapError::NewPointPosition { index });
        }
        if new.observations.is_empty() {
            return Err(MapError::NewPointUnobserved { index });
        }
        for &o in &new.observations {
            match keyframe {
                Some(k) if o.keyframe == self.next_keyframe_id() => {
                    need_feature(o.keyframe, &k.frame, o.feature)?;
                }
                _ => self.need_free_feature(o)?,
            }
        }
        match find_twice(new.observations.iter().map(|o| o.keyframe)) {
            Some(keyframe) => Err(MapError::NewPointObservedTwice { index, keyframe }),
            None => Ok(()),
        }
    }

    fn add_keyframe(&mut self, new: NewKeyframe, change: &mut CovisibilityChange) -> KeyframeId {
        let id = self.next_keyframe_id();
        self.keyframes.push(Keyframe::new(id, new.frame, new.cam_from_world, self.revision + 1));
        self.first_young.push(self.next_point_id());
        for (feature, point) in new.matches {
            self.attach(point, Observation { keyframe: id, feature }, change);
        }
        id
    }

    pub(crate) fn add_point(&mut self, new: NewPoint, change: &mut CovisibilityChange) -> PointId {
        let mut observations = new.observations;
        observations.sort_unstable();
        let id = self.next_point_id();
        let created_by = KeyframeId::from_index(self.keyframes.len() - 1);
        let reference = observations.iter().find(|o| o.keyframe == created_by).unwrap_or(&observations[0]);
        let view = viewing_geometry(&self.keyframes, &observations, *reference, &new.position);
        for (i, o) in observations.iter().enumerate() {
            change.add(o.keyframe, &observations[i + 1..], 1);
            self.keyframes.live_mut(o.keyframe).set_point(o.feature, Some(id));
        }
        self.points.push(MapPoint {
            id,
            position: new.position,
            descriptor: representative_descriptor(&self.keyframes, &observations),
            normal: view.normal,
            min_distance_m: view.min_distance_m,
            max_distance_m: view.max_distance_m,
            reference: reference.keyframe,
            created_by,
            seen: 0,
            found: 0,
            belief: FIRST_BELIEF,
            observations,
        })
    }

    /// Removes the points that stop being young because of the last inserted keyframe and have one observation.
    fn end_probation(&mut self) {
        if self.first_young.len() <= PROBATION_KEYFRAMES {
            return;
        }
        let first = self.first_young.remove(0);
        let grown_up = (first.index()..self.first_young[0].index()).map(PointId::from_index);
        let expired: Vec<PointId> =
            grown_up.filter(|&p| self.point(p).is_some() && !self.has_enough_observations(p)).collect();
        let mut change = CovisibilityChange::default();
        expired.iter().for_each(|&p| self.discard(p, None, &mut change));
        self.apply_covisibility(change);
    }
}

/// The keyframe of a batch shows a point of the map, or a new one that another keyframe shows too.
fn shares_points(id: KeyframeId, new: &NewKeyframe, points: &[NewPoint]) -> bool {
    let observes = |p: &NewPoint| p.observations.iter().any(|o| o.keyframe == id);
    !new.matches.is_empty() || points.iter().any(|p| p.observations.len() > 1 && observes(p))
}

fn need_feature(keyframe: KeyframeId, frame: &Frame, feature: u32) -> Result<(), MapError> {
    let n_features = frame.len();
    if (feature as usize) < n_features {
        Ok(())
    } else {
        Err(MapError::NoFeature { keyframe, feature, n_features })
    }
}
