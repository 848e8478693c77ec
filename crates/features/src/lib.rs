//! ORB features, stereo and depth association, descriptor matching.
//!
//! Start reading at [`FrameBuilder`] (images to a [`Frame`]), then [`Extractor`] (one image to [`Features`]) and
//! [`search_window`] (a predicted position to a feature).

mod activation;
mod align;
mod brute_force;
mod builder;
mod config;
mod depth;
mod descriptor;
mod detect;
mod epipolar;
mod evaluation;
mod extractor;
mod follow;
mod frame;
mod grid;
mod kernels;
mod keypoint;
mod mask;
mod patch;
mod pattern;
mod plane;
mod pyramid;
mod quadtree;
mod remap;
mod rotation;
mod scales;
mod selection;
mod stereo;
mod window;

pub use activation::{ActivationError, ActivationMap, ActivationSource};
pub use brute_force::match_brute_force;
pub use builder::{BuiltFrame, FrameBuilder};
pub use config::{Align, ExtractorConfig, NetworkSize};
pub use depth::{DepthConfig, EDGE_REACH_PX};
pub use descriptor::Descriptor;
pub use epipolar::{EpipolarRange, search_epipolar, search_epipolar_all};
pub use evaluation::{Evaluator, InTurn};
pub use extractor::{Extractor, Selected};
pub use frame::{Bounds, Frame, Rig};
pub use keypoint::{Features, Keypoint};
pub use mask::FeatureMask;
pub use patch::{Aligned, Patch};
pub use plane::Plane;
pub use pyramid::Pyramid;
pub use remap::{RemapTable, remap};
pub use rotation::consistent_rotations;
pub use scales::{ScaleLevels, level_quotas};
pub use selection::{Contender, SelectionConfig, SelectionRule, Spread, select};
pub use stereo::StereoConfig;
pub use window::{Candidate, ProjectionQuery, WindowMatch, search_window, search_windows};
