//! An observer that writes the event stream of a run, on a thread of its own; it never makes the run wait.
//!
//! What a viewer cannot do without (poses, counts, texts) waits in a backlog while the writer is behind. Of the map only the newest
//! state waits, since changes are found by comparing with what was written last; images and features of such frames are skipped.

mod backlog;
mod records;
mod worker;

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use crossbeam::channel::{Receiver, RecvTimeoutError, SendTimeoutError, bounded};
use events::{Record, Start};
use slam::World;

use crate::events::{Event, Observer};
use crate::record::{FrameStatus, RunOutcome};
use crate::words::Narrator;
use backlog::Backlog;
use worker::{Counting, Item, Worker};

/// A writer that makes no progress for this many seconds at the end of a run is abandoned.
const PATIENCE_S: u32 = 15;

/// What is written, and how much of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamOptions {
    /// Images and features of every N-th frame; at least 1.
    pub image_every: u32,
    /// Widest image, pixels; wider ones are made smaller.
    pub image_width: usize,
    /// Bytes from which on nothing but poses and texts is written; images end at three quarters of them.
    pub max_bytes: u64,
    /// Items that may wait for the writer; about four come of a frame, one of them with its images.
    pub max_waiting: usize,
}

impl Default for StreamOptions {
    fn default() -> Self {
        StreamOptions { image_every: 1, image_width: 640, max_bytes: 1 << 30, max_waiting: 512 }
    }
}

/// Outcome of a stream.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StreamReport {
    /// Bytes written.
    pub n_bytes: u64,
    /// Records that were left out, since the writer was behind or the stream was full.
    pub left_out: u64,
    /// Why the stream ended before the run.
    pub broken: Option<String>,
}

/// The observer.
#[derive(Debug)]
pub struct EventStream {
    backlog: Backlog,
    done: Receiver<StreamReport>,
    /// Bytes that the target has taken.
    taken: Arc<AtomicU64>,
    narrator: Narrator,
    newest_frame: u32,
}

impl EventStream {
    /// Starts the writer.
    ///
    /// # Errors
    /// When its thread cannot be started.
    pub fn start(
        target: Box<dyn Write + Send>,
        start: Start,
        options: StreamOptions,
    ) -> std::io::Result<Self> {
        let (to_writer, items) = bounded(options.max_waiting);
        let (report, done) = bounded(1);
        let target = Counting::new(target);
        let taken = target.count();
        let work = move || {
            // Nobody may want to know any more.
            let _ = report.send(Worker::new(target, options).work(&items));
        };
        std::thread::Builder::new().name("events".into()).spawn(work)?;
        let mut backlog = Backlog::new(to_writer);
        backlog.keep(Record::Start(start));
        Ok(EventStream { backlog, done, taken, narrator: Narrator::default(), newest_frame: 0 })
    }

    /// Writes the end of a run, with its numbers as Markdown, and waits until the writer is done, or does not get on any more.
    pub fn finish(self, outcome: &RunOutcome, summary: String) -> StreamReport {
        let EventStream { backlog, done, taken, newest_frame, .. } = self;
        let (sender, mut waiting, left_out) = backlog.into_parts();
        let world = Arc::new(World::from_map(outcome.map.clone(), None));
        waiting.push_back(Item::Map { world, frame: newest_frame, is_last: true });
        waiting.push_back(Item::Record(Box::new(Record::End(records::end(outcome, summary, left_out)))));
        let mut patience = Patience { taken, last: 0, idle_s: 0 };
        for mut item in waiting {
            while let Err(error) = sender.send_timeout(item, Duration::from_secs(1)) {
                match error {
                    SendTimeoutError::Timeout(back) if patience.lasts() => item = back,
                    _ => return patience.given_up(left_out),
                }
            }
        }
        drop(sender);
        loop {
            match done.recv_timeout(Duration::from_secs(1)) {
                Ok(report) => return StreamReport { left_out: report.left_out + left_out, ..report },
                Err(RecvTimeoutError::Timeout) if patience.lasts() => {}
                Err(_) => return patience.given_up(left_out),
            }
        }
    }
}

impl Observer for EventStream {
    fn wants_details(&self) -> bool {
        true
    }

    fn event(&mut self, event: &Event) {
        for text in self.narrator.tell(event).into_iter().filter_map(records::text) {
            self.backlog.keep(Record::Text(text));
        }
        match event {
            Event::Frame(answer) if matches!(answer.status, FrameStatus::Dropped(_)) => {
                self.newest_frame = answer.index;
                self.backlog.keep(Record::Frame(records::untracked(answer)));
            }
            Event::Details(details) => {
                self.newest_frame = details.answer.index;
                self.backlog.keep(Record::Frame(records::frame(details)));
                self.backlog.offer(Item::Details(details.clone()));
            }
            Event::Published(world) => self.backlog.show(world.clone(), self.newest_frame),
            Event::Stages { frame, stages } => {
                let stages = records::stage_times(stages);
                self.backlog.keep(Record::Stages { frame: *frame, stages });
            }
            _ => {}
        }
    }
}

/// Waits for a target as long as it takes bytes.
struct Patience {
    taken: Arc<AtomicU64>,
    last: u64,
    idle_s: u32,
}

impl Patience {
    /// Called after each second without an answer.
    fn lasts(&mut self) -> bool {
        let taken = self.taken.load(Ordering::Relaxed);
        self.idle_s = if taken == self.last { self.idle_s + 1 } else { 0 };
        self.last = taken;
        self.idle_s < PATIENCE_S
    }

    fn given_up(&self, left_out: u64) -> StreamReport {
        let broken = Some("the reader of the events has stopped reading".to_owned());
        StreamReport { n_bytes: self.taken.load(Ordering::Relaxed), left_out, broken }
    }
}
