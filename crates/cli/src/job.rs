//! A run from its first frame to its last file: what `run` and `demo` have in common.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use dsslam::submaps::{of_largest, submaps};
use dsslam::{Figures, Scale, Session, Verdict, scale_against_truth};
use io::Sequence;
use runtime::{FrameRecord, Journal, Schedule};

use crate::args::ShowArgs;
use crate::clock::StopWatch;
use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use crate::figures;
use crate::outputs::{self, Part};
use crate::report;
use crate::results::ResultsFolder;
use crate::show::{self, Audience};
use crate::stop;

/// What the command line asks of a run, beside its frames and parameters.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wishes {
    /// What to say before the run begins.
    pub(crate) opening: Option<String>,
    /// Where the results go, if not into a folder of their own.
    pub(crate) out: Option<PathBuf>,
    /// Whether a doubt refuses a result.
    pub(crate) is_strict: bool,
    /// Name of the built-in configuration that the layout of the sequence has chosen.
    pub(crate) preset: Option<&'static str>,
    /// What the user should know of that choice.
    pub(crate) notices: Vec<String>,
    /// The run to do again, instead of one by the setup's schedule.
    pub(crate) replay: Option<Journal>,
    /// Segment lengths of t_rel and r_rel, meters.
    pub(crate) lengths_m: Vec<f64>,
    /// Where the map at its end goes.
    pub(crate) save_map: Option<PathBuf>,
    /// Where its journal goes.
    pub(crate) journal: Option<PathBuf>,
    /// Who watches.
    pub(crate) show: ShowArgs,
    /// Whether standard output is for scripts.
    pub(crate) json: bool,
}

/// Everything that a run needs.
pub(crate) struct Job {
    /// The frames, the camera and the parameters.
    pub(crate) session: Session,
    /// What else is asked.
    pub(crate) wishes: Wishes,
    /// What the run rests on.
    pub(crate) figures: Figures,
    /// Where the files go.
    pub(crate) folder: ResultsFolder,
    /// The viewer's program, if one watches.
    pub(crate) viewer: Option<PathBuf>,
    /// Started with the command.
    pub(crate) watch: StopWatch,
}

impl Job {
    /// What is run on.
    pub(crate) fn sequence(&self) -> &Sequence {
        self.session.input().sequence()
    }

    /// How tracking and mapping are interleaved, in one word.
    pub(crate) fn schedule(&self) -> &'static str {
        match self.session.setup().schedule {
            _ if self.wishes.replay.is_some() => "replay",
            Schedule::Sequential => "sequential",
            Schedule::Lockstep => "lockstep",
            Schedule::Live { .. } => "live",
        }
    }
}

/// Checks what the run rests on, runs, writes the results folder and prints the report.
///
/// # Errors
/// A run that cannot begin is a fault of the input, a file that cannot be written one of the output.
pub(crate) fn run(session: Session, wishes: Wishes, watch: StopWatch) -> Result<Exit, Failure> {
    for file in [&wishes.save_map, &wishes.journal].into_iter().flatten() {
        show::check_writable(file).or_output()?;
    }
    let viewer = show::viewer(&wishes.show)?;
    let stop = stop::on_signal();
    wishes.opening.iter().for_each(console::note);
    let figures = figures::show(&session, wishes.is_strict)?;
    let name = &session.input().sequence().name;
    let folder = ResultsFolder::create(wishes.out.as_deref(), Path::new(""), name).or_output()?;
    execute(&Job { session, wishes, figures, folder, viewer, watch }, &stop)
}

fn execute(job: &Job, stop: &AtomicBool) -> Result<Exit, Failure> {
    let session = &job.session;
    let mut notices = [&job.wishes.notices[..], session.notices()].concat();
    for notice in &notices {
        console::note(console::warning(notice));
    }
    notices.extend(job.figures.doubts.iter().map(|doubt| doubt.text.clone()));
    let mut audience = Audience::gather(job)?;
    let finished = match &job.wishes.replay {
        None => session.run_until(&mut audience, stop).or_input()?,
        Some(journal) => session.replay(journal, &mut audience, stop).or_input()?,
    };
    let outcome = &finished.outcome;
    audience.progress.finish();
    for remark in session.input().feed().remarks().into_iter().chain(apart(&outcome.frames)) {
        console::note(console::warning(&remark));
        notices.push(remark);
    }
    let frames = of_largest(&outcome.frames);
    let whole = Part::new(&frames, job);
    let scale =
        whole.evaluation.as_ref().and_then(|evaluation| scale_against_truth(evaluation.as_ref().ok()?));
    let off_scale = scale.filter(Scale::is_off).map(|scale| scale.ratio);
    notices.extend(off_scale.map(warn_of_scale));
    let (summary, mut failures) = outputs::write(job, notices, &finished, &whole, &|| audience.make_room());
    failures.extend(audience.finish_mcap(outcome).err());
    audience.leave(outcome, &summary, job.folder.path());
    if job.wishes.json {
        console::say(serde_json::to_string_pretty(&summary).or_output()?);
    } else {
        console::say(report::text(&summary, job.folder.path()).trim_end());
    }
    let is_useful = judge(job, &outcome.frames, off_scale.is_some());
    if let Some(failure) = &outcome.failure {
        console::note(console::error(format!("{failure}; results so far have been written")));
    }
    for failure in &failures {
        console::note(console::error(format!("{failure:#}")));
    }
    Ok(match (&outcome.failure, outcome.interrupted) {
        _ if !failures.is_empty() => Exit::Output,
        (Some(_), _) => Exit::Failed,
        (None, true) => Exit::Interrupted,
        (None, false) if is_useful => Exit::Done,
        (None, false) => Exit::Unusable,
    })
}

/// What the user should know of a run in several sub-maps.
fn apart(frames: &[FrameRecord]) -> Option<String> {
    let found = submaps(frames);
    let largest = found.first().filter(|_| found.len() > 1)?;
    let name = largest.root.map_or("unknown".to_owned(), |root| root.to_string());
    Some(format!(
        "{} sub-maps are in unrelated coordinate frames: trajectory and errors are those of the largest ({name}, {} frames), the others \
         have files of their own",
        found.len(),
        largest.tracked
    ))
}

fn warn_of_scale(scale: f64) -> String {
    let text = format!(
        "estimated lengths are {scale:.3} times the true ones: baseline, unit of depth or unit of the ground truth is wrong"
    );
    console::note(console::warning(&text).event("doubt").with("rule", "scale"));
    text
}

/// Whether the run came to something; says why not.
fn judge(job: &Job, frames: &[FrameRecord], is_off_scale: bool) -> bool {
    let verdict = Verdict::of(frames);
    if !verdict.is_success() {
        let doubts: Vec<&str> = job.figures.doubts.iter().map(|doubt| doubt.text.as_str()).collect();
        let why = if doubts.is_empty() { String::new() } else { format!(" ({})", doubts.join("; ")) };
        console::note(console::error(format!("{verdict}{why}")));
    }
    let is_refused = job.wishes.is_strict && is_off_scale;
    if is_refused {
        console::note(console::error("refused by --strict, since the scale is doubtful"));
    }
    verdict.is_success() && !is_refused
}
