//! The file of a run that is over: final poses and points.

use std::path::Path;

use bag::out::CloudPoint;
use features::Rig;
use geometry::{PoseCovariance, SE3};
use io::{Clock, FileError, Sensor};
use map::{KeyframeId, Map, MapPoint};
use runtime::FrameRecord;

use super::sink::{Moment, Motion, Sink};
use crate::submaps::{of_submap, submaps};
use crate::trajectories::own_pose;

/// A frame with its final pose.
#[derive(Clone, Debug, PartialEq)]
pub struct FinalFrame {
    /// Nanoseconds.
    pub t_ns: i64,
    /// The left camera.
    pub world_from_cam: SE3,
    /// `None`: not known, or that of the map's first frame.
    pub covariance: Option<PoseCovariance>,
}

/// What a file of results holds: one sub-map.
#[derive(Clone, Debug, Default)]
pub struct McapResults {
    /// By time.
    pub frames: Vec<FinalFrame>,
    /// Whether the frames follow each other as the camera took them, so that there are velocities.
    pub has_motion: bool,
    /// Points along the axes of the camera.
    pub points: Vec<CloudPoint>,
    /// The camera, if it is known.
    pub camera: Option<(Sensor, Rig)>,
}

/// Writes final poses and points; the map takes no more corrections, so that `odom` is `map`.
///
/// # Errors
/// A file that cannot be written.
pub fn write_results(path: &Path, results: &McapResults) -> Result<(), FileError> {
    const MAP: &str = "map";
    let mut sink = Sink::create(path)?;
    let mut last: Option<&FinalFrame> = None;
    let [first, end] =
        [results.frames.first(), results.frames.last()].map(|frame| frame.map_or(0, |f| f.t_ns));
    if let Some((sensor, rig)) = &results.camera {
        sink.cameras(first, *sensor, rig)?;
    }
    for frame in &results.frames {
        let motion = last.filter(|last| results.has_motion && last.t_ns < frame.t_ns).map(|last| Motion {
            seconds: (frame.t_ns - last.t_ns) as f64 * 1e-9,
            last_from_cam: last.world_from_cam.inverse() * frame.world_from_cam,
            last_covariance: last.covariance,
        });
        let (map_from_odom, odom_from_cam) = (SE3::identity(), frame.world_from_cam);
        let covariance = frame.covariance;
        sink.moment(&Moment {
            t_ns: frame.t_ns,
            map: MAP,
            map_from_odom,
            odom_from_cam,
            covariance,
            motion,
        })?;
        last = Some(frame);
    }
    if !results.frames.is_empty() {
        sink.path(end, MAP, results.frames.iter().map(|frame| (frame.t_ns, frame.world_from_cam)))?;
    }
    if !results.points.is_empty() {
        sink.points(end, MAP, results.points.iter().copied())?;
    }
    sink.finish()
}

/// The frames with a pose of each sub-map, the largest first.
pub(crate) fn final_frames(
    records: &[FrameRecord],
    clock: &Clock,
) -> Vec<(Option<KeyframeId>, Vec<FinalFrame>)> {
    let frame = |record: &FrameRecord| {
        let world_from_cam = own_pose(record)?;
        let t_ns = clock.nanoseconds(record.timestamp_s);
        Some(FinalFrame { t_ns, world_from_cam, covariance: record.assessment.covariance })
    };
    let of = |submap: crate::submaps::Submap| {
        (submap.root, of_submap(records, submap).iter().filter_map(frame).collect())
    };
    submaps(records).into_iter().map(of).collect()
}

/// A point of a map as one of the cloud, along the axes of the camera.
pub fn cloud_point(map: &Map, point: &MapPoint, color: [u8; 3]) -> CloudPoint {
    CloudPoint {
        position: point.position,
        color,
        activation: map.activation(point),
        trust: point.trust() as f32,
        observations: u32::try_from(point.n_observations()).unwrap_or(u32::MAX),
    }
}
