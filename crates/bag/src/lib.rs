//! ROS bags without ROS: rosbag2 folders (`.db3`, `.mcap`), MCAP files and ROS 1 `.bag` files.
//!
//! [`Bag::open`] goes through a bag once and keeps, of each image, its stamp and where it lies; [`Bag::image`] reads one image at a
//! time. Memory grows by a few bytes per image and holds one chunk of the file, whatever its size. Damaged bags are read as far as
//! they go, and [`Bag::remarks`] says how far that is. [`out`] writes poses and points as MCAP files.

mod bag;
mod choice;
mod error;
mod image;
mod mcap_file;
mod messages;
mod metadata;
pub mod out;
mod ros1_file;
mod sqlite_file;
mod storage;
mod topic;
mod wire;

pub use bag::{Bag, PoseStream, Stamp};
pub use choice::{Choice, Role, Roles, choose};
pub use error::BagError;
pub use image::Picture;
pub use messages::{CameraInfo, StampedTransform};
pub use metadata::is_bag;
pub use topic::{Kind, Topic};
