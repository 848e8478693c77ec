//! Poses, cameras, minimal solvers and weighted RANSAC: pure mathematics.
//!
//! Start reading at [`SE3`] (poses), [`StereoRig`] (the camera model of every frame) and [`ransac`] (robust estimation).
//! Lengths are metres, angles radians, pixel coordinates count from the centre of the upper left pixel, and cameras look
//! along +z with x to the right and y down. `a_from_b` maps coordinates of frame `b` into frame `a`.

mod aliases;
mod distortion;
mod pinhole;
mod product;
mod raster;
mod se3;
mod seed;
mod series;
mod sim3;
mod so3;
mod stereo;

pub use aliases::*;
pub use distortion::Distortion;
pub use pinhole::Pinhole;
pub use raster::{DepthImage, GrayImage, Raster};
pub use se3::SE3;
pub use seed::mix_seed;
pub use sim3::Sim3;
pub use so3::SO3;
pub use stereo::StereoRig;
