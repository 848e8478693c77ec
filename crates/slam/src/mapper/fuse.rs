//! Fusion of duplicates: points projected into neighboring keyframes, and the neighbors' points into this one.

use features::WindowMatch;
use map::{Keyframe, KeyframeId, Map, MapPoint, Observation, PointId};

use super::Mapper;
use crate::noise::agrees;
use crate::search::{points_of, query, search};
use crate::visibility::visible_points;

/// Search window, pixels at octave 0.
const RADIUS_PX: f32 = 3.0;
/// Largest descriptor distance of duplicates.
const MAX_DISTANCE: u32 = 50;

impl Mapper {
    /// Fuses with neighbors of first and second order; returns merges and new observations.
    pub(super) fn fuse(&mut self, keyframe: KeyframeId) -> usize {
        let targets = self.fusion_targets(keyframe);
        let own = self.world.map.keyframe(keyframe).map_or(&[][..], |kf| kf.points());
        let own: Vec<PointId> = own.iter().flatten().copied().collect();
        let mut changed = 0;
        for &target in &targets {
            changed += self.fuse_into(target, &own);
        }
        let foreign = points_of(&self.world.map, targets);
        changed + self.fuse_into(keyframe, &foreign)
    }

    /// The best covisible keyframes and the best covisible ones of those.
    fn fusion_targets(&self, keyframe: KeyframeId) -> Vec<KeyframeId> {
        let mapping = &self.params.mapping;
        let best = |id: KeyframeId, n: usize| {
            self.world.map.keyframe(id).map_or(Vec::new(), |kf| kf.best_covisible(n).to_vec())
        };
        let mut targets = Vec::new();
        for (first, _) in best(keyframe, self.params.neighbours()) {
            let second = best(first, mapping.second_neighbors).into_iter().map(|(id, _)| id);
            for id in std::iter::once(first).chain(second) {
                if id != keyframe && !targets.contains(&id) {
                    targets.push(id);
                }
            }
        }
        targets
    }

    /// Projects `points` into `target`: a feature that holds another point merges the two, a free one is linked.
    pub(super) fn fuse_into(&mut self, target: KeyframeId, points: &[PointId]) -> usize {
        let Some(keyframe) = self.world.map.keyframe(target) else { return 0 };
        let found = find_duplicates(&self.world.map, keyframe, points);
        let mut changed = 0;
        for (feature, id) in found {
            let Some(id) = self.world.map.resolve(id) else { continue };
            let holder = self.world.map.keyframe(target).and_then(|kf| kf.point_at(feature));
            let done = match holder {
                Some(other) if other == id => false,
                Some(other) => {
                    let (keep, drop) = self.longer_lived(other, id);
                    self.world.map.merge_points(keep, drop).is_ok()
                }
                None => self.world.map.link(id, Observation { keyframe: target, feature }).is_ok(),
            };
            changed += usize::from(done);
        }
        changed
    }

    /// The point with more observations first; ties keep the older point.
    fn longer_lived(&self, a: PointId, b: PointId) -> (PointId, PointId) {
        let observations = |id| self.world.map.point(id).map_or(0, |p| p.observations().len());
        let (n_a, n_b) = (observations(a), observations(b));
        if n_a > n_b || (n_a == n_b && a < b) { (a, b) } else { (b, a) }
    }
}

/// Features of `keyframe` at which points from elsewhere appear, as `(feature, point)`.
fn find_duplicates(map: &Map, keyframe: &Keyframe, points: &[PointId]) -> Vec<(u32, PointId)> {
    let (frame, cam_from_world) = (&keyframe.frame, keyframe.cam_from_world);
    let own = keyframe.points().iter().flatten().copied();
    let visible = visible_points(frame, map, &cam_from_world, points, own);
    let asked = visible.iter().map(|seen| (seen.point, query(frame, seen, RADIUS_PX)));
    let fits = |point: &MapPoint, find: &WindowMatch| {
        let feature = find.best.feature as usize;
        find.best.distance <= MAX_DISTANCE && agrees(frame, feature, &(cam_from_world * point.position), 1.0)
    };
    let found = search(frame, asked, &vec![true; frame.len()], fits);
    found.into_iter().map(|(feature, point)| (feature, point.id)).collect()
}

#[cfg(test)]
#[path = "../../tests/steps/fuse.rs"]
mod tests;
