//! What a person sees while a run goes on: a bar on a terminal, changes of state everywhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use runtime::{Event, FrameStatus, LoopRecord, LoopResult, Observer};

use crate::clock::StopWatch;
use crate::console;

/// Dropped frames that are named one by one; all of them stand in `summary.json`.
const NAMED_DROPS: usize = 10;

/// What tracking was doing at the last frame that could be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    NotReady,
    Tracking,
    Lost,
}

/// An observer that keeps the person informed.
pub(crate) struct Progress {
    bar: ProgressBar,
    watch: StopWatch,
    state: State,
    n_frames: usize,
    n_dropped: usize,
}

impl Progress {
    /// A bar on standard error, hidden when that is not a terminal.
    pub(crate) fn new() -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template("{bar:24} {pos}/{len}  {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        Self { bar, watch: StopWatch::start(), state: State::NotReady, n_frames: 0, n_dropped: 0 }
    }

    /// Takes the bar off the screen.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }

    fn tell(&self, line: &str) {
        self.bar.suspend(|| console::note(line));
    }

    fn tell_loop(&self, record: &LoopRecord) {
        let LoopRecord { frame, matched_frame, result, .. } = record;
        let line = match result {
            LoopResult::Closed { inliers, moved_m, joined, .. } => {
                let joined = if *joined { ", joining two sub-maps" } else { "" };
                format!(
                    "loop closed from frame {frame} to {matched_frame}{joined}: {moved_m:.2} m, {inliers} points"
                )
            }
            LoopResult::Rejected(reason) => {
                format!("loop from frame {frame} to {matched_frame} rejected: {reason}")
            }
            LoopResult::Refused(reason) => {
                format!("loop from frame {frame} to {matched_frame} refused by the map: {reason}")
            }
        };
        self.tell(&line);
    }

    /// Tells changes of state and dropped frames.
    fn tell_changes(&mut self, index: u32, status: &FrameStatus) {
        let state = match status {
            FrameStatus::Dropped(reason) => {
                self.n_dropped += 1;
                if self.n_dropped <= NAMED_DROPS {
                    self.tell(&console::warning(format!("frame {index} dropped: {reason}")));
                } else if self.n_dropped == NAMED_DROPS + 1 {
                    self.tell("further dropped frames are listed in summary.json");
                }
                return;
            }
            FrameStatus::NotReady(_) => State::NotReady,
            FrameStatus::Tracked { .. } => State::Tracking,
            FrameStatus::Lost(_) => State::Lost,
        };
        match (self.state, state, status) {
            (State::Tracking, State::Lost, FrameStatus::Lost(reason)) => {
                self.tell(&console::warning(format!("lost at frame {index}: {reason}")));
            }
            (State::Lost, State::Tracking, _) => self.tell(&format!("tracking again at frame {index}")),
            (State::NotReady, State::Tracking, _) if index > 0 => {
                self.tell(&format!("map started with frame {index}"));
            }
            (_, State::NotReady, FrameStatus::NotReady(reason)) if self.n_frames == 0 => {
                self.tell(&format!("frame {index}: {reason}"));
            }
            _ => {}
        }
        self.state = state;
    }
}

impl Observer for Progress {
    fn event(&mut self, event: &Event) {
        match event {
            Event::Started { frames } => {
                self.bar.set_length(*frames as u64);
                self.watch = StopWatch::start();
            }
            Event::Frame { index, status, keyframes, points, .. } => {
                self.tell_changes(*index, status);
                self.n_frames += 1;
                let rate = self.n_frames as f64 / self.watch.seconds().max(1e-6);
                self.bar.set_message(format!(
                    "{rate:.1} frames/s  {}  {keyframes} keyframes  {points} points",
                    describe(status)
                ));
                self.bar.set_position(self.n_frames as u64);
            }
            Event::Calibrating { done, frames } => {
                self.bar.set_length(*frames as u64);
                self.bar.set_message("refining the stereo calibration");
                self.bar.set_position(*done as u64);
            }
            Event::Calibrated { estimate: Some(estimate) } => self.tell(&format!(
                "stereo calibration refined from the images: disparity offset {:+.3} px (+- {:.3} px)",
                estimate.offset_px, estimate.sigma_px
            )),
            Event::Calibrated { estimate: None } => {
                self.tell("stereo calibration left as it is: too few keyframes tell of a disparity offset");
            }
            Event::Relocalised { frame, .. } => {
                self.tell(&format!("place recognised at frame {frame}"));
            }
            Event::SubmapStarted { frame, .. } => {
                self.tell(&console::warning(format!("new sub-map from frame {frame} on")));
            }
            Event::Loop(record) => self.tell_loop(record),
            Event::GlobalRefused { reason } => {
                self.tell(&console::warning(format!("a global bundle adjustment was refused: {reason}")));
            }
            Event::Keyframe { .. }
            | Event::LoopFound { .. }
            | Event::GlobalAdopted { .. }
            | Event::GlobalDiscarded
            | Event::Details(_)
            | Event::Published(_)
            | Event::Stages { .. } => {}
        }
    }
}

/// The state as the bar shows it.
fn describe(status: &FrameStatus) -> String {
    match status {
        FrameStatus::NotReady(_) => "waiting for a start".to_owned(),
        FrameStatus::Tracked { inliers } => format!("tracking {inliers} points"),
        FrameStatus::Lost(_) => "LOST".to_owned(),
        FrameStatus::Dropped(_) => "frame dropped".to_owned(),
    }
}
