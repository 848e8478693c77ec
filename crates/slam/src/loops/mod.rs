//! Loop closing: a keyframe that sees a place again gives a correction of the whole map, or a reason why not.

mod candidates;
mod consistency;
mod correct;
mod cycle_test;
mod essential_graph;
mod global;
mod outcome;
mod position_prior;
mod verify;

use bow::Familiarity;
use map::{Correction, KeyframeId, PointId};

use crate::params::Params;
use crate::probe::{Probe, Stage, staged};
use crate::world::World;
pub(crate) use candidates::strongest_groups;
use consistency::Consistency;
pub use global::{GlobalSolution, adjust_globally};
pub use outcome::{LoopOutcome, NoLoop};

/// A verified loop: what it joins, and what becomes of the map.
#[derive(Clone, Debug)]
pub struct LoopCorrection {
    /// The keyframe that saw a place again.
    pub keyframe: KeyframeId,
    /// The keyframe of the earlier visit.
    pub matched: KeyframeId,
    /// Points of the earlier visit that the keyframe shows.
    pub inliers: usize,
    /// How far the keyframe is from where it was thought to be, meters.
    pub moved_m: f64,
    /// How far it is turned, degrees.
    pub turned_deg: f64,
    /// Length now over length at the earlier visit; 1 where scale is observed.
    pub scale: f64,
    /// Whether two sub-maps become one.
    pub joins_submaps: bool,
    /// New poses, merged points, the loop's edge.
    pub correction: Correction,
    /// Points of the earlier visit, to be looked for on the new side once the map is corrected.
    pub earlier_points: Vec<PointId>,
}

/// Looks for loops, keyframe after keyframe, in the order of their ids.
#[derive(Clone, Debug)]
pub struct LoopCloser {
    params: Params,
    consistency: Consistency,
    /// How familiar places have been to the keyframes so far.
    familiarity: Familiarity,
    /// The keyframe at which the last loop was found.
    last_loop: Option<KeyframeId>,
}

impl LoopCloser {
    /// A loop closer that has seen nothing.
    pub fn new(params: Params) -> Self {
        LoopCloser {
            params,
            consistency: Consistency::default(),
            familiarity: Familiarity::default(),
            last_loop: None,
        }
    }

    /// Whether `keyframe`, whose mapping is done in `world`, sees a place again.
    pub fn detect(&mut self, keyframe: KeyframeId, world: &World, probe: &mut dyn Probe) -> LoopOutcome {
        let candidates = match staged(probe, Stage::LoopDetect, || self.candidates(keyframe, world)) {
            Ok(candidates) => candidates,
            Err(reason) => return LoopOutcome::None(reason),
        };
        let mut refused: Option<(KeyframeId, NoLoop)> = None;
        for candidate in candidates {
            match self.close(keyframe, candidate, world, probe) {
                Ok(found) => {
                    self.consistency.clear();
                    self.familiarity.clear();
                    self.last_loop = Some(keyframe);
                    return LoopOutcome::Closed(Box::new(found));
                }
                Err(reason) => refused = refused.or(Some((candidate, reason))),
            }
        }
        match refused {
            // Similar streets are common; only what also matches in detail is worth a word.
            Some((_, reason @ NoLoop::TooFewMatches { .. })) => LoopOutcome::None(reason),
            Some((candidate, reason)) => LoopOutcome::Rejected { candidate, reason },
            None => LoopOutcome::None(NoLoop::NoPlaces),
        }
    }

    /// Candidates that were consistent for long enough; at least one.
    fn candidates(&mut self, keyframe: KeyframeId, world: &World) -> Result<Vec<KeyframeId>, NoLoop> {
        let params = &self.params.loops;
        if !params.enabled {
            return Err(NoLoop::NoPlaces);
        }
        let since = keyframe.0 - self.last_loop.map_or(0, |last| last.0);
        let (keyframes, needed) = (since as usize, params.min_gap);
        if keyframes < needed {
            return Err(NoLoop::TooEarly { keyframes, needed });
        }
        let found = candidates::find(keyframe, world, &self.params, &mut self.familiarity)
            .inspect_err(|_| self.consistency.clear())?;
        let needed = params.consistency;
        let (accepted, seen) = self.consistency.advance(&world.map, &found, needed);
        if accepted.is_empty() { Err(NoLoop::NotYetConsistent { seen, needed }) } else { Ok(accepted) }
    }

    fn close(
        &self,
        keyframe: KeyframeId,
        candidate: KeyframeId,
        world: &World,
        probe: &mut dyn Probe,
    ) -> Result<LoopCorrection, NoLoop> {
        let verified =
            staged(probe, Stage::LoopVerify, || verify::verify(candidate, keyframe, world, &self.params))?;
        staged(probe, Stage::PoseGraph, || correct::correct(keyframe, &verified, &world.map, &self.params))
    }
}

#[cfg(test)]
#[path = "../../tests/steps/detect.rs"]
mod tests;
