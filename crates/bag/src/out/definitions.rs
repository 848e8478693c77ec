//! Definitions of the messages in the encoding `ros2msg`, which a file has to bring along: each type with those that it is made of.
//!
//! Field names and types are those of ROS 2's packages `nav_msgs`, `geometry_msgs`, `sensor_msgs`, `tf2_msgs`, `std_msgs` and
//! `builtin_interfaces`.

/// A type of messages.
#[derive(Debug)]
pub struct Definition {
    /// Its name, such as `nav_msgs/msg/Odometry`.
    pub(super) name: &'static str,
    /// The fields, then each type that they are made of under its name.
    pub(super) text: &'static str,
}

macro_rules! definition {
    ($package:literal, $type:literal) => {
        Definition {
            name: concat!($package, "/msg/", $type),
            text: include_str!(concat!("definitions/", $type, ".msg")),
        }
    };
}

pub(super) const ODOMETRY: Definition = definition!("nav_msgs", "Odometry");
pub(super) const POSE_WITH_COVARIANCE_STAMPED: Definition =
    definition!("geometry_msgs", "PoseWithCovarianceStamped");
pub(super) const PATH: Definition = definition!("nav_msgs", "Path");
pub(super) const POINT_CLOUD: Definition = definition!("sensor_msgs", "PointCloud2");
pub(super) const TRANSFORMS: Definition = definition!("tf2_msgs", "TFMessage");
pub(super) const CAMERA_INFO: Definition = definition!("sensor_msgs", "CameraInfo");
