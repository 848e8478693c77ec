//! The library's front door: push images, get poses and a map.
//!
//! A [`Session`] runs over a dataset, a video, a camera or a rendered world.

mod error;
mod input;
mod maps;
mod network;
mod rendered;
mod session;
mod setup;
pub mod trajectories;
mod video;
mod video_feed;

pub use error::Error;
pub use input::{Input, InputOptions};
pub use maps::{load_map, save_map, sha256, vocabulary};
pub use network::{NetworkOptions, load as load_network, open as open_network};
pub use session::{Session, SessionOptions};
pub use setup::extractor;
pub use video::is_camera;
