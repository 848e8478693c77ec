//! Wall-clock times per frame and stage, measured outside the algorithms.

use std::time::{Duration, Instant};

use crossbeam::channel::{Receiver, RecvTimeoutError};
use serde::Serialize;
use slam::{Probe, Stage};

/// Times of one frame, in milliseconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameTimings {
    /// Number of the frame in its sequence.
    pub index: u32,
    /// `(stage, ms)` in the order in which the stages ended; a stage appears only if it ran.
    pub stages: Vec<(&'static str, f64)>,
}

/// Times of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timings {
    /// One row per frame, in order.
    pub rows: Vec<FrameTimings>,
}

/// Median, 95th percentile and maximum of a stage, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// How often the stage ran.
    pub calls: usize,
    /// Median.
    pub median: f64,
    /// 95th percentile (nearest rank).
    pub p95: f64,
    /// Maximum.
    pub max: f64,
}

impl Timings {
    /// Stages in the order of their first appearance.
    pub fn stages(&self) -> Vec<&'static str> {
        let mut names = Vec::new();
        for (name, _) in self.rows.iter().flat_map(|row| &row.stages) {
            if !names.contains(name) {
                names.push(*name);
            }
        }
        names
    }

    /// Summary of a stage over all frames in which it ran; `None` if it never did.
    pub fn summary(&self, stage: &str) -> Option<Summary> {
        let mut times: Vec<f64> = self
            .rows
            .iter()
            .flat_map(|row| &row.stages)
            .filter(|(name, _)| *name == stage)
            .map(|(_, ms)| *ms)
            .collect();
        times.sort_by(f64::total_cmp);
        let max = *times.last()?;
        let rank =
            |share: f64| times[((share * times.len() as f64).ceil() as usize).clamp(1, times.len()) - 1];
        Some(Summary { calls: times.len(), median: rank(0.5), p95: rank(0.95), max })
    }
}

/// A stopwatch for the stages of one frame.
#[derive(Debug)]
pub(crate) struct Stopwatch {
    row: FrameTimings,
    running: Option<Instant>,
}

#[allow(clippy::disallowed_methods)] // The one place with a clock; its readings are never read back.
fn now() -> Instant {
    Instant::now()
}

fn milliseconds(since: Instant) -> f64 {
    now().duration_since(since).as_secs_f64() * 1e3
}

impl Stopwatch {
    pub(crate) fn new(index: u32) -> Self {
        Stopwatch { row: FrameTimings { index, stages: Vec::new() }, running: None }
    }

    /// Times `work` under a name of its own.
    pub(crate) fn time<T>(&mut self, name: &'static str, work: impl FnOnce(&mut Self) -> T) -> T {
        let start = now();
        let result = work(self);
        self.row.stages.push((name, milliseconds(start)));
        result
    }

    /// Adds to the time that was recorded last, milliseconds.
    pub(crate) fn add_to_last(&mut self, ms: f64) {
        if let Some((_, last)) = self.row.stages.last_mut() {
            *last += ms;
        }
    }

    /// The last time recorded under `name`, milliseconds.
    pub(crate) fn last(&self, name: &str) -> f64 {
        self.row.stages.iter().rev().find(|(stage, _)| *stage == name).map_or(0.0, |(_, ms)| *ms)
    }

    pub(crate) fn finish(self) -> FrameTimings {
        self.row
    }
}

impl Probe for Stopwatch {
    fn begin(&mut self, _: Stage) {
        self.running = Some(now());
    }

    fn end(&mut self, stage: Stage) {
        if let Some(start) = self.running.take() {
            self.row.stages.push((stage.name(), milliseconds(start)));
        }
    }
}

/// The pace of timestamps.
#[derive(Debug)]
pub(crate) struct Pace {
    start: Instant,
}

impl Pace {
    /// Time 0 is now.
    pub(crate) fn start() -> Self {
        Pace { start: now() }
    }

    /// Seconds since the start.
    pub(crate) fn seconds(&self) -> f64 {
        now().duration_since(self.start).as_secs_f64()
    }

    /// Waits until `seconds` after the start; whether the sender of `open` was still there then.
    pub(crate) fn wait(&self, seconds: f64, open: &Receiver<()>) -> bool {
        let due = Duration::try_from_secs_f64(seconds).unwrap_or_default();
        let left = due.saturating_sub(now().duration_since(self.start));
        !matches!(open.recv_timeout(left), Err(RecvTimeoutError::Disconnected))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_are_nearest_ranks() {
        let rows = (1..=100)
            .map(|i| FrameTimings { index: i, stages: vec![("extract", f64::from(i)), ("track", 1.0)] })
            .collect();
        let timings = Timings { rows };
        assert_eq!(timings.stages(), vec!["extract", "track"]);
        assert_eq!(
            timings.summary("extract"),
            Some(Summary { calls: 100, median: 50.0, p95: 95.0, max: 100.0 })
        );
        assert_eq!(timings.summary("fuse"), None);
    }
}
