//! A run over something that has all its frames at hand: a dataset, a video, a camera, a rendered world.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use io::Config;
use map::{Map, MapFileInfo};
use runtime::{Journal, Observer, RunOutcome, Schedule, Setup};
use synth::World;

use crate::{Error, Input, InputOptions, NetworkOptions, maps, trajectories};

/// How a session is opened; the default does what a configuration says.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct SessionOptions {
    /// What is read.
    pub input: InputOptions,
    /// The activation network.
    pub network: NetworkOptions,
    /// File of a vocabulary; `None`: the one that is part of the library.
    pub vocabulary: Option<PathBuf>,
    /// File of a map to start with.
    pub start_map: Option<PathBuf>,
    /// Only finds the camera in the start map and inserts nothing.
    pub localize_only: bool,
    /// How the stages share time; `None`: [`Schedule::Lockstep`], for a camera [`Schedule::Live`].
    pub schedule: Option<Schedule>,
}

/// A run that can begin: everything that can be checked has been checked.
#[derive(Debug)]
pub struct Session {
    input: Input,
    setup: Setup,
    notices: Vec<String>,
}

impl Session {
    /// Opens a folder of images, a video or a camera.
    ///
    /// # Errors
    /// Whatever of dataset and configuration cannot be used.
    pub fn open(path: &Path, config: &Config) -> Result<Self, Error> {
        Self::open_with(path, config, &SessionOptions::default())
    }

    /// As [`Session::open`], with options.
    ///
    /// # Errors
    /// Whatever of dataset, configuration, network, vocabulary and start map cannot be used.
    pub fn open_with(path: &Path, config: &Config, options: &SessionOptions) -> Result<Self, Error> {
        Self::of(Input::open(path, config, &options.input)?, options)
    }

    /// A session on a rendered world.
    ///
    /// # Errors
    /// As [`Session::open_with`].
    pub fn rendered(world: World, config: &Config, options: &SessionOptions) -> Result<Self, Error> {
        Self::of(Input::rendered(world, config, &options.input)?, options)
    }

    fn of(input: Input, options: &SessionOptions) -> Result<Self, Error> {
        let mut notices = input.notices().to_vec();
        let mut setup = input.setup(&options.network)?;
        // What a camera delivers while tracking is behind would pile up.
        let default = if input.is_camera() { Schedule::Live { realtime: true } } else { Schedule::default() };
        setup.schedule = options.schedule.unwrap_or(default);
        setup.vocabulary = Some(maps::vocabulary(options.vocabulary.as_deref())?);
        let sensor = input.sequence().sensor;
        setup.start = options.start_map.as_deref().map(|file| maps::load_map(file, sensor)).transpose()?;
        setup.slam.tracking.localize_only = options.localize_only;
        if input.is_camera() && setup.calibration_frames > 0 {
            setup.calibration_frames = 0;
            notices.push(
                "stereo.calibration_frames: a camera cannot be seen twice, so there is no calibration pass"
                    .to_owned(),
            );
        }
        Ok(Self { input, setup, notices })
    }

    /// What is read, and the configuration in force.
    pub fn input(&self) -> &Input {
        &self.input
    }

    /// Camera and parameters.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Camera and parameters, to be changed before the run.
    pub fn setup_mut(&mut self) -> &mut Setup {
        &mut self.setup
    }

    /// What the user should know before the run.
    pub fn notices(&self) -> &[String] {
        &self.notices
    }

    /// Runs over all frames.
    ///
    /// # Errors
    /// No frames, or a thread that cannot be started.
    pub fn run(&self, observer: &mut dyn Observer) -> Result<RunOutcome, Error> {
        self.run_until(observer, &AtomicBool::new(false))
    }

    /// Runs over all frames, or until `stop` becomes true; what was computed until then is returned.
    ///
    /// # Errors
    /// As [`Session::run`].
    pub fn run_until(&self, observer: &mut dyn Observer, stop: &AtomicBool) -> Result<RunOutcome, Error> {
        Ok(runtime::run(self.input.feed(), &self.setup, observer, stop)?)
    }

    /// Does the run of a journal again, bit for bit.
    ///
    /// # Errors
    /// A journal of another run.
    pub fn replay(
        &self,
        journal: &Journal,
        observer: &mut dyn Observer,
        stop: &AtomicBool,
    ) -> Result<RunOutcome, Error> {
        Ok(runtime::replay(self.input.feed(), &self.setup, journal, observer, stop)?)
    }

    /// Writes a map of this session whole or not at all; returns the SHA-256 of its file, hexadecimal.
    ///
    /// # Errors
    /// A file that cannot be written; an older one is then untouched.
    pub fn save_map(&self, file: &Path, map: &Map) -> Result<String, Error> {
        let sequence = self.input.sequence();
        let vocabulary = self.setup.vocabulary.as_ref();
        let info = MapFileInfo {
            sensor: Some(sequence.sensor),
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            sequence: sequence.name.clone(),
            configuration: self.input.config().to_yaml(),
            vocabulary_sha256: vocabulary
                .map_or(String::new(), |vocabulary| maps::sha256(vocabulary.as_bytes())),
            body_from_left: trajectories::body_text(sequence.sensor, &sequence.body_from_left),
        };
        maps::save_map(file, map, &info)
    }
}
