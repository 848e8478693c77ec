//! The library's front door: push images, get poses and a map.
//!
//! A [`Session`] runs over a dataset, a video, a camera or a rendered world.

mod camera;
mod config;
mod error;
mod finished;
mod input;
mod intake;
mod maps;
mod network;
mod options;
mod rendered;
mod session;
mod setup;
mod slam;
pub mod trajectories;
mod video;
mod video_feed;
mod view;

pub use camera::Camera;
pub use config::{CameraError, Config, SCHEMA};
pub use error::{Error, FrameProblem};
pub use finished::Finished;
pub use geometry::{Distortion, Pinhole, SE3, Sensor, StereoRig};
pub use input::{Input, InputOptions};
pub use maps::{load_map, sha256, vocabulary};
pub use network::{NetworkOptions, load as load_network, open as open_network};
pub use options::SlamOptions;
pub use runtime::{FrameAnswer, FrameStatus, Observer, RunOutcome, Schedule, Silent};
pub use session::{Session, SessionOptions};
pub use slam::Slam;
pub use video::is_camera;
pub use view::{DepthView, ImageView, Images, PixelFormat};
