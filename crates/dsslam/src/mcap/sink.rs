//! The file with its topics: from poses in the axes of the camera to messages.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use bag::out::{
    CameraDescription, Cloud, CloudPoint, Header, McapWriter, Message, Odometry, Pose, PoseWithCovariance,
    Transform, Transforms,
};
use features::Rig;
use geometry::{Mat6, PoseCovariance, SE3, SO3, Vec3};
use io::{FileError, Sensor};

use super::axes;

const ODOM: &str = "odom";
const BASE: &str = "base_link";
const CAMERA: &str = "camera_optical_frame";

/// A file that is written.
#[derive(Debug)]
pub(super) struct Sink {
    path: PathBuf,
    writer: McapWriter<BufWriter<File>>,
}

/// A frame with a pose; all poses have the axes of the camera.
#[derive(Clone, Debug)]
pub(super) struct Moment<'a> {
    pub(super) t_ns: i64,
    /// The frame of its sub-map.
    pub(super) map: &'a str,
    pub(super) map_from_odom: SE3,
    pub(super) odom_from_cam: SE3,
    /// Along and about the axes of the camera.
    pub(super) covariance: Option<PoseCovariance>,
    pub(super) motion: Option<Motion>,
}

/// How the camera came from the frame before.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    pub(super) seconds: f64,
    pub(super) last_from_cam: SE3,
    /// Of the pose before, along and about the axes of the camera then.
    pub(super) last_covariance: Option<PoseCovariance>,
}

/// Velocities along and about the axes of the body, with their covariance.
#[derive(Default)]
struct Twist {
    linear: Vec3,
    angular: Vec3,
    covariance: Mat6,
}

impl Motion {
    /// The mean velocities since the frame before. Their covariance is that of the two poses as if these erred on their own, which is more
    /// than the truth, since both were found in the same map.
    fn twist(&self, covariance: Option<&PoseCovariance>) -> Twist {
        let cam_from_last = self.last_from_cam.inverse();
        let moved = -cam_from_last.translation / self.seconds;
        let turned = self.last_from_cam.rotation.log() / self.seconds;
        let of_motion = covariance.zip(self.last_covariance.as_ref()).and_then(|(now, last)| {
            let both = now.in_camera() + last.of_body(&cam_from_last).in_camera();
            PoseCovariance::new(both / (self.seconds * self.seconds))
        });
        let covariance = of_motion.map_or_else(Mat6::zeros, |of| axes::covariance(&of, &SO3::identity()));
        Twist { linear: axes::vector(&moved), angular: axes::vector(&turned), covariance }
    }
}

impl Sink {
    /// Begins a file.
    pub(super) fn create(path: &Path) -> Result<Self, FileError> {
        let writer = File::create(path).and_then(|file| McapWriter::new(BufWriter::new(file)));
        let writer = writer.map_err(|error| unwritable(path, &error))?;
        Ok(Self { path: path.to_path_buf(), writer })
    }

    fn write<M: Message>(&mut self, topic: &str, t_ns: i64, message: &M) -> Result<(), FileError> {
        self.writer.write(topic, t_ns, message).map_err(|error| unwritable(&self.path, &error))
    }

    /// Odometry, pose and transforms of a frame.
    pub(super) fn moment(&mut self, of: &Moment<'_>) -> Result<(), FileError> {
        let t_ns = of.t_ns;
        let map_from_cam = of.map_from_odom * of.odom_from_cam;
        let covariance = |parent_from_cam: &SE3| {
            of.covariance.map_or_else(Mat6::zeros, |c| axes::covariance(&c, &parent_from_cam.rotation))
        };
        let twist = of.motion.as_ref().map(|motion| motion.twist(of.covariance.as_ref())).unwrap_or_default();
        let [in_map, in_odom, in_base] = [of.map, ODOM, BASE].map(|frame| Header { t_ns, frame });
        let base_in_odom = axes::pose(&of.odom_from_cam);
        let odometry = Odometry {
            header: in_odom.clone(),
            child: BASE,
            pose: base_in_odom,
            covariance: covariance(&of.odom_from_cam),
            linear: twist.linear,
            angular: twist.angular,
            twist_covariance: twist.covariance,
        };
        self.write("/odometry", t_ns, &odometry)?;
        let pose = PoseWithCovariance {
            header: in_map.clone(),
            pose: axes::pose(&map_from_cam),
            covariance: covariance(&map_from_cam),
        };
        self.write("/pose", t_ns, &pose)?;
        let link = |header, child, pose| Transform { header, child, pose };
        let transforms = [
            link(in_map, ODOM, axes::pose(&of.map_from_odom)),
            link(in_odom, BASE, base_in_odom),
            link(in_base, CAMERA, axes::optical_in_body()),
        ];
        self.write("/tf", t_ns, &Transforms(transforms.to_vec()))
    }

    /// All poses so far: time and `map_from_cam`.
    pub(super) fn path(
        &mut self,
        t_ns: i64,
        map: &str,
        poses: impl Iterator<Item = (i64, SE3)>,
    ) -> Result<(), FileError> {
        let poses: Vec<(i64, Pose)> = poses.map(|(t_ns, pose)| (t_ns, axes::pose(&pose))).collect();
        self.write("/path", t_ns, &bag::out::Path { header: Header { t_ns, frame: map }, poses })
    }

    /// Points of the map, given along the axes of the camera.
    pub(super) fn points(
        &mut self,
        t_ns: i64,
        map: &str,
        points: impl Iterator<Item = CloudPoint>,
    ) -> Result<(), FileError> {
        let turned = |point: CloudPoint| CloudPoint { position: axes::vector(&point.position), ..point };
        let cloud = Cloud { header: Header { t_ns, frame: map }, points: points.map(turned).collect() };
        self.write("/map_points", t_ns, &cloud)
    }

    /// The camera, or both.
    pub(super) fn cameras(&mut self, t_ns: i64, sensor: Sensor, rig: &Rig) -> Result<(), FileError> {
        let (pinhole, lens) = (&rig.stereo.camera, &rig.distortion);
        let size = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let left = CameraDescription {
            header: Header { t_ns, frame: CAMERA },
            size: (size(rig.width), size(rig.height)),
            distortion: [lens.k1, lens.k2, lens.p1, lens.p2, lens.k3],
            intrinsics: [pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy],
            baseline_m: 0.0,
        };
        self.write("/camera_info", t_ns, &left)?;
        if sensor != Sensor::Stereo {
            return Ok(());
        }
        // In the frame of the left camera, too: its place stands in the projection.
        let right = CameraDescription { baseline_m: rig.stereo.baseline_m, ..left };
        self.write("/right/camera_info", t_ns, &right)
    }

    /// Makes everything up to here readable.
    pub(super) fn flush(&mut self) -> Result<(), FileError> {
        self.writer.flush().map_err(|error| unwritable(&self.path, &error))
    }

    /// Ends the file.
    pub(super) fn finish(self) -> Result<(), FileError> {
        self.writer.finish().map(drop).map_err(|error| unwritable(&self.path, &error))
    }
}

fn unwritable(path: &Path, error: &std::io::Error) -> FileError {
    FileError::Unwritable { path: path.to_path_buf(), reason: error.to_string() }
}
