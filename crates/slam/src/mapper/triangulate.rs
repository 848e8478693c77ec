//! New points from features that two covisible keyframes see and that have no point yet.

use features::{EpipolarRange, search_epipolar_all};
use geometry::median;
use map::{Batch, KeyframeId, Map, NewPoint, Observation};

use super::Mapper;
use super::triangulate_pair::{View, locate};
use crate::assign::one_to_one;

/// Points at infinity are searched up to this depth, in baselines of the rig.
const MAX_DEPTH_BASELINES: f64 = 4000.0;
/// And from this depth on.
const MIN_DEPTH_BASELINES: f64 = 2.0;
/// Distance of two cameras without stereo over the scene's median depth from which they tell depths.
const MIN_PARALLAX: f64 = 0.01;
/// Nearest depth that they look for, in median depths.
const MIN_RELATIVE_DEPTH: f64 = 0.05;
/// Largest descriptor distance of a match.
const MAX_DISTANCE: u32 = 50;
/// Best over second-best descriptor distance.
const MAX_RATIO: f32 = 0.8;

impl Mapper {
    /// Triangulates with the best covisible keyframes in turn; returns the number of new points.
    pub(super) fn triangulate(&mut self, keyframe: KeyframeId) -> usize {
        let neighbours = match self.world.map.keyframe(keyframe) {
            Some(kf) => kf.best_covisible(self.params.neighbours()).to_vec(),
            None => return 0,
        };
        neighbours.into_iter().map(|(neighbor, _)| self.triangulate_with(keyframe, neighbor)).sum()
    }

    fn triangulate_with(&mut self, keyframe: KeyframeId, neighbor: KeyframeId) -> usize {
        let (Some(a), Some(b)) = (self.world.map.keyframe(keyframe), self.world.map.keyframe(neighbor))
        else {
            return 0;
        };
        let (view_a, view_b) = (View::new(a), View::new(b));
        let Some((min_depth_m, max_depth_m)) = self.depth_range(&view_a, &view_b, neighbor) else {
            return 0;
        };
        let unmatched: Vec<u32> = (0..a.frame.len() as u32).filter(|&i| a.point_at(i).is_none()).collect();
        let free: Vec<bool> = b.points().iter().map(Option::is_none).collect();
        let b_from_a = b.cam_from_world * view_a.world_from_cam;
        let range = EpipolarRange { min_depth_m, max_depth_m, max_distance: MAX_DISTANCE };
        let finds = search_epipolar_all(&a.frame, &unmatched, &b.frame, &b_from_a, &range, &free);
        let pairs = one_to_one(&finds, b.frame.len(), |_, find| {
            find.second.is_none_or(|second| find.best.distance as f32 <= MAX_RATIO * second.distance as f32)
        });
        let points: Vec<NewPoint> = pairs
            .into_iter()
            .filter_map(|(feature_b, query)| {
                let feature_a = unmatched[query];
                let position = locate(&view_a, feature_a as usize, &view_b, feature_b as usize)?;
                let observations = vec![
                    Observation { keyframe, feature: feature_a },
                    Observation { keyframe: neighbor, feature: feature_b },
                ];
                Some(NewPoint { position, observations })
            })
            .collect();
        match self.world.map.insert(Batch { keyframe: None, points }) {
            Ok(inserted) => {
                let n_new = inserted.points.len();
                self.young.extend(inserted.points);
                n_new
            }
            Err(_) => 0,
        }
    }

    /// Depths at which two keyframes can see points; `None` when they are too near to each other to tell.
    fn depth_range(&self, a: &View<'_>, b: &View<'_>, neighbor: KeyframeId) -> Option<(f64, f64)> {
        let distance = (a.center - b.center).norm();
        if self.params.camera.sensor.is_scale_free() {
            let depth = median_depth(&self.world.map, neighbor)?;
            (distance >= MIN_PARALLAX * depth).then_some((MIN_RELATIVE_DEPTH * depth, f64::INFINITY))
        } else {
            let baseline_m = a.frame.rig.stereo.baseline_m;
            let range = (MIN_DEPTH_BASELINES * baseline_m, MAX_DEPTH_BASELINES * baseline_m);
            (distance >= baseline_m).then_some(range)
        }
    }
}

/// Median depth of the points of a keyframe.
fn median_depth(map: &Map, keyframe: KeyframeId) -> Option<f64> {
    let cam_from_world = map.keyframe(keyframe)?.cam_from_world;
    let points = map.points_of(keyframe);
    let mut depths: Vec<f64> = points.map(|(_, point)| (cam_from_world * point.position).z).collect();
    median(&mut depths).filter(|&depth| depth > 0.0)
}

#[cfg(test)]
#[path = "../../tests/steps/triangulate.rs"]
mod tests;
