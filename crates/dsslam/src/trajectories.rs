//! From the records of a run to the trajectories that are written and evaluated.

use geometry::SE3;
use io::{Sensor, StampedPose, Trajectory};
use runtime::FrameRecord;

use crate::Error;

/// The frame's own pose `world_from_cam`: only of frames that were tracked.
pub fn own_pose(record: &FrameRecord) -> Option<SE3> {
    record.world_from_cam.filter(|_| record.status.has_pose())
}

/// A pose per frame. Frames without one of their own repeat the last one before them; before the first: identity.
pub fn pose_per_frame(records: &[FrameRecord]) -> Trajectory {
    let mut last = SE3::identity();
    let poses = records.iter().map(|record| {
        last = own_pose(record).unwrap_or(last);
        StampedPose { timestamp_s: record.timestamp_s, world_from_cam: last }
    });
    Trajectory { poses: poses.collect() }
}

/// The poses of the frames that have one of their own.
pub fn tracked_poses(records: &[FrameRecord]) -> Trajectory {
    let pose = |record: &FrameRecord| {
        Some(StampedPose { timestamp_s: record.timestamp_s, world_from_cam: own_pose(record)? })
    };
    Trajectory { poses: records.iter().filter_map(pose).collect() }
}

/// The records with the poses of the body in the place of the left camera's, `world_from_cam * body_from_left^-1` in the same
/// world; `None` where the camera is the body, and for one camera, whose map has no scale to measure the way to the body with.
pub fn body_records(
    records: &[FrameRecord],
    sensor: Sensor,
    body_from_left: &SE3,
) -> Option<Vec<FrameRecord>> {
    if !has_body(sensor, body_from_left) {
        return None;
    }
    let cam_from_body = body_from_left.inverse();
    let of_body = |record: &FrameRecord| FrameRecord {
        world_from_cam: record.world_from_cam.map(|world_from_cam| world_from_cam * cam_from_body),
        ..record.clone()
    };
    Some(records.iter().map(of_body).collect())
}

/// Whether there is a body other than the left camera, and a scale to measure the way to it with.
fn has_body(sensor: Sensor, body_from_left: &SE3) -> bool {
    sensor != Sensor::Mono && *body_from_left != SE3::identity()
}

/// The left camera in the body as a map's file tells it.
pub fn body_text(sensor: Sensor, body_from_left: &SE3) -> String {
    if !has_body(sensor, body_from_left) {
        return String::new();
    }
    body_from_left.rows_3x4().map(|number| number.to_string()).join(" ")
}

/// The left camera in the body, of a map's file; `None` where it states no body.
///
/// # Errors
/// A text that is not a pose.
pub fn body_of_text(text: &str) -> Result<Option<SE3>, Error> {
    let words: Vec<&str> = text.split_whitespace().collect();
    if words.is_empty() {
        return Ok(None);
    }
    let numbers = words.iter().map(|word| word.parse()).collect::<Result<Vec<f64>, _>>();
    let rows = numbers.ok().and_then(|numbers| <[f64; 12]>::try_from(numbers).ok());
    // Reading makes a rotation of what is nearly one.
    let is_rigid =
        |rows: &[f64; 12], pose: &SE3| rows.iter().zip(pose.rows_3x4()).all(|(a, b)| (a - b).abs() < 1e-6);
    let read = |rows: [f64; 12]| Some(SE3::from_rows_3x4(&rows)).filter(|pose| is_rigid(&rows, pose));
    let pose = rows.filter(|rows| rows.iter().all(|number| number.is_finite())).and_then(read);
    pose.map(Some).ok_or_else(|| Error::Body { found: text.to_owned() })
}

/// Poses of the body, from those of the left camera.
pub fn of_body(left: &Trajectory, body_from_left: &SE3) -> Trajectory {
    of_left_camera(left, &body_from_left.inverse())
}

/// Poses of the left camera, from those of the body.
pub fn of_left_camera(body: &Trajectory, body_from_left: &SE3) -> Trajectory {
    let of_left = |pose: &StampedPose| StampedPose {
        timestamp_s: pose.timestamp_s,
        world_from_cam: pose.world_from_cam * *body_from_left,
    };
    Trajectory { poses: body.poses.iter().map(of_left).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{SO3, Vec3};
    use runtime::{FrameStatus, Unusable};

    /// A frame at x = `x` meters, or a dropped one.
    fn record(index: u32, x: Option<f64>) -> FrameRecord {
        let world_from_cam = x.map(|x| SE3::new(SO3::identity(), Vec3::new(x, 0.0, 0.0)));
        let status = match x {
            Some(_) => FrameStatus::Tracked { inliers: 100 },
            None => FrameStatus::Dropped(Unusable::Missing("left")),
        };
        FrameRecord::new(index, f64::from(index) * 0.1, status, world_from_cam)
    }

    #[test]
    fn frames_without_a_pose_repeat_the_last_one_and_start_at_the_identity() {
        let mut records: Vec<FrameRecord> = [None, Some(1.0), None, None, Some(4.0)]
            .into_iter()
            .enumerate()
            .map(|(i, x)| record(i as u32, x))
            .collect();
        // A dropped frame that carries the last known pose has none of its own.
        records[2].world_from_cam = Some(SE3::new(SO3::identity(), Vec3::new(9.0, 0.0, 0.0)));
        let x = |t: &Trajectory| t.poses.iter().map(|p| p.world_from_cam.translation.x).collect::<Vec<_>>();
        assert_eq!(x(&pose_per_frame(&records)), [0.0, 1.0, 1.0, 1.0, 4.0]);
        assert_eq!(x(&tracked_poses(&records)), [1.0, 4.0]);
        assert_eq!(tracked_poses(&records).poses[1].timestamp_s, 0.4);
    }

    #[test]
    fn the_body_of_a_map_reads_back_as_it_was() {
        let body = SE3::new(SO3::exp(&Vec3::new(0.1, -1.2, 0.3)), Vec3::new(1.0 / 3.0, -2e-17, 5.0));
        let text = body_text(Sensor::Stereo, &body);
        let found = body_of_text(&text).unwrap().unwrap();
        assert!((found.matrix() - body.matrix()).amax() < 1e-14 && found.translation == body.translation);
        for (sensor, pose) in [(Sensor::Mono, &body), (Sensor::Stereo, &SE3::identity())] {
            assert_eq!(body_of_text(&body_text(sensor, pose)).unwrap(), None);
        }
        for wrong in
            ["1 2 3", "1 0 0 x 0 1 0 0 0 0 1 0", "2 0 0 0 0 1 0 0 0 0 1 0", "NaN 0 0 0 0 1 0 0 0 0 1 0"]
        {
            let message = body_of_text(wrong).unwrap_err().to_string();
            assert!(message.ends_with("expected the 12 numbers of a 3x4 pose"), "{message}");
        }
        let left = Trajectory { poses: vec![StampedPose { timestamp_s: 0.0, world_from_cam: body }] };
        let found = of_body(&left, &body).poses[0].world_from_cam;
        assert!(found.log().norm() < 1e-12, "the camera pose on the body places the body at the origin");
    }
}
