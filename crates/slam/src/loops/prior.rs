//! Where a keyframe can be at all: its estimated position, give or take the drift since the earlier visit.

use geometry::Vec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use map::{KeyframeId, Map};

use crate::params::LoopParams;

/// Positions of the keyframes of one sub-map, and how far each can have drifted against the current one.
pub(super) struct PositionPrior {
    /// Sorted by id: keyframes of the current one's sub-map with centre and the length of the path up to them.
    along: Vec<(KeyframeId, Vec3, f64)>,
    current: Option<(Vec3, f64)>,
    max_drift: f64,
    margin_m: f64,
}

impl PositionPrior {
    pub(super) fn new(map: &Map, current: KeyframeId, params: &LoopParams) -> Self {
        let mut along: Vec<(KeyframeId, Vec3, f64)> = Vec::with_capacity(map.n_keyframes());
        for keyframe in submap_members(map, current).into_iter().filter_map(|id| map.keyframe(id)) {
            let center = keyframe.center();
            let path_m = along.last().map_or(0.0, |(_, last, path)| path + (center - last).norm());
            along.push((keyframe.id, center, path_m));
        }
        let mut prior = PositionPrior {
            along,
            current: None,
            max_drift: params.max_drift,
            margin_m: params.prior_margin_m,
        };
        prior.current = prior.find(current);
        prior
    }

    /// Whether a keyframe is where the current one may be. A keyframe of another sub-map may be anywhere.
    pub(super) fn allows(&self, other: KeyframeId) -> bool {
        let (Some((here, now)), Some((there, then))) = (self.current, self.find(other)) else { return true };
        (here - there).norm() <= self.margin_m + self.max_drift * (now - then).abs()
    }

    /// The nearest keyframes that are `wanted`, within the margin, nearest first.
    pub(super) fn nearby(&self, most: usize, wanted: impl Fn(KeyframeId) -> bool) -> Vec<KeyframeId> {
        let Some((here, _)) = self.current else { return Vec::new() };
        let suitable: Vec<&(KeyframeId, Vec3, f64)> = self.along.iter().filter(|k| wanted(k.0)).collect();
        let Some(n) = std::num::NonZeroUsize::new(most).filter(|_| !suitable.is_empty()) else {
            return Vec::new();
        };
        let centers: Vec<[f64; 3]> = suitable.iter().map(|k| [k.1.x, k.1.y, k.1.z]).collect();
        let Ok(tree) = ImmutableKdTree::<f64, 3>::new_from_slice(&centers) else { return Vec::new() };
        let mut found: Vec<(f64, KeyframeId)> = tree
            .query(&[here.x, here.y, here.z])
            .nearest_n::<SquaredEuclidean<f64>>(n)
            .execute()
            .into_iter()
            .filter(|near| near.distance <= self.margin_m.powi(2))
            .map(|near| (near.distance, suitable[near.item as usize].0))
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|(_, id)| id).collect()
    }

    fn find(&self, keyframe: KeyframeId) -> Option<(Vec3, f64)> {
        let at = self.along.binary_search_by_key(&keyframe, |k| k.0).ok()?;
        Some((self.along[at].1, self.along[at].2))
    }
}

/// The keyframes of a keyframe's sub-map, in order of their ids.
pub(super) fn submap_members(map: &Map, keyframe: KeyframeId) -> Vec<KeyframeId> {
    let mut members = Vec::new();
    let mut open: Vec<KeyframeId> = map.submap_of(keyframe).into_iter().collect();
    while let Some(id) = open.pop() {
        members.push(id);
        open.extend(map.keyframe(id).map_or(&[][..], |kf| kf.children()));
    }
    members.sort_unstable();
    members
}
