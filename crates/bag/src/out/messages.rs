//! The messages that are written, field by field.

use geometry::{Mat6, Vec3};

use super::cdr::Cdr;
use super::definitions::{self, Definition};

/// A message that a file can hold.
pub trait Message {
    /// Its type.
    const DEFINITION: Definition;

    /// Its fields, one after another.
    fn encode(&self, to: &mut Cdr);
}

/// When and in which frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Header<'a> {
    /// Nanoseconds.
    pub t_ns: i64,
    /// The frame that the message is in.
    pub frame: &'a str,
}

/// A pose of a child frame in a parent frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Origin of the child, meters.
    pub position: Vec3,
    /// Rotation `parent_from_child` as a unit quaternion: x, y, z, w.
    pub quaternion: [f64; 4],
}

/// `nav_msgs/Odometry`: covariances of x, y, z and of the rotations about x, y, z; zero where they are not known.
#[derive(Clone, Debug, PartialEq)]
pub struct Odometry<'a> {
    /// The parent frame.
    pub header: Header<'a>,
    /// The child frame.
    pub child: &'a str,
    /// The child in the parent.
    pub pose: Pose,
    /// Along and about the axes of the parent, square meters and square radians.
    pub covariance: Mat6,
    /// Velocity along the axes of the child, meters a second.
    pub linear: Vec3,
    /// Angular velocity about the axes of the child, radians a second.
    pub angular: Vec3,
    /// Covariance of both, along and about the axes of the child.
    pub twist_covariance: Mat6,
}

/// `geometry_msgs/PoseWithCovarianceStamped`.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseWithCovariance<'a> {
    /// The parent frame.
    pub header: Header<'a>,
    /// The child in the parent.
    pub pose: Pose,
    /// As in [`Odometry`].
    pub covariance: Mat6,
}

/// `nav_msgs/Path`.
#[derive(Clone, Debug, PartialEq)]
pub struct Path<'a> {
    /// The parent frame.
    pub header: Header<'a>,
    /// Poses with their times, nanoseconds.
    pub poses: Vec<(i64, Pose)>,
}

/// A point of a [`Cloud`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudPoint {
    /// Meters.
    pub position: Vec3,
    /// Red, green, blue.
    pub color: [u8; 3],
    /// Mean activation of the features that show it, 0 to 1; 1 where no network selects.
    pub activation: f32,
    /// Probability that it stands still, of all that was seen of it.
    pub trust: f32,
    /// How many keyframes see it.
    pub observations: u32,
}

/// `sensor_msgs/PointCloud2` with the fields x, y, z, rgb (a float whose bits are 0x00RRGGBB), activation, trust and
/// observations.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud<'a> {
    /// The frame of the positions.
    pub header: Header<'a>,
    /// The points.
    pub points: Vec<CloudPoint>,
}

/// A `geometry_msgs/TransformStamped`.
#[derive(Clone, Debug, PartialEq)]
pub struct Transform<'a> {
    /// The parent frame.
    pub header: Header<'a>,
    /// The child frame.
    pub child: &'a str,
    /// The child in the parent.
    pub pose: Pose,
}

/// `tf2_msgs/TFMessage`.
#[derive(Clone, Debug, PartialEq)]
pub struct Transforms<'a>(pub Vec<Transform<'a>>);

/// `sensor_msgs/CameraInfo` of a camera that is rectified, or at least not turned.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraDescription<'a> {
    /// The camera's optical frame.
    pub header: Header<'a>,
    /// Width and height, pixels.
    pub size: (u32, u32),
    /// k1, k2, p1, p2, k3.
    pub distortion: [f64; 5],
    /// fx, fy, cx, cy, pixels.
    pub intrinsics: [f64; 4],
    /// How far the camera is to the right of the left one, meters.
    pub baseline_m: f64,
}

const SECOND: i64 = 1_000_000_000;

impl Header<'_> {
    fn encode(&self, to: &mut Cdr) {
        // The writer refuses other times.
        to.i32(i32::try_from(self.t_ns.div_euclid(SECOND)).unwrap_or(i32::MAX));
        to.u32(self.t_ns.rem_euclid(SECOND) as u32);
        to.text(self.frame);
    }
}

impl Pose {
    fn encode(&self, to: &mut Cdr) {
        to.numbers(self.position.iter().copied());
        to.numbers(self.quaternion);
    }
}

/// Row by row.
fn matrix(to: &mut Cdr, matrix: &Mat6) {
    to.numbers(matrix.transpose().iter().copied());
}

impl Message for Odometry<'_> {
    const DEFINITION: Definition = definitions::ODOMETRY;

    fn encode(&self, to: &mut Cdr) {
        self.header.encode(to);
        to.text(self.child);
        self.pose.encode(to);
        matrix(to, &self.covariance);
        to.numbers(self.linear.iter().copied());
        to.numbers(self.angular.iter().copied());
        matrix(to, &self.twist_covariance);
    }
}

impl Message for PoseWithCovariance<'_> {
    const DEFINITION: Definition = definitions::POSE_WITH_COVARIANCE_STAMPED;

    fn encode(&self, to: &mut Cdr) {
        self.header.encode(to);
        self.pose.encode(to);
        matrix(to, &self.covariance);
    }
}

impl Message for Path<'_> {
    const DEFINITION: Definition = definitions::PATH;

    fn encode(&self, to: &mut Cdr) {
        self.header.encode(to);
        to.count(self.poses.len());
        for &(t_ns, pose) in &self.poses {
            Header { t_ns, ..self.header.clone() }.encode(to);
            pose.encode(to);
        }
    }
}

impl Message for Cloud<'_> {
    const DEFINITION: Definition = definitions::POINT_CLOUD;

    fn encode(&self, to: &mut Cdr) {
        const FLOAT32: u8 = 7;
        const UINT32: u8 = 6;
        const FIELDS: [(&str, u8); 7] = [
            ("x", FLOAT32),
            ("y", FLOAT32),
            ("z", FLOAT32),
            ("rgb", FLOAT32),
            ("activation", FLOAT32),
            ("trust", FLOAT32),
            ("observations", UINT32),
        ];
        const STEP: u32 = 4 * FIELDS.len() as u32;
        self.header.encode(to);
        to.u32(1);
        to.count(self.points.len());
        to.count(FIELDS.len());
        for (i, (name, kind)) in (0..).zip(FIELDS) {
            to.text(name);
            to.u32(4 * i);
            to.u8(kind);
            to.u32(1);
        }
        to.bool(false);
        to.u32(STEP);
        to.count(self.points.len() * STEP as usize);
        let mut data = Vec::with_capacity(self.points.len() * STEP as usize);
        for point in &self.points {
            point.position.iter().for_each(|&value| data.extend((value as f32).to_le_bytes()));
            let [r, g, b] = point.color;
            data.extend([b, g, r, 0]);
            data.extend(point.activation.to_le_bytes());
            data.extend(point.trust.to_le_bytes());
            data.extend(point.observations.to_le_bytes());
        }
        to.blob(&data);
        to.bool(true);
    }
}

impl Message for Transforms<'_> {
    const DEFINITION: Definition = definitions::TRANSFORMS;

    fn encode(&self, to: &mut Cdr) {
        to.count(self.0.len());
        for transform in &self.0 {
            transform.header.encode(to);
            to.text(transform.child);
            transform.pose.encode(to);
        }
    }
}

impl Message for CameraDescription<'_> {
    const DEFINITION: Definition = definitions::CAMERA_INFO;

    fn encode(&self, to: &mut Cdr) {
        let [fx, fy, cx, cy] = self.intrinsics;
        self.header.encode(to);
        to.u32(self.size.1);
        to.u32(self.size.0);
        to.text("plumb_bob");
        to.count(self.distortion.len());
        to.numbers(self.distortion);
        to.numbers([fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]);
        to.numbers([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        to.numbers([fx, 0.0, cx, 0.0 - fx * self.baseline_m, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]);
        // Binning and region of interest: none.
        (0..6).for_each(|_| to.u32(0));
        to.bool(false);
    }
}
