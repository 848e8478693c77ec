//! Runs over folders, videos and cameras.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use dsslam::mcap::McapRecorder;
use dsslam::runtime::{Narrator, Weight, Words};
use dsslam::{Chosen, Compared, Config, Event, Observer, Session, SessionOptions};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments;
use crate::error::raised;
use crate::finished::Finished;
use crate::{frame, network};

/// Ends a run from outside.
#[pyclass(frozen, module = "dsslam")]
#[derive(Default)]
pub(crate) struct Stop(Arc<AtomicBool>);

#[pymethods]
impl Stop {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// The configuration that is named, else the built-in one that goes with the layout of the folder.
pub(crate) fn chosen(
    folder: &Path,
    config: Option<&Path>,
    settings: Option<&Bound<'_, PyDict>>,
    network: Option<PathBuf>,
) -> PyResult<Chosen> {
    Config::choose(config, Some(folder), &arguments::overrides(settings)?, &network::options(network))
        .map_err(raised)
}

/// Tells a Python function of what is to be known before the run, of each frame, and of what happens in words. What it raises ends the run.
struct Telling<'a> {
    observer: &'a Py<PyAny>,
    narrator: Narrator,
    clock: &'a io::Clock,
    stop: &'a AtomicBool,
    raised: Option<PyErr>,
}

impl Observer for Telling<'_> {
    fn event(&mut self, event: &Event) {
        if self.raised.is_some() {
            return;
        }
        let words = self.narrator.tell(event);
        let told = Python::attach(|py| {
            // Frames are told as results, not in words.
            for Words { event, text, .. } in words.into_iter().filter(|words| words.weight < Weight::Trace) {
                self.observer.call1(py, (event, text))?;
            }
            if let Event::Frame(answer) = event {
                let t_ns = self.clock.nanoseconds(answer.timestamp_s);
                self.observer.call1(py, ("frame", frame::Result::new(answer, t_ns)))?;
            }
            PyResult::Ok(())
        });
        if let Err(error) = told {
            self.raised = Some(error);
            self.stop.store(true, Ordering::Relaxed);
        }
    }
}

/// All who watch a run.
struct Watching<'a> {
    telling: Option<Telling<'a>>,
    recorder: Option<McapRecorder>,
}

impl Observer for Watching<'_> {
    fn event(&mut self, event: &Event) {
        if let Some(telling) = &mut self.telling {
            telling.event(event);
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.event(event);
        }
    }

    fn wants_details(&self) -> bool {
        self.recorder.is_some()
    }
}

/// Runs over all frames; `dsslam.run` wraps it so that Ctrl-C ends it with its results.
#[pyfunction]
#[pyo3(signature = (path, config, stop, *, settings, sensor, calibration, ground_truth, topics, max_frames, map, localize, vocabulary, network, schedule, observer, mcap))]
#[expect(clippy::too_many_arguments, reason = "they have names in Python")]
pub(crate) fn run(
    py: Python<'_>,
    path: PathBuf,
    config: Option<PathBuf>,
    stop: &Bound<'_, Stop>,
    settings: Option<&Bound<'_, PyDict>>,
    sensor: Option<&str>,
    calibration: Option<PathBuf>,
    ground_truth: Option<PathBuf>,
    topics: Option<&str>,
    max_frames: Option<usize>,
    map: Option<PathBuf>,
    localize: bool,
    vocabulary: Option<PathBuf>,
    network: Option<PathBuf>,
    schedule: Option<&str>,
    observer: Option<Py<PyAny>>,
    mcap: Option<PathBuf>,
) -> PyResult<Finished> {
    let chosen = chosen(&path, config.as_deref(), settings, network.clone())?;
    let mut options = SessionOptions::default();
    options.input.sensor = arguments::sensor(sensor)?;
    options.input.calibration = calibration;
    options.input.ground_truth = ground_truth;
    options.input.topics =
        topics.map(str::parse).transpose().map_err(|error: dsslam::bag::BagError| raised(error))?;
    options.input.max_frames = max_frames;
    options.slam = arguments::options(map, localize, vocabulary, network, schedule)?;
    let stop = Arc::clone(&stop.get().0);
    py.detach(|| {
        let session = Session::open_with(&path, &chosen.config, &options).map_err(raised)?;
        let layout =
            chosen.preset.map(|name| format!("configuration {name}, built in, as the layout suggests"));
        let notices: Vec<String> =
            layout.into_iter().chain(chosen.notices).chain(session.notices().iter().cloned()).collect();
        if let Some(observer) = &observer {
            Python::attach(|py| {
                notices.iter().try_for_each(|notice| observer.call1(py, ("notice", notice)).map(drop))
            })?;
        }
        let recorder = mcap.as_deref().map(|file| McapRecorder::create(file, &session));
        let mut watching = Watching {
            telling: observer.as_ref().map(|observer| Telling {
                observer,
                narrator: Narrator::default(),
                clock: session.input().clock(),
                stop: &stop,
                raised: None,
            }),
            recorder: recorder.transpose().map_err(raised)?,
        };
        let done = session.run_until(&mut watching, &stop);
        if let Some(error) = watching.telling.and_then(|telling| telling.raised) {
            return Err(error);
        }
        let done = done.map_err(raised)?;
        watching.recorder.map_or(Ok(()), |recorder| recorder.finish(&done.outcome)).map_err(raised)?;
        let sequence = session.input().sequence();
        let evaluation = Compared::new(&done.outcome.frames, sequence)
            .and_then(|compared| compared.evaluate(&eval::KITTI_LENGTHS_M).ok())
            .and_then(|evaluation| serde_json::to_string(&evaluation).ok());
        Ok(Finished::new(done, sequence.sensor, notices, evaluation))
    })
}
