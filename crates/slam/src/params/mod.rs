//! What can be set in tracking, mapping and loop closing. Defaults follow ORB-SLAM2's published constants where not said
//! otherwise. The structs are sections of the configuration; what follows from the camera stands in [`CameraParams`].

mod camera;
mod loops;
mod mapping;
mod tracking;
mod weights;

pub use camera::CameraParams;
pub use loops::LoopParams;
pub use mapping::MappingParams;
pub use tracking::TrackingParams;
pub use weights::Weights;

use crate::noise::Noise;

/// All parameters of the SLAM steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// What follows from the camera.
    pub camera: CameraParams,
    /// The tracker's.
    pub tracking: TrackingParams,
    /// The mapper's.
    pub mapping: MappingParams,
    /// The loop closer's.
    pub loops: LoopParams,
    /// Where the activation of features counts.
    pub weights: Weights,
    /// Seed of every random decision.
    pub seed: u64,
}

impl Params {
    /// The defaults with this camera.
    pub fn of(camera: CameraParams) -> Self {
        Self {
            camera,
            tracking: TrackingParams::default(),
            mapping: MappingParams::default(),
            loops: LoopParams::default(),
            weights: Weights::default(),
            seed: 0,
        }
    }

    /// Share of the reference keyframe's points below which a keyframe is due.
    pub(crate) fn keyframe_ratio(&self) -> f64 {
        self.tracking.keyframe_ratio.unwrap_or(self.camera.keyframe_ratio)
    }

    /// Covisible keyframes that triangulation and fusion look at.
    pub(crate) fn neighbours(&self) -> usize {
        self.mapping.neighbours.unwrap_or(self.camera.neighbours)
    }

    /// How exactly features are placed.
    pub(crate) fn noise(&self) -> Noise {
        Noise { sigma_px: self.camera.feature_sigma_px, weighted: self.weights.optimisation }
    }
}
