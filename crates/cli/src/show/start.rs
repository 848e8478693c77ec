//! The first record of a stream: what is going to be run.

use std::borrow::Cow;

use dsslam::trajectories::of_left_camera;
use eval::TIMESTAMP_TOLERANCE_S;
use events::{Camera, Start, TruePosition};
use geometry::SE3;
use io::{StampedPose, Trajectory};

use crate::job::Job;

/// The start of a job's stream.
pub(super) fn of_job(job: &Job) -> Start {
    let truth = truth(job);
    let rig = &job.session.setup().rig;
    let (sequence, camera) = (job.sequence(), &rig.stereo.camera);
    let size = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    Start {
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        sequence: sequence.name.clone(),
        sensor: sequence.sensor,
        camera: Camera {
            focal: [camera.fx, camera.fy],
            center: [camera.cx, camera.cy],
            size: [size(rig.width), size(rig.height)],
        },
        n_frames: job.session.input().feed().size_hint().map_or(u32::MAX, size),
        truth: truth.iter().map(|(frame, pose)| position(*frame, pose)).collect(),
    }
}

/// Where the camera truly was at a frame.
pub(super) fn position(frame: u32, pose: &StampedPose) -> TruePosition {
    TruePosition { frame, position: pose.world_from_cam.translation.into() }
}

/// True poses of the left camera at a job's frames, with the frames' times.
pub(crate) fn true_poses(job: &Job) -> Trajectory {
    Trajectory { poses: truth(job).into_iter().map(|(_, pose)| pose).collect() }
}

/// True poses of the left camera at a job's frames. Feeds whose length is not known have no ground truth.
fn truth(job: &Job) -> Vec<(u32, StampedPose)> {
    let (sequence, feed) = (job.sequence(), job.session.input().feed());
    let Some(body) = &sequence.ground_truth else { return Vec::new() };
    let info = (0..feed.size_hint().unwrap_or(0)).map(|i| feed.info(i));
    let frames: Vec<(u32, f64)> = info.map(|info| (info.index, info.timestamp_s)).collect();
    truth_of(&frames, body, &sequence.body_from_left)
}

/// True poses of the left camera at frames, given as number and time: of each the pose nearest in time.
fn truth_of(frames: &[(u32, f64)], body: &Trajectory, body_from_left: &SE3) -> Vec<(u32, StampedPose)> {
    let left = if *body_from_left == SE3::identity() {
        Cow::Borrowed(body)
    } else {
        Cow::Owned(of_left_camera(body, body_from_left))
    };
    let nearest = |&(frame, time): &(u32, f64)| {
        let nearest = left.find_nearest(time, TIMESTAMP_TOLERANCE_S)?;
        Some((frame, StampedPose { timestamp_s: time, ..*nearest }))
    };
    frames.iter().filter_map(nearest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{SO3, Vec3};

    #[test]
    fn each_frame_gets_the_pose_nearest_in_time_moved_to_the_left_camera() {
        let at = |timestamp_s: f64, x: f64| StampedPose {
            timestamp_s,
            world_from_cam: SE3::new(SO3::identity(), Vec3::new(x, 0.0, 0.0)),
        };
        let body = Trajectory { poses: vec![at(1.0, 10.0), at(1.005, 20.0), at(2.0, 30.0)] };
        let body_from_left = SE3::new(SO3::identity(), Vec3::new(0.0, 1.0, 0.0));
        let frames = [(4, 0.5), (5, 1.001), (6, 1.004), (7, 2.0), (8, 3.0)];
        let found = truth_of(&frames, &body, &body_from_left);
        let expected = [(5, 10.0), (6, 20.0), (7, 30.0)];
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, (frame, x)) in found.iter().zip(expected) {
            assert_eq!((found.0, found.1.world_from_cam.translation), (frame, Vec3::new(x, 1.0, 0.0)));
        }
        let none = Trajectory { poses: Vec::new() };
        assert!(truth_of(&frames, &none, &body_from_left).is_empty());
    }
}
