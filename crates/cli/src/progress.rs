//! What a person sees while a run goes on: a bar on a terminal, changes of state everywhere.

use indicatif::ProgressBar;
use runtime::{Event, FrameAnswer, Narrator, Observer, Words};

use crate::clock::StopWatch;
use crate::console;
use crate::telling;

/// Dropped frames that are named one by one; `summary.json` lists all of them.
const NAMED_DROPS: usize = 10;

/// An observer that keeps the person informed.
pub(crate) struct Progress {
    bar: ProgressBar,
    watch: StopWatch,
    narrator: Narrator,
    n_frames: usize,
    n_dropped: usize,
}

impl Progress {
    /// A bar on standard error, hidden when that is not a terminal.
    pub(crate) fn new() -> Self {
        let bar = console::bar(None, "{bar:24} {pos}/{len}  {msg}");
        Self { bar, watch: StopWatch::start(), narrator: Narrator::default(), n_frames: 0, n_dropped: 0 }
    }

    /// Takes the bar off the screen.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// Says what there is to say, but not of each of many dropped frames.
    fn tell(&mut self, words: Words) {
        let is_drop = words.event == "dropped";
        self.n_dropped += usize::from(is_drop);
        let message = match is_drop.then_some(self.n_dropped) {
            Some(n) if n > NAMED_DROPS + 1 => return,
            Some(n) if n == NAMED_DROPS + 1 => "all further dropped frames are listed in summary.json".into(),
            _ => telling::message(words),
        };
        self.bar.suspend(|| console::note(message));
    }

    fn show_rate(&self, answer: &FrameAnswer) {
        let FrameAnswer { status, keyframes, points, .. } = answer;
        let rate = self.n_frames as f64 / self.watch.seconds().max(1e-6);
        self.bar.set_message(format!("{rate:.1} frames/s  {status}  {keyframes} keyframes  {points} points"));
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
                self.n_frames += 1;
                self.show_rate(answer);
            }
            _ => {}
        }
        for words in self.narrator.tell(event) {
            self.tell(words);
        }
    }
}
