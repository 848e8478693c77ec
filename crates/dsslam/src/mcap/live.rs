//! Writes the file while a run goes on: an observer. Everything depends on the order of the frames alone, so that equal runs give equal
//! files, except with live schedules.

use std::path::Path;

use features::Rig;
use geometry::{PoseCovariance, SE3};
use io::{Clock, FileError, Sensor};
use map::{Keyframe, KeyframeId, Map, RelativePose};
use runtime::{Event, FrameAnswer, FrameDetails, Observer, RunOutcome};

use super::names::MapNames;
use super::results::final_frames;
use super::shades::Shades;
use super::sink::{Moment, Motion, Sink};
use crate::Session;

/// Frames after which what was written is made readable.
const FLUSH_EVERY: usize = 10;
/// A frame that is not a keyframe after this many further ones will not become one.
const KEYFRAME_WITHIN: usize = 100;
/// The path is written again when it has grown by this factor, and the points likewise, so that the file grows with the run and not with
/// its square.
const GROWTH: f64 = 1.1;

/// An observer that writes a run into an MCAP file, frame by frame. An interrupted file is readable up to its last ten frames.
#[derive(Debug)]
pub struct McapRecorder {
    /// `None` after the first error.
    sink: Option<Sink>,
    error: Option<FileError>,
    clock: Clock,
    sensor: Sensor,
    rig: Rig,
    names: MapNames,
    odom_from_cam: SE3,
    frames: Vec<Place>,
    /// Frames that may have become keyframes.
    asked: Vec<usize>,
    shades: Shades,
    written: Written,
}

/// A frame that was tracked.
#[derive(Debug)]
struct Place {
    t_ns: i64,
    index: u32,
    /// `None`: it starts a map, and its keyframe is not known yet.
    relative: Option<RelativePose>,
    covariance: Option<PoseCovariance>,
}

/// What path and points held when they were written last.
#[derive(Debug, Default)]
struct Written {
    poses: usize,
    points: usize,
    loop_edges: usize,
}

impl McapRecorder {
    /// Begins the file of a run.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn create(path: &Path, session: &Session) -> Result<Self, FileError> {
        Ok(Self {
            sink: Some(Sink::create(path)?),
            error: None,
            clock: session.input().clock().clone(),
            sensor: session.input().sequence().sensor,
            rig: (*session.setup().rig).clone(),
            names: MapNames::default(),
            odom_from_cam: SE3::identity(),
            frames: Vec::new(),
            asked: Vec::new(),
            shades: Shades::default(),
            written: Written::default(),
        })
    }

    /// Ends the file: the final path and points of each sub-map, those of the largest last, and the index.
    ///
    /// # Errors
    /// What could not be written, now or during the run.
    pub fn finish(mut self, outcome: &RunOutcome) -> Result<(), FileError> {
        self.guard(|recorder, sink| recorder.write_end(sink, outcome));
        match (self.sink.take(), self.error) {
            (_, Some(error)) => Err(error),
            (Some(sink), None) => sink.finish(),
            (None, None) => Ok(()),
        }
    }

    /// Writes something, unless something could not be written before.
    fn guard(&mut self, write: impl FnOnce(&mut Self, &mut Sink) -> Result<(), FileError>) {
        let Some(mut sink) = self.sink.take() else { return };
        match write(self, &mut sink) {
            Ok(()) => self.sink = Some(sink),
            Err(error) => self.error = Some(error),
        }
    }

    fn write_end(&mut self, sink: &mut Sink, outcome: &RunOutcome) -> Result<(), FileError> {
        let Some(t_ns) = self.frames.last().map(|place| place.t_ns) else { return Ok(()) };
        for (root, frames) in final_frames(&outcome.frames, &self.clock).into_iter().rev() {
            let name = self.names.of(root);
            sink.path(t_ns, &name, frames.iter().map(|frame| (frame.t_ns, frame.world_from_cam)))?;
            sink.points(t_ns, &name, self.shades.cloud(&outcome.map, root))?;
        }
        Ok(())
    }

    /// Writes a frame with a pose.
    fn write_frame(
        &mut self,
        sink: &mut Sink,
        world_from_cam: SE3,
        details: &FrameDetails,
    ) -> Result<(), FileError> {
        let (answer, map) = (&details.answer, &details.world.map);
        let t_ns = self.clock.nanoseconds(answer.timestamp_s);
        self.find_keyframes(map);
        let motion = self.motion(answer, t_ns);
        if let Some(motion) = &motion {
            self.odom_from_cam = (self.odom_from_cam * motion.last_from_cam).normalized();
        }
        if self.frames.is_empty() {
            sink.cameras(t_ns, self.sensor, &self.rig)?;
        }
        let name = self.names.of(answer.submap);
        let covariance = answer.assessment.covariance;
        sink.moment(&Moment {
            t_ns,
            map: &name,
            map_from_odom: world_from_cam * self.odom_from_cam.inverse(),
            odom_from_cam: self.odom_from_cam,
            covariance,
            motion,
        })?;
        if answer.keyframe.is_some() {
            self.asked.push(self.frames.len());
        }
        self.frames.push(Place { t_ns, index: answer.index, relative: details.pose, covariance });
        self.write_map(sink, map, (answer.submap, &name))?;
        if self.frames.len().is_multiple_of(FLUSH_EVERY) { sink.flush() } else { Ok(()) }
    }

    /// Frames that became keyframes get these as their poses.
    fn find_keyframes(&mut self, map: &Map) {
        let (frames, clock) = (&mut self.frames, &self.clock);
        let oldest = frames.len().saturating_sub(KEYFRAME_WITHIN);
        self.asked.retain(|&at| {
            let place = &mut frames[at];
            // A map from a file has frames of the same numbers.
            let is_it = |keyframe: &&Keyframe| {
                let frame = &keyframe.frame;
                frame.index == place.index && clock.nanoseconds(frame.timestamp_s) == place.t_ns
            };
            let found = map.keyframes().rev().find(is_it);
            if let Some(keyframe) = found {
                place.relative = Some(RelativePose::of_keyframe(keyframe.id));
            }
            found.is_none() && at >= oldest
        });
    }

    /// How the camera came from the last frame.
    fn motion(&self, answer: &FrameAnswer, t_ns: i64) -> Option<Motion> {
        let last = self.frames.last().filter(|last| last.t_ns < t_ns)?;
        let seconds = (t_ns - last.t_ns) as f64 * 1e-9;
        Some(Motion { seconds, last_from_cam: answer.last_from_cam?, last_covariance: last.covariance })
    }

    /// Path and points, where they have grown or a loop has moved them.
    fn write_map(
        &mut self,
        sink: &mut Sink,
        map: &Map,
        (submap, name): (Option<KeyframeId>, &str),
    ) -> Result<(), FileError> {
        let Some(t_ns) = self.frames.last().map(|place| place.t_ns).filter(|_| submap.is_some()) else {
            return Ok(());
        };
        let loop_edges = map.keyframes().map(|keyframe| keyframe.loop_edges().len()).sum();
        let is_bent = loop_edges != self.written.loop_edges;
        let is_due = |now: usize, before: usize| is_bent || now as f64 >= before as f64 * GROWTH;
        if is_due(self.frames.len(), self.written.poses) {
            let pose = |place: &Place| {
                let relative = place.relative?.on_living(map);
                let is_inside = map.submap_of(relative.keyframe) == submap;
                let cam_from_world = relative.cam_from_world(map).filter(|_| is_inside)?;
                Some((place.t_ns, cam_from_world.normalized().inverse()))
            };
            sink.path(t_ns, name, self.frames.iter().filter_map(pose))?;
            self.written.poses = self.frames.len();
        }
        if is_due(map.n_points(), self.written.points) {
            sink.points(t_ns, name, self.shades.cloud(map, submap))?;
            self.written.points = map.n_points();
        }
        self.written.loop_edges = loop_edges;
        Ok(())
    }
}

impl Observer for McapRecorder {
    fn wants_details(&self) -> bool {
        true
    }

    fn event(&mut self, event: &Event) {
        let Event::Details(details) = event else { return };
        self.shades.see(details);
        let answer = &details.answer;
        if let Some(world_from_cam) = answer.world_from_cam.filter(|_| answer.status.has_pose()) {
            self.guard(|recorder, sink| recorder.write_frame(sink, world_from_cam, details));
        }
    }
}
