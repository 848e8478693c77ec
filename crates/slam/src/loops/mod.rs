//! Loop closing: a keyframe that sees a place again gives a correction of the whole map, or a reason why not.

mod candidates;
mod consistency;
mod correct;
mod cycle_test;
mod essential_graph;
mod global;
mod outcome;
mod position_prior;
mod take_back;
mod verify;

use bow::Familiarity;
use geometry::SE3;
use map::{Correction, KeyframeId, PointId};
use optim::loop_test::Doubts;

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
    /// New poses, merged points, the loop's edge; an earlier loop that this one takes back.
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
    /// As `consistency`, of places that only a wrong loop keeps out of reach.
    out_of_reach: Consistency,
    /// What speaks against loops that were closed.
    doubts: Doubts<take_back::Name, SE3>,
    /// The keyframe at which the last loop was found.
    last_loop: Option<KeyframeId>,
}

impl LoopCloser {
    /// A loop closer that has seen nothing.
    pub fn new(params: Params) -> Self {
        LoopCloser {
            consistency: Consistency::default(),
            familiarity: Familiarity::default(),
            out_of_reach: Consistency::default(),
            doubts: Doubts::new(params.loops.min_gap as u32),
            params,
            last_loop: None,
        }
    }

    /// Whether `keyframe`, whose mapping is done in `world`, sees a place again.
    pub fn detect(&mut self, keyframe: KeyframeId, world: &World, probe: &mut dyn Probe) -> LoopOutcome {
        let candidates = match staged(probe, Stage::LoopDetect, || self.candidates(keyframe, world)) {
            Ok(candidates) => candidates,
            Err(reason @ (NoLoop::NoPlaces | NoLoop::TooEarly { .. })) => return LoopOutcome::None(reason),
            Err(reason) => {
                return match self.close_out_of_reach(keyframe, world, probe) {
                    Some(found) => self.closed(found),
                    None => LoopOutcome::None(reason),
                };
            }
        };
        let mut refused: Option<(KeyframeId, NoLoop)> = None;
        for candidate in candidates {
            match self.close(keyframe, candidate, world, probe) {
                Ok(found) => return self.closed(found),
                Err(reason) => refused = refused.or(Some((candidate, reason))),
            }
        }
        if let Some(found) = self.close_out_of_reach(keyframe, world, probe) {
            return self.closed(found);
        }
        match refused {
            // Similar streets are common; only what also matches in detail is worth a word.
            Some((_, reason @ NoLoop::TooFewMatches { .. })) => LoopOutcome::None(reason),
            Some((candidate, reason)) => LoopOutcome::Rejected { candidate, reason },
            None => LoopOutcome::None(NoLoop::NoPlaces),
        }
    }

    fn closed(&mut self, found: LoopCorrection) -> LoopOutcome {
        self.consistency.clear();
        self.familiarity.clear();
        self.out_of_reach.clear();
        self.last_loop = Some(found.keyframe);
        LoopOutcome::Closed(Box::new(found))
    }

    /// The correction by a place that would be within reach if one of the loops had not been closed, and takes that one back.
    fn close_out_of_reach(
        &mut self,
        keyframe: KeyframeId,
        world: &World,
        probe: &mut dyn Probe,
    ) -> Option<LoopCorrection> {
        let found = staged(probe, Stage::LoopDetect, || candidates::find_far(keyframe, world, &self.params));
        let (found, _) = self.out_of_reach.advance(&world.map, &found, self.params.loops.consistency);
        found.into_iter().find_map(|candidate| {
            let verified = self.verify(keyframe, candidate, world, probe).ok()?;
            staged(probe, Stage::PoseGraph, || {
                take_back::hear(&mut self.doubts, keyframe, &verified, world, &self.params)
            })
        })
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

    /// The correction that a candidate asks for; if it contradicts the map, maybe by taking an earlier loop back.
    fn close(
        &mut self,
        keyframe: KeyframeId,
        candidate: KeyframeId,
        world: &World,
        probe: &mut dyn Probe,
    ) -> Result<LoopCorrection, NoLoop> {
        let verified = self.verify(keyframe, candidate, world, probe)?;
        staged(probe, Stage::PoseGraph, || {
            match correct::correct(keyframe, &verified, &world.map, &self.params, None) {
                Err(NoLoop::Inconsistent { reason, numbers }) => {
                    take_back::hear(&mut self.doubts, keyframe, &verified, world, &self.params)
                        .ok_or(NoLoop::Inconsistent { reason, numbers })
                }
                other => other,
            }
        })
    }

    fn verify(
        &self,
        keyframe: KeyframeId,
        candidate: KeyframeId,
        world: &World,
        probe: &mut dyn Probe,
    ) -> Result<verify::Verified, NoLoop> {
        staged(probe, Stage::LoopVerify, || verify::verify(candidate, keyframe, world, &self.params))
    }
}

#[cfg(test)]
#[path = "../../tests/steps/detect.rs"]
mod tests;
