//! SLAM by pushing images: each call gives a pose.

use std::fmt;
use std::sync::Arc;

use io::{Clock, LoadedFrame, Sensor};
use runtime::{FrameAnswer, FrameInfo, FrameMask, RunEnded, Schedule, Sequential, Setup, Silent, Threaded};

use crate::error::FrameProblem;
use crate::intake::Intake;
use crate::{Camera, Config, Error, Finished, Images, SlamOptions};

/// SLAM on images that are pushed one frame after another.
///
/// With the schedules `Lockstep` (the default, on threads of its own) and `Sequential` (on the caller's thread) equal frames,
/// configuration and seed give equal bits, those of [`Session::run`](crate::Session::run) on the same frames. With `Live` mapping
/// never holds up tracking.
///
/// A known error of the stereo calibration goes into `stereo.disparity_offset_px`.
///
/// An inertial sensor and further cameras have their places beside [`Slam::track`] and [`Images`], a covariance in
/// [`FrameAnswer`]; there are none yet.
pub struct Slam {
    intake: Intake,
    setup: Setup,
    engine: Engine,
    /// Stamps of the start map, nanoseconds.
    map_stamps: Vec<i64>,
    /// Stamps of the frames, nanoseconds.
    stamps: Vec<i64>,
}

/// What the frames go through.
enum Engine {
    Here(Box<Sequential>),
    Threads(Threaded),
}

impl fmt::Debug for Slam {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (sensor, schedule) = (self.intake.sequence.sensor, self.setup.schedule);
        f.debug_struct("Slam")
            .field("sensor", &sensor)
            .field("schedule", &schedule)
            .field("n_frames", &self.stamps.len())
            .finish_non_exhaustive()
    }
}

impl Engine {
    fn start(setup: &Setup) -> Result<Self, Error> {
        match setup.schedule {
            Schedule::Sequential => Ok(Self::Here(Box::new(Sequential::new(setup.clone())))),
            _ => Ok(Self::Threads(Threaded::start(setup.clone())?)),
        }
    }
}

impl Slam {
    /// SLAM with an empty map, the built-in vocabulary and, where the configuration asks for it, the built-in network.
    ///
    /// # Errors
    /// A camera that does not fit the configuration, a mask or a network that cannot be used.
    pub fn new(config: &Config, camera: Camera) -> Result<Self, Error> {
        Self::with(config, camera, &SlamOptions::default())
    }

    /// As [`Slam::new`], with a vocabulary, a network, a start map or a schedule of one's own.
    ///
    /// # Errors
    /// As [`Slam::new`], and files that cannot be used.
    pub fn with(config: &Config, camera: Camera, options: &SlamOptions) -> Result<Self, Error> {
        let (sequence, size) = camera.into_parts();
        let name = sequence.name.clone();
        let intake = Intake::new(name.as_ref(), sequence, Some(size), config)?;
        let (setup, map_stamps) = options.setup(&intake, Schedule::default())?;
        let engine = Engine::start(&setup)?;
        Ok(Self { intake, setup, engine, map_stamps, stamps: Vec::new() })
    }

    /// Takes the images of the next frame, which was seen `t_ns` nanoseconds after any fixed moment, and returns what tracking makes of
    /// them: the state with its reason, and the pose. The images are those of the raw camera; they are reduced and rectified here.
    ///
    /// Mapping may still be at work when it returns, except with `Sequential`. With `Live { realtime: true }` frames that come while
    /// tracking is behind are skipped, and the answer says so.
    ///
    /// # Errors
    /// [`Error::Frame`] for images that do not fit the camera and for a time that is not after the last one: the frame was not taken,
    /// and the next one may come. [`Error::Stage`] when a stage has failed, which is a bug; [`Slam::finish`] gives what there was.
    pub fn track<'a>(&mut self, t_ns: i64, images: impl Into<Images<'a>>) -> Result<FrameAnswer, Error> {
        let refused = |problem| Error::Frame { t_ns, problem };
        if let Some(&last_ns) = self.stamps.last().filter(|last| **last >= t_ns) {
            return Err(refused(FrameProblem::Time { last_ns }));
        }
        let images = images.into();
        let frame = self.frame(&images).map_err(refused)?;
        let mask = self.mask(&images).map_err(refused)?;
        let name = self.intake.path.as_path();
        let frame = self.intake.preparation.apply(frame, name);
        let info = FrameInfo::new(self.stamps.len(), io::seconds(t_ns));
        self.stamps.push(t_ns);
        match &mut self.engine {
            Engine::Here(line) => Ok(line.step(info, frame, mask, &mut Silent)?),
            Engine::Threads(threads) => {
                threads.push(info, frame, mask)?;
                Ok(threads.answer().ok_or(RunEnded)?)
            }
        }
    }

    /// Lets all stages finish and returns the results: final poses, map, loops, statistics.
    ///
    /// # Errors
    /// A thread that could not be started.
    pub fn finish(self) -> Result<Finished, Error> {
        let outcome = match self.engine {
            Engine::Here(line) => line.finish(&mut Silent),
            Engine::Threads(threads) => threads.finish()?.0,
        };
        let clock = Clock::of_stamps(self.stamps.iter().chain(&self.map_stamps).copied());
        Ok(Finished::new(outcome, &self.intake, &self.setup, clock))
    }

    /// Forgets everything that was seen and starts again, with the start map if there is one. What follows has the bits of a new
    /// [`Slam`].
    ///
    /// # Errors
    /// A thread that cannot be started; nothing has changed then.
    pub fn reset(&mut self) -> Result<(), Error> {
        self.engine = Engine::start(&self.setup)?;
        self.stamps.clear();
        Ok(())
    }

    /// The configuration in force, with the camera.
    pub fn config(&self) -> &Config {
        &self.intake.config
    }

    /// What the caller should know, such as a value of the configuration that the camera replaces.
    pub fn notices(&self) -> &[String] {
        &self.intake.notices
    }

    /// The images as the stages take them; those that the sensor has must be there, and no others.
    fn frame(&self, images: &Images<'_>) -> Result<LoadedFrame, FrameProblem> {
        let (sensor, size) = (self.intake.sequence.sensor, self.intake.size);
        let expect = |image: &'static str, is_there: bool, of: Sensor| match (is_there, sensor == of) {
            (false, true) => Err(FrameProblem::Missing { image, sensor }),
            (true, false) => Err(FrameProblem::Unexpected { image, sensor }),
            _ => Ok(()),
        };
        expect("right", images.right.is_some(), Sensor::Stereo)?;
        expect("depth", images.depth.is_some(), Sensor::Rgbd)?;
        let units_per_meter = self.intake.config.camera.depth_units_per_metre;
        Ok(LoadedFrame {
            left: images.left.to_gray("left", size)?,
            right: images.right.map(|right| right.to_gray("right", size)).transpose()?,
            depth: images.depth.map(|depth| depth.to_depth(size, units_per_meter)).transpose()?,
        })
    }

    /// Where features may be taken in this frame, if it brings its own mask.
    fn mask(&self, images: &Images<'_>) -> Result<Option<FrameMask>, FrameProblem> {
        let Some(mask) = images.mask else { return Ok(None) };
        let mask = mask.to_gray("mask", self.intake.size)?;
        Ok(Some(self.intake.preparation.mask(&self.setup.extractor, Some(&mask)).map(Arc::new)))
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn seconds_are_those_of_the_same_time_in_a_file() {
        for (t_ns, text) in [
            (0, "0"),
            (300_000_000, "0.3"),
            (103_819_400, "0.1038194"),
            (-1, "-0.000000001"),
            (1_305_031_102_175_304_000, "1305031102.175304"),
            (1_403_636_579_763_555_584, "1403636579.763555584"),
            (-1_403_636_579_763_555_584, "-1403636579.763555584"),
        ] {
            assert_eq!(io::seconds(t_ns), text.parse::<f64>().unwrap(), "{text}");
        }
    }
}
