//! Where a keyframe can be at all: its estimated position, give or take the drift since the earlier visit.

use geometry::Vec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use map::{KeyframeId, Map};
use optim::DriftModel;

use super::cycle_test::drift_model;
use crate::params::CameraParams;

/// Positions of the keyframes of one sub-map, and how far each can have drifted against the current one.
pub(super) struct PositionPrior {
    /// Sorted by id: keyframes of the current one's sub-map with center and the length of the path up to them.
    along: Vec<(KeyframeId, Vec3, f64)>,
    current: Option<(Vec3, f64)>,
    drift: DriftModel,
}

impl PositionPrior {
    pub(super) fn new(map: &Map, current: KeyframeId, params: &CameraParams) -> Self {
        let mut along: Vec<(KeyframeId, Vec3, f64)> = Vec::new();
        for keyframe in map.submap_members(current).into_iter().filter_map(|id| map.keyframe(id)) {
            let center = keyframe.center();
            let path_m = along.last().map_or(0.0, |(_, last, path)| path + (center - last).norm());
            along.push((keyframe.id, center, path_m));
        }
        PositionPrior { current: find(&along, current), along, drift: drift_model(params) }
    }

    /// Whether a keyframe is where the current one may be. A keyframe of another sub-map may be anywhere.
    pub(super) fn allows(&self, other: KeyframeId) -> bool {
        let (Some((here, now)), Some((there, then))) = (self.current, find(&self.along, other)) else {
            return true;
        };
        self.drift.can_meet((here - there).norm(), (now - then).abs())
    }

    /// Whether a keyframe could be where the current one is if it was this far away; none of another sub-map could.
    pub(super) fn would_allow(&self, other: KeyframeId, distance_m: f64) -> bool {
        let ends = self.current.zip(find(&self.along, other));
        ends.is_some_and(|((_, now), (_, then))| self.drift.can_meet(distance_m, (now - then).abs()))
    }

    /// How far away another keyframe is, over how far the current one may be; 0 for a keyframe of another sub-map.
    pub(super) fn strain(&self, other: KeyframeId) -> f64 {
        let (Some((here, now)), Some((there, then))) = (self.current, find(&self.along, other)) else {
            return 0.0;
        };
        self.drift.strain((here - there).norm(), (now - then).abs())
    }

    /// The nearest keyframes that are `wanted`, within the margin, nearest first; of equals the older one.
    pub(super) fn nearby(&self, most: usize, wanted: impl Fn(KeyframeId) -> bool) -> Vec<KeyframeId> {
        let Some((here, _)) = self.current else { return Vec::new() };
        let centers: Vec<[f64; 3]> = self.along.iter().map(|k| k.1.into()).collect();
        let Ok(tree) = ImmutableKdTree::<f64, 3>::new_from_slice(&centers) else { return Vec::new() };
        let near =
            tree.query(&here.into()).within::<SquaredEuclidean<f64>>(self.drift.margin_m.powi(2)).execute();
        let near = near.into_iter().map(|near| (near.distance, self.along[near.item as usize].0));
        let mut found: Vec<(f64, KeyframeId)> = near.filter(|near| wanted(near.1)).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|(_, id)| id).take(most).collect()
    }
}

fn find(along: &[(KeyframeId, Vec3, f64)], keyframe: KeyframeId) -> Option<(Vec3, f64)> {
    let at = along.binary_search_by_key(&keyframe, |k| k.0).ok()?;
    Some((along[at].1, along[at].2))
}

#[cfg(test)]
#[path = "../../tests/steps/position_prior.rs"]
mod tests;
