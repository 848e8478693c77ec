//! All observers of a run.

use std::path::Path;

use anyhow::Context;
use dsslam::mcap::McapRecorder;
use events::FILE_NAME;
use runtime::{Event, EventStream, Observer, RunOutcome, StreamOptions, StreamReport};

use super::process::Ended;
use super::yielding::{Room, YieldingFile};
use super::{Manner, ViewerProcess, start};
use crate::console;
use crate::exit::{Failure, OrExit};
use crate::job::Job;
use crate::progress::Progress;
use crate::report;
use crate::summary::Summary;

/// The person at the terminal, and the streams of events that are wanted.
pub(crate) struct Audience {
    /// What the person sees.
    pub(crate) progress: Progress,
    /// To `events.dslog`.
    file: Option<EventStream>,
    /// What that file takes of the disk.
    room: Option<Room>,
    /// The MCAP file.
    mcap: Option<McapRecorder>,
    /// To the viewer.
    viewer: Option<(EventStream, ViewerProcess)>,
}

impl Audience {
    /// Opens the streams that the job asks for. Without any, nothing is done for them during the run.
    ///
    /// # Errors
    /// A file that cannot be made, a viewer that cannot be started.
    pub(crate) fn gather(job: &Job) -> Result<Self, Failure> {
        let (show, path) = (&job.wishes.show, job.folder.file(FILE_NAME));
        let options = StreamOptions { image_every: show.rerun_every, ..StreamOptions::default() };
        let mut audience =
            Audience { progress: Progress::new(), file: None, room: None, mcap: None, viewer: None };
        if show.events {
            let target = YieldingFile::create(&path)
                .with_context(|| format!("{}: cannot be written", path.display()))
                .or_output()?;
            audience.room = Some(target.room());
            let stream = EventStream::start(Box::new(target), start::of_job(job), options);
            audience.file = Some(stream.or_output()?);
        } else {
            // A file from an older run in the same folder would belong to that run.
            let _ = std::fs::remove_file(&path);
        }
        let mcap = show.mcap.as_deref().map(|file| McapRecorder::create(file, &job.session));
        audience.mcap = mcap.transpose().or_output()?;
        if let (Some(program), Some(manner)) = (&job.viewer, Manner::of_run(show)) {
            let (process, pipe) = ViewerProcess::start(program, None, &manner).or_input()?;
            // A pipe is as bounded as its reader makes it.
            let options = StreamOptions { max_bytes: u64::MAX, ..options };
            if let Some(pipe) = pipe {
                let stream = EventStream::start(Box::new(pipe), start::of_job(job), options).or_output()?;
                audience.viewer = Some((stream, process));
            }
        }
        Ok(audience)
    }

    /// Gives up the file of events, if there is one, so that something more important can be written.
    pub(crate) fn make_room(&self) {
        if let Some(room) = &self.room {
            room.give();
        }
    }

    /// Ends the MCAP file, if there is one.
    ///
    /// # Errors
    /// What could not be written, now or during the run.
    pub(crate) fn finish_mcap(&mut self, outcome: &RunOutcome) -> anyhow::Result<()> {
        Ok(self.mcap.take().map_or(Ok(()), |recorder| recorder.finish(outcome))?)
    }

    /// The end: writes what is left to write and says what went wrong with it.
    pub(crate) fn leave(self, outcome: &RunOutcome, summary: &Summary, folder: &Path) {
        let numbers = report::text(summary, folder);
        let numbers = format!("```\n{}\n```\n", numbers.trim_end());
        if let Some(stream) = self.file {
            let report = stream.finish(outcome, numbers.clone());
            tell(FILE_NAME, &report);
        }
        let Some((stream, mut process)) = self.viewer else { return };
        let report = stream.finish(outcome, numbers);
        tell("the viewer", &report);
        if report.broken.is_some() {
            process.end();
            return;
        }
        match process.wait() {
            Ended::With(status) if status.success() => {}
            Ended::With(status) => console::note(console::warning(format!("the viewer ended with {status}"))),
            Ended::NotYet => console::note("the viewer is still busy and keeps running on its own"),
        }
    }
}

fn tell(name: &str, report: &StreamReport) {
    if let Some(reason) = &report.broken {
        console::note(console::warning(format!("{name}: {reason}; the run continued without it")));
    } else if report.left_out > 0 {
        console::note(format!("{name}: {} images or map states were skipped", report.left_out));
    }
}

impl Observer for Audience {
    fn event(&mut self, event: &Event) {
        self.progress.event(event);
        if let Some(stream) = &mut self.file {
            stream.event(event);
        }
        if let Some(recorder) = &mut self.mcap {
            recorder.event(event);
        }
        if let Some((stream, _)) = &mut self.viewer {
            stream.event(event);
        }
    }

    fn wants_details(&self) -> bool {
        self.file.is_some() || self.mcap.is_some() || self.viewer.is_some()
    }
}
