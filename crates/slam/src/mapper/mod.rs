//! Mapping: the one writer of the map. Inserts keyframes at once, then does the slow work on them.

mod close_loop;
mod cull_keyframes;
mod cull_points;
mod fuse;
mod insert;
mod local_bundle;
mod triangulate;
mod triangulate_pair;

use std::sync::Arc;

use map::{Correction, KeyframeId, MapError, PointCount, PointId};

use crate::loops::{GlobalSolution, LoopCorrection, adjust_globally};
use crate::params::Params;
use crate::probe::{Probe, Stage, staged};
use crate::refine::{Refinement, refined};
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
    refinement: Refinement,
}

impl Mapper {
    /// A mapper that continues with a world, usually [`World::new`].
    pub fn new(params: Params, world: World) -> Self {
        Mapper { world, params, young: Vec::new(), refinement: Refinement::default() }
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
        let n_keyframes = self.world.map.n_keyframes();
        if self.params.mapping.refine_calibration && self.refinement.is_due(n_keyframes) {
            staged(probe, Stage::Calibrate, || self.calibrate());
        }
        debug_assert_eq!(self.world.map.check(), Ok(()), "after keyframe {keyframe:?}");
        MappingReport { culled_points, triangulated, fused, culled_keyframes, ..adjusted }
    }

    /// The last look at the whole map at the end of a run, when it tells most: at the calibration, then at all keyframes and
    /// points together. Local adjustments hold what lies further back, and so pass its errors on.
    pub fn settle(&mut self, probe: &mut dyn Probe) {
        if self.params.mapping.refine_calibration && self.refinement.fits(self.world.map.n_keyframes()) {
            staged(probe, Stage::Calibrate, || self.calibrate());
        }
        if self.params.mapping.final_bundle
            && let Some(solution) = adjust_globally(&self.world, &self.params, probe)
        {
            let adopted = self.adopt(&solution);
            debug_assert_eq!(adopted, Ok(()));
        }
    }

    /// Looks for errors of the calibration, and takes them out of the whole map.
    fn calibrate(&mut self) {
        let now = self.world.calibration.clone();
        let Some((found, correction)) = refined(&self.world.map, now.as_deref(), &self.params) else {
            return;
        };
        self.world.map.recalibrate(|frame| found.apply(frame, now.as_deref()));
        let correction = Correction { seen_revision: self.world.map.revision(), ..correction };
        let corrected = self.world.map.apply_correction(&correction);
        debug_assert_eq!(corrected, Ok(()));
        self.world.calibration = Some(Arc::new(found));
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
