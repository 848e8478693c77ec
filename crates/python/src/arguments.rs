//! Arguments that several functions take: configuration, sensor, schedule.

use std::path::{Path, PathBuf};

use dsslam::{Config, Schedule, Sensor};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};

use crate::error::raised;

/// `settings` of Python (`{"features.keep": 500}`) as `key=value`.
pub(crate) fn overrides(settings: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<String>> {
    let Some(settings) = settings else { return Ok(Vec::new()) };
    let one = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let key: String = key.extract()?;
        let value = match value.cast::<PyBool>() {
            Ok(value) => value.is_true().to_string(),
            Err(_) => value.str()?.to_string(),
        };
        Ok(format!("{key}={value}"))
    };
    settings.iter().map(one).collect()
}

/// A built-in configuration or a file, with settings over it; the defaults without either.
pub(crate) fn config(name: Option<&Path>, settings: Option<&Bound<'_, PyDict>>) -> PyResult<Config> {
    Config::load(name, &overrides(settings)?).map_err(raised)
}

/// The sensor of a word.
pub(crate) fn sensor_of(word: &str) -> PyResult<Sensor> {
    let expected = "\"stereo\", \"rgbd\" or \"mono\"";
    word.parse().map_err(|_| PyValueError::new_err(format!("sensor: found {word:?}, expected {expected}")))
}

/// The sensor of a word, if there is one.
pub(crate) fn sensor(word: Option<&str>) -> PyResult<Option<Sensor>> {
    word.map(sensor_of).transpose()
}

/// The schedule of a word.
pub(crate) fn schedule(word: Option<&str>) -> PyResult<Option<Schedule>> {
    Ok(Some(match word {
        None => return Ok(None),
        Some("lockstep") => Schedule::Lockstep,
        Some("sequential") => Schedule::Sequential,
        Some("live") => Schedule::Live { realtime: false },
        Some("realtime") => Schedule::Live { realtime: true },
        Some(word) => {
            return Err(PyValueError::new_err(format!(
                "schedule: found {word:?}, expected \"lockstep\", \"sequential\", \"live\" or \"realtime\""
            )));
        }
    }))
}

/// What a `Slam` and a run take beside configuration and camera.
pub(crate) fn options(
    map: Option<PathBuf>,
    localize: bool,
    vocabulary: Option<PathBuf>,
    network: Option<PathBuf>,
    schedule_word: Option<&str>,
) -> PyResult<dsslam::SlamOptions> {
    if localize && map.is_none() {
        return Err(PyValueError::new_err("localize: found no map, expected one to localize in"));
    }
    let mut options = dsslam::SlamOptions::default();
    options.network = crate::network::options(network);
    options.vocabulary = vocabulary;
    options.start_map = map;
    options.localize_only = localize;
    options.schedule = schedule(schedule_word)?;
    Ok(options)
}
