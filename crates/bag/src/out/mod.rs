//! MCAP files as ROS 2 writes them, from poses and points: no ROS is needed to write or to read them.

mod cdr;
mod definitions;
mod held;
mod messages;
mod writer;

pub use cdr::Cdr;
pub use definitions::Definition;
pub use messages::{
    CameraDescription, Cloud, CloudPoint, Header, Message, Odometry, Path, Pose, PoseWithCovariance,
    Transform, Transforms,
};
pub use writer::McapWriter;
