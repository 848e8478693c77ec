//! Definitions of the messages in the encoding `ros2msg`, which a file has to bring along: each type with those that it is made of.
//!
//! Field names and types are those of ROS 2's packages `nav_msgs`, `geometry_msgs`, `sensor_msgs`, `tf2_msgs`, `std_msgs` and
//! `builtin_interfaces`.

/// A type that others are made of.
type Part = (&'static str, &'static str);

const TIME: Part = ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n");
const HEADER: Part = ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n");
const POINT: Part = ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n");
const VECTOR: Part = ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n");
const QUATERNION: Part = ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n");
const POSE: Part =
    ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n");
const POSE_STAMPED: Part = ("geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n");
const POSE_WITH_COVARIANCE: Part =
    ("geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n");
const TWIST: Part = ("geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n");
const TWIST_WITH_COVARIANCE: Part =
    ("geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n");
const TRANSFORM: Part =
    ("geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n");
const TRANSFORM_STAMPED: Part = (
    "geometry_msgs/TransformStamped",
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
);
const POINT_FIELD: Part = (
    "sensor_msgs/PointField",
    "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\n\
     uint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n",
);
const REGION: Part = (
    "sensor_msgs/RegionOfInterest",
    "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n",
);

/// A type of messages.
#[derive(Debug)]
pub struct Definition {
    /// Its name, such as `nav_msgs/msg/Odometry`.
    pub(super) name: &'static str,
    fields: &'static str,
    parts: &'static [Part],
}

impl Definition {
    /// The whole text: the fields, then each part under its name.
    pub(super) fn text(&self) -> String {
        const LINE: &str =
            "================================================================================\n";
        let parts = self.parts.iter().map(|(name, fields)| format!("{LINE}MSG: {name}\n{fields}"));
        self.fields.to_owned() + &parts.collect::<String>()
    }
}

pub(super) const ODOMETRY: Definition = Definition {
    name: "nav_msgs/msg/Odometry",
    fields: "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
             geometry_msgs/TwistWithCovariance twist\n",
    parts: &[
        HEADER,
        TIME,
        POSE_WITH_COVARIANCE,
        POSE,
        POINT,
        QUATERNION,
        TWIST_WITH_COVARIANCE,
        TWIST,
        VECTOR,
    ],
};
pub(super) const POSE_WITH_COVARIANCE_STAMPED: Definition = Definition {
    name: "geometry_msgs/msg/PoseWithCovarianceStamped",
    fields: "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n",
    parts: &[HEADER, TIME, POSE_WITH_COVARIANCE, POSE, POINT, QUATERNION],
};
pub(super) const PATH: Definition = Definition {
    name: "nav_msgs/msg/Path",
    fields: "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n",
    parts: &[HEADER, TIME, POSE_STAMPED, POSE, POINT, QUATERNION],
};
pub(super) const POINT_CLOUD: Definition = Definition {
    name: "sensor_msgs/msg/PointCloud2",
    fields: "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n\
             uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
    parts: &[HEADER, TIME, POINT_FIELD],
};
pub(super) const TRANSFORMS: Definition = Definition {
    name: "tf2_msgs/msg/TFMessage",
    fields: "geometry_msgs/TransformStamped[] transforms\n",
    parts: &[TRANSFORM_STAMPED, HEADER, TIME, TRANSFORM, VECTOR, QUATERNION],
};
pub(super) const CAMERA_INFO: Definition = Definition {
    name: "sensor_msgs/msg/CameraInfo",
    fields: "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\n\
             float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n",
    parts: &[HEADER, TIME, REGION],
};
