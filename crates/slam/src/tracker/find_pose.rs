//! The ways to a pose, tried in turn.

use features::Frame;
use map::KeyframeId;

use super::Tracker;
use super::inertia::Inertia;
use super::last_frame::LastFrame;
use super::local_map::{LocalMap, LocallyTracked};
use super::predict::Attempt;
use crate::lost::Lost;
use crate::probe::{Probe, Stage, staged};
use crate::world::World;

impl Tracker {
    /// Tries the ways of prediction in turn, each confirmed by the local map. The reason of the attempt that came
    /// furthest is returned if all fail.
    pub(super) fn find_pose(
        &self,
        frame: &Frame,
        world: &World,
        last: Option<&LastFrame>,
        probe: &mut dyn Probe,
    ) -> Result<LocallyTracked, Lost> {
        let attempts = match (last, self.velocity) {
            (Some(_), Some(_)) if !self.loss.is_lost => {
                &[Attempt::Motion, Attempt::ReferenceKeyframe, Attempt::Relocalization][..]
            }
            (Some(_), _) => &[Attempt::ReferenceKeyframe, Attempt::Motion, Attempt::Relocalization],
            (None, _) => &[Attempt::Relocalization],
        };
        let inertia = last.and_then(|last| self.inertia(frame, &world.map, last));
        let mut reason: Option<Lost> = None;
        for &attempt in attempts {
            let lost = match self.attempt(attempt, frame, world, last, inertia, probe) {
                Ok(local) => return Ok(local),
                Err(lost) => lost,
            };
            reason = Some(reason.map_or(lost, |earlier| earlier.further(lost)));
        }
        Err(reason
            .unwrap_or(Lost::TooFewMatches { found: 0, needed: self.params.tracking.min_reference_matches }))
    }

    /// One way of prediction, confirmed by the local map.
    fn attempt(
        &self,
        attempt: Attempt,
        frame: &Frame,
        world: &World,
        last: Option<&LastFrame>,
        inertia: Option<Inertia>,
        probe: &mut dyn Probe,
    ) -> Result<LocallyTracked, Lost> {
        let (map, tracking) = (&world.map, &self.params.tracking);
        let predicted = staged(probe, Stage::Predict, || self.predict(attempt, frame, world, last, inertia))?;
        let fallback = last.map_or(KeyframeId(0), |last| last.pose.keyframe);
        let local = staged(probe, Stage::LocalMap, || {
            let local = LocalMap::gather(map, &predicted.matches, fallback, tracking);
            local.track(frame, map, &predicted, &self.params)
        });
        let needed = self.inliers_needed(frame, map, last, &local.cam_from_world);
        let found = local.matches.len();
        if found < needed {
            return Err(Lost::TooFewLocalInliers { found, needed });
        }
        let inertia = inertia.filter(|_| attempt != Attempt::Relocalization);
        inertia.map_or(Ok(()), |inertia| inertia.check(&local.cam_from_world))?;
        Ok(local)
    }
}
