//! The topics of a bag.

/// What the messages of a topic are, as far as this crate reads them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `sensor_msgs/Image`.
    Image,
    /// `sensor_msgs/CompressedImage`.
    CompressedImage,
    /// `sensor_msgs/CameraInfo`.
    CameraInfo,
    /// `sensor_msgs/Imu`: counted only.
    Imu,
    /// `nav_msgs/Odometry`.
    Odometry,
    /// `geometry_msgs/PoseStamped`.
    PoseStamped,
    /// `geometry_msgs/TransformStamped`.
    TransformStamped,
    /// `tf2_msgs/TFMessage`, `tf/tfMessage`.
    Transforms,
    /// Anything else.
    Other,
}

impl Kind {
    /// By the type's name, as ROS 1 or ROS 2 writes it.
    pub(crate) fn of(type_name: &str) -> Self {
        match type_name.replace("/msg/", "/").as_str() {
            "sensor_msgs/Image" => Kind::Image,
            "sensor_msgs/CompressedImage" => Kind::CompressedImage,
            "sensor_msgs/CameraInfo" => Kind::CameraInfo,
            "sensor_msgs/Imu" => Kind::Imu,
            "nav_msgs/Odometry" => Kind::Odometry,
            "geometry_msgs/PoseStamped" => Kind::PoseStamped,
            "geometry_msgs/TransformStamped" => Kind::TransformStamped,
            "tf2_msgs/TFMessage" | "tf/tfMessage" => Kind::Transforms,
            _ => Kind::Other,
        }
    }

    /// Whether its messages are images.
    pub fn is_image(self) -> bool {
        matches!(self, Kind::Image | Kind::CompressedImage)
    }

    /// Whether its messages hold poses.
    pub fn has_poses(self) -> bool {
        matches!(self, Kind::Odometry | Kind::PoseStamped | Kind::TransformStamped | Kind::Transforms)
    }
}

/// A topic.
#[derive(Clone, Debug, PartialEq)]
pub struct Topic {
    /// Its name, such as `/cam0/image_raw`.
    pub name: String,
    /// The type of its messages, as the bag names it.
    pub type_name: String,
    /// What that is.
    pub kind: Kind,
    /// Messages that could be read.
    pub count: usize,
    /// Stamps of the first and the last message, nanoseconds: that of the header where the message has one that is read here, else the time of
    /// recording.
    pub span_ns: Option<(i64, i64)>,
    /// Encoding of its images, such as `mono8`, or their format.
    pub encoding: Option<String>,
    /// Width and height of its raw images, pixels.
    pub size: Option<(u32, u32)>,
}

impl Topic {
    pub(crate) fn new(name: String, type_name: String) -> Self {
        let kind = Kind::of(&type_name);
        Topic { name, type_name, kind, count: 0, span_ns: None, encoding: None, size: None }
    }

    pub(crate) fn count(&mut self, t_ns: i64) {
        self.count += 1;
        self.span_ns = Some(match self.span_ns {
            None => (t_ns, t_ns),
            Some((first, last)) => (first.min(t_ns), last.max(t_ns)),
        });
    }

    /// Whether it has images.
    pub(crate) fn has_images(&self) -> bool {
        self.kind.is_image() && self.count > 0
    }

    /// Messages per second; `None` for fewer than two.
    pub fn rate_hz(&self) -> Option<f64> {
        let (first, last) = self.span_ns?;
        let seconds = last.checked_sub(first)? as f64 * 1e-9;
        (self.count > 1 && seconds > 0.0).then(|| (self.count - 1) as f64 / seconds)
    }
}
