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

/// What a word stands for; `argument` is what the message calls it.
pub(crate) fn choice<T: Copy, const N: usize>(
    argument: &str,
    word: &str,
    choices: [(&str, T); N],
) -> PyResult<T> {
    if let Some((_, chosen)) = choices.iter().find(|(name, _)| *name == word) {
        return Ok(*chosen);
    }
    let names = choices.map(|(name, _)| format!("{name:?}"));
    let expected = [&names[..N - 1].join(", "), &names[N - 1]].map(String::as_str).join(" or ");
    Err(PyValueError::new_err(format!("{argument}: found {word:?}, expected {expected}")))
}

/// The sensor of a word.
pub(crate) fn sensor_of(word: &str) -> PyResult<Sensor> {
    choice("sensor", word, Sensor::ALL.map(|sensor| (sensor.word(), sensor)))
}

/// The sensor of a word, if there is one.
pub(crate) fn sensor(word: Option<&str>) -> PyResult<Option<Sensor>> {
    word.map(sensor_of).transpose()
}

/// The schedule of a word.
fn schedule(word: &str) -> PyResult<Schedule> {
    let schedules = [
        ("lockstep", Schedule::Lockstep),
        ("sequential", Schedule::Sequential),
        ("live", Schedule::Live { realtime: false }),
        ("realtime", Schedule::Live { realtime: true }),
    ];
    choice("schedule", word, schedules)
}

/// What a `Slam` and a run take beside configuration and camera.
pub(crate) fn options(
    map: Option<PathBuf>,
    localize: bool,
    vocabulary: Option<PathBuf>,
    network: Option<PathBuf>,
    schedule: Option<&str>,
) -> PyResult<dsslam::SlamOptions> {
    if localize && map.is_none() {
        return Err(PyValueError::new_err("localize: found no map, expected one to localize in"));
    }
    let mut options = dsslam::SlamOptions::default();
    options.network = crate::network::options(network);
    options.vocabulary = vocabulary;
    options.start_map = map;
    options.localize_only = localize;
    options.schedule = schedule.map(self::schedule).transpose()?;
    Ok(options)
}
