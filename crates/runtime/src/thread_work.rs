//! What the threads of a run do between their channels.

use crossbeam::channel::{Receiver, Sender};
use slam::World;

use crate::events::Event;
use crate::extract::{ExtractStage, Extracted};
use crate::failure::{Halt, StageFailure, caught, map_caught};
use crate::fetch::{Fetched, replace};
use crate::job::Job;
use crate::journal::Seen;
use crate::map_log::MapLog;
use crate::mapping::{MapStage, Out};
use crate::outbox::Outbox;
use crate::record::Unusable;
use crate::service::Asked;
use crate::threads::Manner;
use crate::timings::Stopwatch;
use crate::track::{Message, TrackLog, TrackStage};
use crate::view::{Published, Viewer};

/// What the tracking thread leaves.
pub(crate) struct TrackLeft {
    pub(crate) log: TrackLog,
    /// Kept until mapping has ended, so that its last state can be seen.
    pub(crate) viewer: Option<Viewer>,
    pub(crate) failure: Option<StageFailure>,
}

impl TrackLeft {
    pub(crate) fn nothing(failure: StageFailure) -> Self {
        TrackLeft { log: TrackLog::default(), viewer: None, failure: Some(failure) }
    }
}

/// What the mapping thread leaves.
pub(crate) struct MapLeft {
    pub(crate) log: MapLog,
    /// `None` after a panic in the middle of an operation.
    pub(crate) world: Option<World>,
    pub(crate) failure: Option<StageFailure>,
}

impl MapLeft {
    pub(crate) fn nothing(failure: StageFailure) -> Self {
        MapLeft { log: MapLog::default(), world: None, failure: Some(failure) }
    }
}

/// Extracts features until no frame comes or nobody wants any more.
pub(crate) fn extract(job: &Job<'_>, fetched: &Receiver<Fetched>, to_track: &Sender<Extracted>) {
    let mut stage = ExtractStage::new(&job.plan);
    let mut faults = job.plan.faults("extract");
    for fetched in fetched {
        faults.step();
        if to_track.send(stage.extract(fetched)).is_err() {
            return;
        }
    }
}

/// Tracks until no frame comes, mapping is gone or the run is to stop.
pub(crate) fn track(
    job: &Job<'_>,
    extracted: Receiver<Extracted>,
    mut viewer: Viewer,
    mut outbox: Outbox,
    to_observer: Sender<Event>,
) -> TrackLeft {
    let mut log = TrackLog::default();
    let ended = caught("track", || {
        track_all(job, extracted, &mut viewer, &mut outbox, &mut log, &to_observer);
    });
    outbox.close();
    TrackLeft { log, viewer: Some(viewer), failure: ended.err() }
}

fn track_all(
    job: &Job<'_>,
    extracted: Receiver<Extracted>,
    viewer: &mut Viewer,
    outbox: &mut Outbox,
    log: &mut TrackLog,
    to_observer: &Sender<Event>,
) {
    let mut stage = TrackStage::new(&job.plan);
    let mut faults = job.plan.faults("track");
    // Without an observer there is nobody to tell.
    let emit = &mut |event: Event| drop(to_observer.send(event));
    for extracted in extracted {
        faults.step();
        let n = extracted.n;
        note_skipped(job, n, log, emit);
        let view = |watch: &mut Stopwatch| watch.time("wait", |_| viewer.at(n));
        match stage.step(extracted, view, log, emit) {
            Ok((_, Some(message))) => {
                if message.keyframe.is_some() {
                    viewer.request(n);
                }
                if outbox.send(message).is_err() {
                    return;
                }
            }
            Ok((_, None)) => {}
            Err(_) => return,
        }
        if job.is_stopped() {
            return;
        }
    }
}

/// Records the frames before the `n`-th that were replaced by newer ones.
fn note_skipped(job: &Job<'_>, n: usize, log: &mut TrackLog, emit: &mut dyn FnMut(Event)) {
    for skipped in log.frames.len()..n {
        let info = job.feed.info(skipped);
        let watch = Stopwatch::new(info.index);
        log.without_tracking((info, Unusable::Skipped), Seen::Skipped, watch, emit);
    }
}

/// Maps until tracking or a service is gone.
pub(crate) fn map(
    job: &Job<'_>,
    manner: Manner,
    mut stage: MapStage,
    messages: Receiver<Message>,
    (publish, shown): (Sender<Published>, Receiver<Published>),
    to_observer: Sender<Event>,
) -> MapLeft {
    let mut log = MapLog::default();
    let mut emit = |event: Event| drop(to_observer.send(event));
    let mut publish = |state: Published| match manner {
        Manner::Lockstep => drop(publish.send(state)),
        Manner::Live { .. } => replace(&publish, &shown, state),
    };
    let mut out = Out { log: &mut log, emit: &mut emit, publish: &mut publish };
    let ended = map_caught(|| match manner {
        Manner::Lockstep => map_by_rule(job, &mut stage, messages, &mut out),
        Manner::Live { .. } => {
            let mut faults = job.plan.faults("map");
            stage.live(&messages, (job.plan.setup.rule(), job.stop), &mut faults, &mut out)
        }
    });
    let (is_whole, failure) = ended.map_or_else(|end| (end.is_whole, end.failure), |()| (true, None));
    MapLeft { log, world: is_whole.then(|| stage.mapper.into_world()), failure }
}

fn map_by_rule(
    job: &Job<'_>,
    stage: &mut MapStage,
    messages: Receiver<Message>,
    out: &mut Out<'_>,
) -> Result<(), Halt> {
    let (rule, mut faults) = (job.plan.setup.rule(), job.plan.faults("map"));
    for message in messages {
        faults.step();
        stage.follow(&message, rule, out)?;
    }
    stage.finish(rule, job.stop, out)
}

/// Answers every question, in order.
pub(crate) fn serve<Q, A>(asked: &Receiver<Asked<Q, A>>, mut work: impl FnMut(Q) -> A) {
    for (question, back) in asked {
        // Whoever asked may not want to know any more.
        let _ = back.send(work(question));
    }
}

/// Answers the newest question; older ones are those that were given up.
pub(crate) fn serve_newest<Q, A>(asked: &Receiver<Asked<Q, A>>, mut work: impl FnMut(Q) -> A) {
    for mut next in asked {
        next = asked.try_iter().last().unwrap_or(next);
        let _ = next.1.send(work(next.0));
    }
}
