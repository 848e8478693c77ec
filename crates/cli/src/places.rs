//! Vocabulary, map files and journals of a run: read, and their targets checked, before the first image is processed.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use bow::Vocabulary;
use io::Sensor;
use map::{Map, MapFileInfo};
use runtime::{Journal, Schedule, Setup};

use crate::args::{RunArgs, ScheduleArg};
use crate::exit::{Failure, OrExit};
use crate::files::folder_of;
use crate::video;

/// What a run writes beside its results folder.
#[derive(Clone, Debug, Default)]
pub(crate) struct Extras {
    /// The map at its end.
    pub(crate) save_map: Option<PathBuf>,
    /// Its journal.
    pub(crate) journal: Option<PathBuf>,
}

/// The vocabulary of a file, or the one that is part of the program.
///
/// # Errors
/// A file that is no vocabulary.
pub(crate) fn vocabulary(file: Option<&Path>) -> Result<Arc<Vocabulary>> {
    let vocabulary = match file {
        Some(file) => bow::tool::open(file)?,
        None => Vocabulary::built_in().context("the vocabulary that is part of the program")?,
    };
    Ok(Arc::new(vocabulary))
}

/// Adds to a setup what the arguments say about schedule, vocabulary and maps.
///
/// # Errors
/// A vocabulary or a map that cannot be used.
pub(crate) fn complete(setup: &mut Setup, args: &RunArgs, sensor: Sensor) -> Result<(), Failure> {
    // What a camera delivers while tracking is behind would pile up.
    let is_camera = video::is_camera(&args.sequence);
    setup.schedule = match (args.schedule, args.realtime) {
        (None, _) if is_camera => Schedule::Live { realtime: true },
        (Some(ScheduleArg::Sequential), false) => Schedule::Sequential,
        (None | Some(ScheduleArg::Lockstep), false) => Schedule::Lockstep,
        (Some(ScheduleArg::Live), realtime) => Schedule::Live { realtime },
        (_, true) => return Err(anyhow::anyhow!("--realtime needs --schedule live")).or_input(),
    };
    setup.vocabulary = Some(vocabulary(args.vocab.as_deref()).or_input()?);
    setup.start = args.load_map.as_deref().map(|file| load_map(file, sensor)).transpose().or_input()?;
    setup.slam.tracking.localize_only = args.localize;
    setup.faults.delays = args.delays;
    Ok(())
}

/// The journal to replay, if there is one to replay.
///
/// # Errors
/// A file that is no journal.
pub(crate) fn journal(args: &RunArgs) -> Result<Option<Journal>> {
    let Some(file) = &args.replay else { return Ok(None) };
    let bytes = fs::read(file).with_context(|| format!("{}: cannot be read", file.display()))?;
    let journal = Journal::from_json(&bytes).with_context(|| file.display().to_string())?;
    Ok(Some(journal))
}

/// Where map and journal go, proved to be writable.
///
/// # Errors
/// A place that cannot be written.
pub(crate) fn extras(args: &RunArgs) -> Result<Extras> {
    for file in [&args.save_map, &args.journal].into_iter().flatten() {
        ensure!(!file.is_dir(), "{}: cannot be written: it is a folder", file.display());
        ensure!(file.file_name().is_some(), "{}: cannot be written: it has no name", file.display());
        io::create_output_folder(folder_of(file))?;
    }
    Ok(Extras { save_map: args.save_map.clone(), journal: args.journal.clone() })
}

/// Reads a map that was made with the same kind of camera.
fn load_map(file: &Path, sensor: Sensor) -> Result<Map> {
    let bytes = fs::read(file).with_context(|| format!("{}: cannot be read", file.display()))?;
    let (map, info) = map::file::decode(&bytes).with_context(|| file.display().to_string())?;
    if info.sensor != Some(sensor) {
        let found = info.sensor.map_or("unknown", Sensor::word);
        bail!("{}: the map was made with sensor {found}, this run has {sensor}", file.display());
    }
    Ok(map)
}

/// Writes the map; returns its file's bytes.
///
/// # Errors
/// A file that cannot be written; an older one is then untouched.
pub(crate) fn save_map(file: &Path, map: &Map, info: &MapFileInfo) -> Result<Vec<u8>> {
    let bytes = map::file::encode(map, info);
    io::write_durable(file, &bytes)?;
    Ok(bytes)
}
