//! Young points are on probation: found where they should be seen, and soon seen by more than one keyframe.

use map::KeyframeId;

use super::Mapper;
use crate::tracker::stereo_observations;

/// Keyframes after which a point must have been observed enough.
const PROBATION: u32 = 2;
/// Keyframes after which probation is over.
const GRADUATION: u32 = 3;
/// Observations (a stereo one counts twice) that a point needs after [`PROBATION`] keyframes, with depth and without.
const MIN_OBSERVATIONS: usize = 4;
const MIN_MONOCULAR_OBSERVATIONS: usize = 3;

impl Mapper {
    /// Drops young points that failed, releases those that passed; returns how many were dropped.
    pub(super) fn cull_points(&mut self, keyframe: KeyframeId) -> usize {
        let young = std::mem::take(&mut self.young);
        let mut dropped = 0;
        let needed = if self.params.camera.sensor.is_scale_free() {
            MIN_MONOCULAR_OBSERVATIONS
        } else {
            MIN_OBSERVATIONS
        };
        for id in young {
            let Some(point) = self.world.map.point(id) else { continue };
            let age = keyframe.0.saturating_sub(point.created_by.0);
            let rarely_found =
                f64::from(point.found) < self.params.mapping.point_found_ratio * f64::from(point.seen);
            let lonely = age >= PROBATION && stereo_observations(&self.world.map, point) < needed;
            if rarely_found || lonely {
                if self.world.map.remove_point(id).is_ok() {
                    dropped += 1;
                }
            } else if age < GRADUATION {
                self.young.push(id);
            }
        }
        dropped
    }
}

#[cfg(test)]
#[path = "../../tests/steps/cull_points.rs"]
mod tests;
