//! Visual SLAM: push images, get poses and a map.
//!
//! [`Slam`] takes the images of one camera, two cameras, or a camera with depth, and gives a pose for each frame:
//!
//! ```
//! use dsslam::{Camera, Config, FrameStatus, Slam, synth};
//!
//! # fn main() -> Result<(), dsslam::Error> {
//! // A rendered street; your own camera is one line as well, see `Camera`.
//! let world = synth::World::new(synth::Preset::Town, 1, 1);
//! let (width, height) = world.image_size();
//! let camera = Camera::stereo(world.rig(), width, height);
//!
//! let mut slam = Slam::new(&Config::load(None, &[])?, camera)?;
//! for i in 0..5 {
//!     let images = world.images(i);
//!     let seen = slam.track(i as i64 * 100_000_000, (&images.left, &images.right))?;
//!     assert!(matches!(seen.status, FrameStatus::Tracked { .. }));
//!     println!("{:?}", seen.world_from_cam);
//! }
//! let done = slam.finish()?;
//! assert_eq!(done.trajectory().poses.len(), 5);
//! assert!(done.outcome.map.n_points() > 100);
//! # Ok(())
//! # }
//! ```
//!
//! | to do | take |
//! |---|---|
//! | push images, get poses | [`Slam`], with a [`Camera`] and [`Images`] of any stride |
//! | run over a dataset, a video, a camera | [`Session`] |
//! | change parameters | [`Config`] |
//! | another vocabulary, network, schedule; a map to start with or to localize in | [`SlamOptions`] |
//! | poses, map, loops; save the map | [`Finished`] |
//!
//! Poses are named by their frames: `world_from_cam` turns points of the camera (x right, y down, z forward) into points of the
//! world; meters, except with one camera, whose unit of length is free. Equal frames, configuration and seed give equal bits,
//! except with [`Schedule::Live`].
//!
//! The examples `01_folder`, `02_push_images` and `03_save_load_localize` are programs to start from. The crates behind this one are
//! its modules [`geometry`], [`io`], [`map`], [`runtime`] and [`synth`].

mod bag_input;
mod camera;
mod config;
mod error;
mod evaluation;
mod figures;
mod finished;
mod input;
mod intake;
mod maps;
pub mod mcap;
mod network;
mod options;
mod programs;
mod rendered;
mod session;
mod setup;
mod slam;
pub mod submaps;
pub mod trajectories;
mod verdict;
mod video;
mod video_feed;
mod view;

pub use ::{bag, geometry, io, map, runtime, synth};

pub use ::slam::{Assessment, QualityReason};
pub use camera::Camera;
pub use config::{CameraError, Chosen, Config, SCHEMA, presets};
pub use error::{Error, FrameProblem};
pub use evaluation::{Compared, Scale, scale_against_truth};
pub use figures::{Doubt, Figure, Figures};
pub use finished::Finished;
pub use geometry::{DepthImage, Distortion, GrayImage, Pinhole, PoseCovariance, SE3, Sensor, StereoRig};
pub use input::{Input, InputOptions};
pub use maps::{load_map, sha256, vocabulary};
pub use network::{NetworkOptions, load as load_network, open as open_network};
pub use options::SlamOptions;
pub use programs::{find_program, shield};
pub use runtime::{Event, FrameAnswer, FrameStatus, Observer, RunOutcome, Schedule, Silent};
pub use session::{Session, SessionOptions};
pub use slam::Slam;
pub use verdict::Verdict;
pub use video::is_camera;
pub use view::{DepthView, ImageView, Images, PixelFormat};

/// The code of the page on the library, compiled by the tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/library.md")]
struct LibraryPage;
