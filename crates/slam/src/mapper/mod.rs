//! Mapping: the one writer of the map. Inserts keyframes at once, then does the slow work on them.

mod close_loop;
mod cull_keyframes;
mod cull_points;
mod fuse;
mod insert;
mod local_bundle;
mod triangulate;
mod triangulate_pair;

use map::{KeyframeId, MapError, PointCount, PointId};

use crate::loops::{GlobalSolution, LoopCorrection};
use crate::params::Params;
use crate::probe::{Probe, Stage, staged};
use crate::tracker::KeyframeRequest;
use crate::world::World;

/// What the slow work on one keyframe did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MappingReport {
    /// Young points dropped.
    pub culled_points: usize,
    /// Points triangulated with covisible keyframes.
    pub triangulated: usize,
    /// Points merged with others, and observations added, by fusion.
    pub fused: usize,
    /// Keyframes moved by the local bundle adjustment.
    pub adjusted_keyframes: usize,
    /// Points moved by it.
    pub adjusted_points: usize,
    /// Observations that it found to be outliers.
    pub outliers: usize,
    /// Redundant keyframes removed.
    pub culled_keyframes: usize,
}

/// Owner of the world.
#[derive(Clone, Debug)]
pub struct Mapper {
    world: World,
    params: Params,
    /// Points on probation, in order of creation.
    young: Vec<PointId>,
}

impl Mapper {
    /// A mapper that continues with a world, usually [`World::new`].
    pub fn new(params: Params, world: World) -> Self {
        Mapper { world, params, young: Vec::new() }
    }

    /// The world as it is now; a clone is a snapshot.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Gives the world away at the end of a run.
    pub fn into_world(self) -> World {
        self.world
    }

    /// Adds the statistics of a tracked frame.
    pub fn count(&mut self, counts: &[PointCount]) {
        // Only a point that never existed is refused, and the tracker has its points from the map.
        let known = self.world.map.count(counts);
        debug_assert_eq!(known, Ok(()));
    }

    /// Inserts a keyframe with its stereo points at once; `None` if its reference is gone from the map.
    pub fn insert(&mut self, request: &KeyframeRequest, probe: &mut dyn Probe) -> Option<KeyframeId> {
        staged(probe, Stage::Insert, || self.insert_keyframe(request))
    }

    /// The slow work on a keyframe that was inserted: cull young points, triangulate, fuse, adjust, cull keyframes.
    pub fn refine(&mut self, keyframe: KeyframeId, probe: &mut dyn Probe) -> MappingReport {
        if let Some(inserted) = self.world.map.keyframe(keyframe) {
            self.world.places.add(keyframe, &inserted.frame);
        }
        let culled_points = staged(probe, Stage::CullPoints, || self.cull_points(keyframe));
        let triangulated = staged(probe, Stage::Triangulate, || self.triangulate(keyframe));
        let fused = staged(probe, Stage::Fuse, || self.fuse(keyframe));
        let adjusted = staged(probe, Stage::LocalBundle, || self.adjust(keyframe));
        let culled_keyframes = staged(probe, Stage::CullKeyframes, || self.cull_keyframes(keyframe));
        debug_assert_eq!(self.world.map.check(), Ok(()), "after keyframe {keyframe:?}");
        MappingReport { culled_points, triangulated, fused, culled_keyframes, ..adjusted }
    }

    /// Applies a loop to the map as it is now and fuses what both of its sides see.
    ///
    /// # Errors
    /// When the map refuses the correction; it is then as it was.
    pub fn close_loop(&mut self, found: &LoopCorrection, probe: &mut dyn Probe) -> Result<(), MapError> {
        staged(probe, Stage::LoopClose, || self.apply_loop(found))
    }

    /// Takes over a global bundle adjustment; what was inserted since follows.
    ///
    /// # Errors
    /// When the map refuses it; it is then as it was.
    pub fn adopt(&mut self, solution: &GlobalSolution) -> Result<(), MapError> {
        self.world.map.apply_correction(&solution.correction)
    }
}
