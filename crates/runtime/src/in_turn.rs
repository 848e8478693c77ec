//! `Sequential`: all stages in turn on the calling thread, only images are decoded ahead.

use std::sync::Arc;

use crossbeam::channel::{Receiver, bounded};

use crate::events::{Event, Observer};
use crate::extract::ExtractStage;
use crate::failure::{MapEnd, StageFailure, caught, map_caught};
use crate::faults::StageFaults;
use crate::fetch::{AHEAD, Fetched, ahead};
use crate::job::Job;
use crate::map_log::MapLog;
use crate::mapping::{MapStage, Out};
use crate::outcome::Parts;
use crate::record::RunError;
use crate::threads::{joined, spawn};
use crate::track::{Message, TrackLog, TrackStage};
use crate::view::{Choice, EXACT_STATES, Published, Viewer};

/// Runs by the rule, one stage after another.
pub(crate) fn run(job: &Job<'_>, observer: &mut dyn Observer) -> Result<Parts, RunError> {
    std::thread::scope(|scope| {
        let (to_here, fetched) = bounded(AHEAD);
        let faults = job.faults("decode");
        let decode = spawn(scope, "decode", move || ahead(job.feed, job.frames, faults, &to_here))?;
        let mut parts = consume(job, fetched, observer);
        match joined(decode) {
            Ok(frames) => parts.frames = frames,
            Err(failure) => parts.failure = parts.failure.or(Some(failure)),
        }
        Ok(parts)
    })
}

fn consume(job: &Job<'_>, fetched: Receiver<Fetched>, observer: &mut dyn Observer) -> Parts {
    let (publish, states) = bounded(EXACT_STATES);
    let mut line = Line {
        job,
        extract: (ExtractStage::new(job), job.faults("extract")),
        track: (TrackStage::new(job), job.faults("track")),
        viewer: Viewer::new(Choice::Exact(job.setup.rule()), job.start(), states),
        map: (job.mapping_in_turn(), job.faults("map")),
    };
    let (mut tracking, mut mapping) = (TrackLog::default(), MapLog::default());
    let mut emit = |event: Event| observer.event(&event);
    let mut publish = |state: Published| {
        // There is always room: tracking takes what the rule demands before it asks for more.
        let _ = publish.try_send(state);
    };
    let mut out = Out { log: &mut mapping, emit: &mut emit, publish: &mut publish };
    let end = line.work(fetched, &mut tracking, &mut out);
    let world = if end.is_whole {
        line.map.0.mapper.into_world()
    } else {
        Arc::unwrap_or_clone(line.viewer.newest())
    };
    Parts { tracking, mapping, world, frames: job.frames, failure: end.failure }
}

/// The stages in a row, each with its faults.
struct Line<'a> {
    job: &'a Job<'a>,
    extract: (ExtractStage<'a>, StageFaults),
    track: (TrackStage, StageFaults),
    viewer: Viewer,
    map: (MapStage<'a>, StageFaults),
}

/// What ended the row.
enum Ended {
    /// A stage before mapping; the map can still be finished.
    Before(StageFailure),
    Map(MapEnd),
}

impl Line<'_> {
    /// All frames, then what is still to come.
    fn work(&mut self, fetched: Receiver<Fetched>, tracking: &mut TrackLog, out: &mut Out<'_>) -> MapEnd {
        let mut failure = None;
        for fetched in fetched {
            match self.frame(fetched, tracking, out) {
                Ok(()) => {}
                Err(Ended::Map(end)) => return end,
                Err(Ended::Before(stage)) => {
                    failure = Some(stage);
                    break;
                }
            }
            if self.job.is_stopped() {
                break;
            }
        }
        let (rule, stop) = (self.job.setup.rule(), self.job.stop);
        let map = &mut self.map.0;
        match map_caught(|| map.finish(rule, stop, out)) {
            Ok(()) => MapEnd { is_whole: true, failure },
            Err(end) => MapEnd { failure: failure.or(end.failure), ..end },
        }
    }

    fn frame(&mut self, fetched: Fetched, tracking: &mut TrackLog, out: &mut Out<'_>) -> Result<(), Ended> {
        let n = fetched.n;
        let (extract, faults) = &mut self.extract;
        let extracted = caught("extract", || {
            faults.step();
            extract.extract(fetched)
        });
        let extracted = extracted.map_err(Ended::Before)?;
        let ((track, faults), viewer) = (&mut self.track, &mut self.viewer);
        let message = caught("track", || {
            faults.step();
            track.step(extracted, |_| viewer.at(n), tracking, out.emit)
        });
        // In turn, the state of the rule is always there.
        let Ok(Some(message)) = message.map_err(Ended::Before)? else { return Ok(()) };
        if message.keyframe.is_some() {
            self.viewer.request(n);
        }
        self.map(&message, out).map_err(Ended::Map)
    }

    fn map(&mut self, message: &Message, out: &mut Out<'_>) -> Result<(), MapEnd> {
        let rule = self.job.setup.rule();
        let (map, faults) = &mut self.map;
        map_caught(|| {
            faults.step();
            map.follow(message, rule, out)
        })
    }
}
