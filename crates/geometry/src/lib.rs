//! Poses, cameras, minimal solvers and weighted RANSAC: pure mathematics.
//!
//! Start reading at [`SE3`] (poses), [`StereoRig`] (the camera model of every frame) and [`ransac`] (robust estimation).
//! Lengths are meters, angles radians, pixel coordinates count from the center of the upper left pixel, and cameras look
//! along +z with x to the right and y down. `a_from_b` maps coordinates of frame `b` into frame `a`.

mod aliases;
mod camera_model;
mod distortion;
mod essential;
mod estimators;
mod fundamental;
mod homography;
mod median;
mod p3p;
mod pinhole;
mod polynomial;
mod pose_covariance;
mod product;
mod ransac;
mod raster;
mod rectify;
mod sampler;
mod se3;
mod seed;
mod sensor;
mod series;
mod sim3;
mod so3;
mod stereo;
mod svd;
mod triangulate;
mod two_view;
mod umeyama;

pub use aliases::*;
pub use camera_model::{CameraModel, KannalaBrandt, Rational};
pub use distortion::Distortion;
pub use essential::{decompose_essential, essential_from_fundamental};
pub use estimators::{
    FundamentalEstimator, HomographyEstimator, PnpEstimator, SightedPoints, SimilarityEstimator,
};
pub use fundamental::{estimate_fundamental, sampson_error_sq};
pub use homography::{
    Homography, PlanarMotion, decompose_homography, estimate_homography, homography_of_four,
};
pub use median::median;
pub use p3p::p3p;
pub use pinhole::Pinhole;
pub use pose_covariance::PoseCovariance;
pub use ransac::{Consensus, Estimator, RansacOptions, ransac};
pub use raster::{DepthImage, GrayImage, ImageSize, Raster};
pub use rectify::{RectificationError, StereoRectification, rectify_single, rectify_stereo};
pub use se3::SE3;
pub use seed::mix_seed;
pub use sensor::{Sensor, UnknownSensor};
pub use sim3::Sim3;
pub use so3::SO3;
pub use stereo::StereoRig;
pub use triangulate::{angle_between, triangulate, triangulate_dlt};
pub use two_view::{
    TwoView, TwoViewFailure, TwoViewMatches, TwoViewModel, TwoViewOptions, TwoViewReconstruction,
};
pub use umeyama::align_umeyama;
