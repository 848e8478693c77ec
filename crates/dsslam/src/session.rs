//! A run over something that has all its frames at hand: a dataset, a video, a camera, a rendered world.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use runtime::{Journal, Observer, RunError, RunOutcome, Schedule, Setup};
use synth::World;

use crate::figures::Facts;
use crate::{Config, Error, Figures, Finished, Input, InputOptions, SlamOptions};

/// How a session is opened; the default does what the configuration says.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct SessionOptions {
    /// What is read.
    pub input: InputOptions,
    /// How SLAM starts.
    pub slam: SlamOptions,
}

/// A run that can begin: everything that can be checked has been checked.
#[derive(Debug)]
pub struct Session {
    input: Input,
    setup: Setup,
    /// Stamps of the start map, nanoseconds.
    map_stamps: Vec<i64>,
}

impl Session {
    /// Opens a folder of images, a video or a camera.
    ///
    /// # Errors
    /// Whatever of dataset and configuration cannot be used.
    pub fn open(path: impl AsRef<Path>, config: &Config) -> Result<Self, Error> {
        Self::open_with(path, config, &SessionOptions::default())
    }

    /// As [`Session::open`], with options.
    ///
    /// # Errors
    /// Whatever of dataset, configuration, network, vocabulary and start map cannot be used.
    pub fn open_with(
        path: impl AsRef<Path>,
        config: &Config,
        options: &SessionOptions,
    ) -> Result<Self, Error> {
        Self::of(Input::open(path.as_ref(), config, &options.input)?, options)
    }

    /// A session on a rendered world.
    ///
    /// # Errors
    /// As [`Session::open_with`].
    pub fn rendered(world: World, config: &Config, options: &SessionOptions) -> Result<Self, Error> {
        Self::of(Input::rendered(world, config, &options.input)?, options)
    }

    fn of(input: Input, options: &SessionOptions) -> Result<Self, Error> {
        // What a camera delivers while tracking is behind would pile up.
        let schedule =
            if input.is_camera() { Schedule::Live { realtime: true } } else { Schedule::default() };
        let (setup, map_stamps) = options.slam.setup(input.intake(), schedule)?;
        Ok(Self { input, setup, map_stamps })
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
        self.input.notices()
    }

    /// What the run will rest on, and what of it is implausible: looked at before the first frame. Reads a few frames, unless
    /// they come as a stream.
    pub fn figures(&self) -> Figures {
        Figures::of(&Facts::gather(self))
    }

    /// Runs over all frames.
    ///
    /// # Errors
    /// No frames, or a thread that cannot be started.
    pub fn run(&self, observer: &mut dyn Observer) -> Result<Finished, Error> {
        self.run_until(observer, &AtomicBool::new(false))
    }

    /// Runs over all frames, or until `stop` becomes true; what was computed until then is returned.
    ///
    /// # Errors
    /// As [`Session::run`].
    pub fn run_until(&self, observer: &mut dyn Observer, stop: &AtomicBool) -> Result<Finished, Error> {
        self.finished(runtime::run(self.input.feed(), &self.setup, observer, stop))
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
    ) -> Result<Finished, Error> {
        self.finished(runtime::replay(self.input.feed(), &self.setup, journal, observer, stop))
    }

    fn finished(&self, outcome: Result<RunOutcome, RunError>) -> Result<Finished, Error> {
        let clock = self.input.clock().clone().with(self.map_stamps.iter().copied());
        Ok(Finished::new(outcome?, self.input.intake(), &self.setup, clock))
    }
}
