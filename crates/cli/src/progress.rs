//! What a person sees while a run goes on: a bar on a terminal, changes of state everywhere.

use indicatif::ProgressBar;
use runtime::{Event, FrameAnswer, FrameStatus, Observer};

use crate::clock::StopWatch;
use crate::console::{self, Level, Message};
use crate::telling;

/// Dropped frames that are named one by one; `summary.json` lists all of them.
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
        let bar = console::bar(None, "{bar:24} {pos}/{len}  {msg}");
        Self { bar, watch: StopWatch::start(), state: State::NotReady, n_frames: 0, n_dropped: 0 }
    }

    /// Takes the bar off the screen.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }

    fn tell(&self, message: Message) {
        self.bar.suspend(|| console::note(message));
    }

    /// Tells changes of state and dropped frames.
    fn tell_changes(&mut self, index: u32, status: &FrameStatus) {
        let state = match status {
            FrameStatus::Dropped(reason) => {
                self.n_dropped += 1;
                if self.n_dropped <= NAMED_DROPS {
                    let reason = reason.to_string();
                    self.tell(telling::frame_event(Level::Warning, "dropped", index, Some(&reason)));
                } else if self.n_dropped == NAMED_DROPS + 1 {
                    self.tell("all further dropped frames are listed in summary.json".into());
                }
                return;
            }
            FrameStatus::NotReady(_) => State::NotReady,
            FrameStatus::Tracked { .. } => State::Tracking,
            FrameStatus::Lost(_) => State::Lost,
        };
        let (level, event, reason) = match (self.state, state, status) {
            (State::Tracking, State::Lost, FrameStatus::Lost(reason)) => {
                (Level::Warning, "lost", Some(reason.to_string()))
            }
            (State::Lost, State::Tracking, _) => (Level::Info, "tracking_again", None),
            (State::NotReady, State::Tracking, _) if index > 0 => (Level::Info, "map_started", None),
            (_, State::NotReady, FrameStatus::NotReady(reason)) if self.n_frames == 0 => {
                (Level::Info, "not_ready", Some(reason.to_string()))
            }
            _ => {
                self.state = state;
                return;
            }
        };
        self.tell(telling::frame_event(level, event, index, reason.as_deref()));
        self.state = state;
    }

    fn show_rate(&self, answer: &FrameAnswer) {
        let FrameAnswer { status, keyframes, points, .. } = answer;
        let rate = self.n_frames as f64 / self.watch.seconds().max(1e-6);
        self.bar.set_message(format!(
            "{rate:.1} frames/s  {}  {keyframes} keyframes  {points} points",
            telling::status(status)
        ));
        self.bar.set_position(self.n_frames as u64);
    }
}

impl Observer for Progress {
    fn event(&mut self, event: &Event) {
        match event {
            Event::Started { frames } => {
                // Of a video or a camera it is not known.
                match *frames {
                    None => self.bar.unset_length(),
                    Some(frames) => self.bar.set_length(frames as u64),
                }
                self.watch = StopWatch::start();
            }
            Event::Frame(answer) => {
                self.tell_changes(answer.index, &answer.status);
                self.n_frames += 1;
                self.show_rate(answer);
            }
            Event::Calibrating { done, frames } => {
                self.bar.set_length(*frames as u64);
                self.bar.set_message("refining the stereo calibration");
                self.bar.set_position(*done as u64);
            }
            _ => {}
        }
        if let Some(message) = telling::message(event) {
            self.tell(message);
        }
    }
}
