//! What a run needs to know beside its configuration: files and ways of working.

use std::path::PathBuf;

use runtime::{Schedule, Setup};

use crate::intake::Intake;
use crate::{Error, NetworkOptions, maps};

/// How SLAM starts; the default starts an empty map with the built-in vocabulary and network.
///
/// Fields may be added. Take the default and set what differs:
///
/// ```
/// let mut options = dsslam::SlamOptions::default();
/// options.start_map = Some("office.dsmap".into());
/// options.localize_only = true;
/// ```
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct SlamOptions {
    /// The activation network.
    pub network: NetworkOptions,
    /// File of a vocabulary; `None`: the built-in one.
    pub vocabulary: Option<PathBuf>,
    /// File of a map to start with; see [`map::file`] for what it keeps of a run.
    pub start_map: Option<PathBuf>,
    /// Only finds the camera in the start map and adds nothing to it.
    pub localize_only: bool,
    /// How the stages share time; `None`: [`Schedule::Lockstep`], and for a camera [`Schedule::Live`] at its pace.
    pub schedule: Option<Schedule>,
}

impl SlamOptions {
    /// Everything that a run needs beside its frames; and the stamps of the start map, nanoseconds.
    ///
    /// # Errors
    /// A camera that nobody gives; a mask, network, vocabulary or start map that cannot be used.
    pub(crate) fn setup(&self, intake: &Intake, schedule: Schedule) -> Result<(Setup, Vec<i64>), Error> {
        let mut setup = intake.setup(&self.network)?;
        setup.schedule = self.schedule.unwrap_or(schedule);
        setup.vocabulary = Some(maps::vocabulary(self.vocabulary.as_deref())?);
        let sensor = intake.sequence.sensor;
        let start = self.start_map.as_deref().map(|file| maps::open_map(file, sensor)).transpose()?;
        let (map, info) = start.unzip();
        setup.start = map;
        setup.slam.tracking.localize_only = self.localize_only;
        Ok((setup, info.unwrap_or_default().stamps_ns))
    }
}
