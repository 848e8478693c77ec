//! New points from features that two covisible keyframes see and that have no point yet.

use features::{EpipolarRange, search_epipolar_all};
use map::{Batch, KeyframeId, NewPoint, Observation};

use super::Mapper;
use super::two_view::{View, locate};
use crate::assign::one_to_one;

/// Points at infinity are searched up to this depth, in baselines of the rig.
const MAX_DEPTH_BASELINES: f64 = 4000.0;
/// And from this depth on.
const MIN_DEPTH_BASELINES: f64 = 2.0;
/// Largest descriptor distance of a match.
const MAX_DISTANCE: u32 = 50;
/// Best over second-best descriptor distance.
const MAX_RATIO: f32 = 0.8;

impl Mapper {
    /// Triangulates with the best covisible keyframes in turn; returns the number of new points.
    pub(super) fn triangulate(&mut self, keyframe: KeyframeId) -> usize {
        let neighbours = match self.world.map.keyframe(keyframe) {
            Some(kf) => kf.best_covisible(self.params.mapping.neighbours).to_vec(),
            None => return 0,
        };
        neighbours.into_iter().map(|(neighbour, _)| self.triangulate_with(keyframe, neighbour)).sum()
    }

    fn triangulate_with(&mut self, keyframe: KeyframeId, neighbour: KeyframeId) -> usize {
        let (Some(a), Some(b)) = (self.world.map.keyframe(keyframe), self.world.map.keyframe(neighbour))
        else {
            return 0;
        };
        let (view_a, view_b) = (View::new(a), View::new(b));
        let baseline_m = view_a.frame.rig.stereo.baseline_m;
        if (view_a.center - view_b.center).norm() < baseline_m {
            return 0;
        }
        let unmatched: Vec<u32> = (0..a.frame.len() as u32).filter(|&i| a.point_at(i).is_none()).collect();
        let free: Vec<bool> = b.points().iter().map(Option::is_none).collect();
        let b_from_a = b.cam_from_world * view_a.world_from_cam;
        let range = EpipolarRange {
            min_depth_m: MIN_DEPTH_BASELINES * baseline_m,
            max_depth_m: MAX_DEPTH_BASELINES * baseline_m,
            max_distance: MAX_DISTANCE,
        };
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
                    Observation { keyframe: neighbour, feature: feature_b },
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
}
