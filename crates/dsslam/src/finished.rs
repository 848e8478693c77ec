//! What a run leaves: trajectory, map, loops, and the map's file.

use std::path::Path;

use features::Rig;
use geometry::SE3;
use io::{Clock, Sensor, Trajectory};
use map::MapFileInfo;
use runtime::{RunOutcome, Setup};

use crate::intake::Intake;
use crate::{Error, maps, mcap, submaps, trajectories};

/// The results of a run.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Finished {
    /// Frames with their final poses, map, loops, statistics and times.
    pub outcome: RunOutcome,
    /// Pose of the left camera in the body; the identity where the camera is the body.
    pub body_from_left: SE3,
    /// The stamps of the frames and of the start map, exactly as they were read.
    pub clock: Clock,
    /// What goes into the map's file beside the map.
    info: MapFileInfo,
    rig: Rig,
}

impl Finished {
    pub(crate) fn new(outcome: RunOutcome, intake: &Intake, setup: &Setup, clock: Clock) -> Self {
        let sequence = &intake.sequence;
        let vocabulary = setup.vocabulary.as_ref();
        let info = MapFileInfo {
            sensor: Some(sequence.sensor),
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            sequence: sequence.name.clone(),
            configuration: intake.config.to_yaml(),
            vocabulary_sha256: vocabulary.map_or(String::new(), |words| maps::sha256(words.as_bytes())),
            body_from_left: trajectories::body_text(sequence.sensor, &sequence.body_from_left),
            stamps_ns: clock
                .beyond_doubles(outcome.map.keyframes().map(|keyframe| keyframe.frame.timestamp_s)),
        };
        let rig = (*setup.rig).clone();
        Self { outcome, body_from_left: sequence.body_from_left, clock, info, rig }
    }

    /// Poses `world_from_cam` of the left camera at the frames that were tracked, after all corrections of the map; meters, of
    /// one camera in the map's own unit. Where the run has several sub-maps, those of the largest.
    pub fn trajectory(&self) -> Trajectory {
        trajectories::tracked_poses(&submaps::of_largest(&self.outcome.frames))
    }

    /// As [`Finished::trajectory`], one for each sub-map, the largest first: they are in unrelated coordinate frames.
    pub fn trajectories(&self) -> Vec<Trajectory> {
        let frames = &self.outcome.frames;
        let of = |submap| trajectories::tracked_poses(&submaps::of_submap(frames, submap));
        submaps::submaps(frames).into_iter().map(of).collect()
    }

    /// As [`Finished::trajectory`], of the body where the cameras have one, such as the inertial unit of a EuRoC folder.
    pub fn body_trajectory(&self) -> Trajectory {
        let sensor = self.info.sensor.unwrap_or(Sensor::Mono);
        let frames = submaps::of_largest(&self.outcome.frames);
        match trajectories::body_records(&frames, sensor, &self.body_from_left) {
            Some(records) => trajectories::tracked_poses(&records),
            None => self.trajectory(),
        }
    }

    /// Writes final poses and points as an MCAP file for ROS 2 and Foxglove, see [`mcap`]. Where the run has several sub-maps, those
    /// of the largest. Points are green where they stand still, red where they move or look like others.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save_mcap(&self, file: impl AsRef<Path>) -> Result<(), Error> {
        let outcome = &self.outcome;
        let (root, frames) =
            mcap::final_frames(&outcome.frames, &self.clock).into_iter().next().unwrap_or_default();
        let is_inside = |point: &&map::MapPoint| outcome.map.submap_of(point.reference) == root;
        let point = |point: &map::MapPoint| {
            let green = (point.trust() * 255.0).round() as u8;
            mcap::cloud_point(&outcome.map, point, [255 - green, green, 0])
        };
        let points = outcome.map.points().filter(is_inside).map(point).collect();
        let camera = self.info.sensor.map(|sensor| (sensor, self.rig.clone()));
        let results = mcap::McapResults { frames, has_motion: true, points, camera };
        Ok(mcap::write_results(file.as_ref(), &results)?)
    }

    /// Writes the map whole or not at all; returns the SHA-256 of its file, hexadecimal.
    ///
    /// # Errors
    /// A file that cannot be written; an older one is then untouched.
    pub fn save_map(&self, file: impl AsRef<Path>) -> Result<String, Error> {
        maps::save_map(file.as_ref(), &self.outcome.map, &self.info)
    }
}
