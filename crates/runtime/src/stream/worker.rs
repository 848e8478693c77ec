//! The thread that makes records out of what the run has, and writes them.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crossbeam::channel::Receiver;
use events::{DeltaOptions, DeltaTracker, Level, Record, StreamWriter, Text, WriteError};
use slam::World;

use super::records;
use super::{StreamOptions, StreamReport};
use crate::events::FrameDetails;

/// Something to write.
#[derive(Debug)]
pub(super) enum Item {
    /// A record as it is.
    Record(Box<Record>),
    /// Image and features of a frame.
    Details(Arc<FrameDetails>),
    /// A state of the map, as of a frame.
    Map { world: Arc<World>, frame: u32, is_last: bool },
}

/// A target that counts the bytes which it has taken.
pub(super) struct Counting {
    target: Box<dyn Write + Send>,
    taken: Arc<AtomicU64>,
}

impl Counting {
    pub(super) fn new(target: Box<dyn Write + Send>) -> Self {
        Counting { target, taken: Arc::default() }
    }

    pub(super) fn count(&self) -> Arc<AtomicU64> {
        self.taken.clone()
    }
}

impl Write for Counting {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let n = self.target.write(bytes)?;
        self.taken.fetch_add(n as u64, Ordering::Relaxed);
        Ok(n)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.target.flush()
    }
}

/// How much still fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Room {
    /// Everything.
    All,
    /// No images and features.
    MapAndPoses,
    /// Poses and texts.
    Poses,
}

/// The writer.
pub(super) struct Worker {
    options: StreamOptions,
    /// `None` until the target has taken the header, and after it has failed.
    stream: Option<StreamWriter<Counting>>,
    tracker: DeltaTracker,
    room: Room,
    report: StreamReport,
}

impl Worker {
    pub(super) fn new(target: Counting, options: StreamOptions) -> Self {
        let mut worker = Worker {
            options,
            stream: None,
            tracker: DeltaTracker::new(DeltaOptions::default()),
            room: Room::All,
            report: StreamReport::default(),
        };
        match StreamWriter::new(target) {
            Ok(stream) => worker.stream = Some(stream),
            Err(error) => worker.report.broken = Some(error.to_string()),
        }
        worker
    }

    /// Writes until the senders are gone. After the target has failed, items are received and dropped.
    pub(super) fn work(mut self, items: &Receiver<Item>) -> StreamReport {
        for item in items {
            if self.stream.is_none() {
                self.report.left_out += 1;
                continue;
            }
            match item {
                Item::Record(record) => self.write(&record),
                Item::Details(details) => self.write_details(&details),
                Item::Map { world, frame, is_last } => self.write_map(&world, frame, is_last),
            }
        }
        self.report
    }

    fn write_details(&mut self, details: &FrameDetails) {
        let index = details.answer.index;
        if !index.is_multiple_of(self.options.image_every.max(1)) {
            return;
        }
        if self.room > Room::All {
            self.report.left_out += 1;
            return;
        }
        if let Some(images) = &details.images {
            if let Some(preview) = io::preview(&images.image, self.options.image_width) {
                self.write(&Record::Image(records::image(index, preview)));
            }
            if let Some(map) = &images.activation {
                self.write(&Record::Activation(records::activation(index, map)));
            }
        }
        self.write(&Record::Features(records::features(details)));
    }

    fn write_map(&mut self, world: &World, frame: u32, is_last: bool) {
        if self.room > Room::MapAndPoses {
            self.report.left_out += 1;
            return;
        }
        let map = &world.map;
        let delta = if is_last { self.tracker.finish(map, frame) } else { self.tracker.advance(map, frame) };
        if !delta.is_empty() {
            self.write(&Record::Map(delta));
        }
    }

    fn write(&mut self, record: &Record) {
        let Some(stream) = &mut self.stream else { return };
        match stream.write(record) {
            Ok(()) => self.report.n_bytes = stream.n_bytes(),
            // The target is as it was.
            Err(WriteError::Encode(_) | WriteError::TooLarge(_)) => self.report.left_out += 1,
            Err(error @ WriteError::Io(_)) => {
                self.report.broken = Some(error.to_string());
                self.stream = None;
                return;
            }
        }
        self.look_at_room();
    }

    /// Says once each when the stream has grown so much that less is written from now on.
    fn look_at_room(&mut self) {
        let (n, max) = (self.report.n_bytes, self.options.max_bytes);
        let (room, text) = match () {
            () if n >= max => (Room::Poses, "the event stream is full: map changes are no longer written"),
            () if n >= max / 4 * 3 => {
                (Room::MapAndPoses, "the event stream is almost full: images are no longer written")
            }
            () => return,
        };
        if room > self.room {
            self.room = room;
            let text = Text { frame: None, level: Level::Warning, text: text.to_owned() };
            self.write(&Record::Text(text));
        }
    }
}
