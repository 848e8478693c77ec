//! Trajectory and map as an MCAP file that ROS 2 and Foxglove read: while a run goes on ([`McapRecorder`]), or of its results
//! ([`write_results`]).
//!
//! | topic | type | what |
//! |---|---|---|
//! | `/odometry` | `nav_msgs/msg/Odometry` | `base_link` in `odom`, with covariances: never jumps |
//! | `/pose` | `geometry_msgs/msg/PoseWithCovarianceStamped` | `base_link` in `map`: jumps where the map is corrected |
//! | `/tf` | `tf2_msgs/msg/TFMessage` | `map` -> `odom` -> `base_link` -> `camera_optical_frame` |
//! | `/path` | `nav_msgs/msg/Path` | all poses so far in `map`, as the map has them now |
//! | `/map_points` | `sensor_msgs/msg/PointCloud2` | the points of the map: position, color, activation, trust, observations |
//! | `/camera_info`, `/right/camera_info` | `sensor_msgs/msg/CameraInfo` | the cameras, once |
//!
//! `map`, `odom` and `base_link` are turned as REP-103 has it: x forward, y left, z up, at the first frame. `base_link` lies in the
//! center of the left camera, whose own axes (x right, y down, z forward) are those of `camera_optical_frame`. Frames are related as REP-105
//! has it: `odom` -> `base_link` is made of motions from frame to frame and never jumps, `map` -> `odom` takes the corrections.
//! A covariance of zeros is none: of the frame that a map starts with, and of poses that nobody has a covariance for.

mod axes;
mod live;
mod names;
mod results;
mod shades;
mod sink;

pub use bag::out::CloudPoint;
pub use live::McapRecorder;
pub(crate) use results::final_frames;
pub use results::{FinalFrame, McapResults, cloud_point, write_results};
