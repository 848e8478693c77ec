//! `Lockstep`, and what `Live` has in common with it: a thread per stage, joined by bounded channels. A stage ends when a neighbor is
//! gone.

use std::any::Any;
use std::sync::Arc;
use std::thread::{Builder, Scope, ScopedJoinHandle};

use crossbeam::channel::{Receiver, Sender, bounded};
use rayon::ThreadPoolBuilder;
use slam::World;

use crate::events::{Event, Observer};
use crate::failure::{StageFailure, caught, map_caught};
use crate::live::{MESSAGES, Outbox, paced, replace};
use crate::outcome::{MapLog, Parts};
use crate::record::RunError;
use crate::run::Job;
use crate::services::{
    Asked, GlobalAnswer, GlobalQuestion, LoopAnswer, LoopQuestion, Service, adjust, find_loops, serve,
    serve_newest,
};
use crate::setup::Schedule;
use crate::snapshot::{EXACT_STATES, Published, Snapshots};
use crate::stages::extract::extract;
use crate::stages::fetch::{AHEAD, Extracted, ahead};
use crate::stages::map::{MapStage, Out};
use crate::stages::track::{Message, TrackLog, track};

/// Events that may wait for the observer.
const EVENTS: usize = 256;
/// Questions that may wait for a service.
const QUESTIONS: usize = 64;

/// Frames with features that may wait for tracking, so that extraction goes on while tracking waits for the map.
const EXTRACTED_AHEAD: usize = 4;

/// A running stage.
type Stage<'scope, T> = ScopedJoinHandle<'scope, Result<T, StageFailure>>;

/// What the tracking thread leaves.
#[derive(Default)]
pub(crate) struct TrackLeft {
    pub(crate) log: TrackLog,
    /// Kept until mapping has ended, so that its last state can be seen.
    pub(crate) snapshots: Option<Snapshots>,
    pub(crate) failure: Option<StageFailure>,
}

/// What the mapping thread leaves.
#[derive(Default)]
pub(crate) struct MapLeft {
    pub(crate) log: MapLog,
    /// `None` after a panic in the middle of an operation.
    pub(crate) world: Option<World>,
    pub(crate) failure: Option<StageFailure>,
}

/// Runs; the calling thread hands events to the observer meanwhile.
pub(crate) fn run(job: &Job<'_>, observer: &mut dyn Observer) -> Result<Parts, RunError> {
    std::thread::scope(|scope| {
        let (to_observer, events) = bounded(EVENTS);
        let stages = Stages::start(scope, job, to_observer)?;
        events.iter().for_each(|event| observer.event(&event));
        Ok(stages.join(job))
    })
}

/// Starts the thread of a stage.
pub(crate) fn spawn<'scope, T: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    stage: &'static str,
    work: impl FnOnce() -> T + Send + 'scope,
) -> Result<Stage<'scope, T>, RunError> {
    Builder::new()
        .name(stage.into())
        .spawn_scoped(scope, move || caught(stage, work))
        .map_err(|error| RunError::Thread { stage, reason: error.to_string() })
}

/// Starts the thread of a stage whose parallel loops have workers of their own, half as many as extraction has: with
/// common workers they would queue behind those of extraction, which is always busy.
fn spawn_with_workers<'scope, T: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    stage: &'static str,
    work: impl FnOnce() -> T + Send + 'scope,
) -> Result<Stage<'scope, T>, RunError> {
    let workers = ThreadPoolBuilder::new()
        .num_threads(rayon::current_num_threads().div_ceil(2))
        .thread_name(move |i| format!("{stage}-{i}"))
        .build()
        .map_err(|error| RunError::Thread { stage, reason: error.to_string() })?;
    spawn(scope, stage, move || workers.install(work))
}

/// What a stage left.
pub(crate) fn joined<T>(stage: Stage<'_, T>) -> Result<T, StageFailure> {
    let unwound = |_: Box<dyn Any + Send>| StageFailure { stage: "?", message: "ended by a panic".into() };
    stage.join().map_err(unwound).and_then(|result| result)
}

/// The threads of a run, in the order of the pipeline.
struct Stages<'scope> {
    decode: Stage<'scope, usize>,
    extract: Stage<'scope, ()>,
    track: Stage<'scope, TrackLeft>,
    map: Stage<'scope, MapLeft>,
    finders: Option<Stage<'scope, ()>>,
    global: Stage<'scope, ()>,
}

impl<'scope> Stages<'scope> {
    fn start<'env>(
        scope: &'scope Scope<'scope, 'env>,
        job: &'env Job<'env>,
        to_observer: Sender<Event>,
    ) -> Result<Self, RunError> {
        let (reader, reader_is_there) = bounded(0);
        let (extracted, decode, extract) = start_source(scope, job, reader_is_there)?;
        let rule = job.exact_rule();
        let (publish, states) = bounded(if rule.is_some() { EXACT_STATES } else { 1 });
        let (to_mapping, messages) = bounded(MESSAGES);
        let (map_stage, finders, global) = start_services(scope, job)?;
        let map = {
            let (to_observer, states) = (to_observer.clone(), states.clone());
            spawn_with_workers(scope, "map", move || {
                map(job, map_stage, messages, (publish, states), to_observer)
            })?
        };
        let snapshots = Snapshots::new(rule, job.plan.start(), states);
        let outbox = Outbox::new(to_mapping, rule.is_some());
        let track = spawn_with_workers(scope, "track", move || {
            let left = track(job, extracted, snapshots, outbox, to_observer);
            drop(reader);
            left
        })?;
        Ok(Stages { decode, extract, track, map, finders, global })
    }

    /// Waits for all stages and collects what they left.
    fn join(self, job: &Job<'_>) -> Parts {
        let decoded = joined(self.decode);
        let frames = decoded.as_ref().copied().unwrap_or(job.limit());
        let mut failures = [decoded.err(), joined(self.extract).err()].to_vec();
        let mut track = joined(self.track)
            .unwrap_or_else(|failure| TrackLeft { failure: Some(failure), ..TrackLeft::default() });
        let map = joined(self.map)
            .unwrap_or_else(|failure| MapLeft { failure: Some(failure), ..MapLeft::default() });
        failures.extend([track.failure.take(), map.failure]);
        failures.extend(self.finders.into_iter().chain([self.global]).map(|stage| joined(stage).err()));
        let last_shown = track.snapshots.map_or_else(|| job.plan.start(), |mut snapshots| snapshots.newest());
        Parts {
            tracking: track.log,
            mapping: map.log,
            world: map.world.unwrap_or_else(|| Arc::unwrap_or_clone(last_shown)),
            frames,
            failure: failures.into_iter().flatten().next(),
        }
    }
}

/// The threads in front of tracking. A realtime run has room for one decoded frame only, which a newer one replaces.
#[allow(clippy::type_complexity, reason = "three things, used once")]
fn start_source<'scope, 'env>(
    scope: &'scope Scope<'scope, 'env>,
    job: &'env Job<'env>,
    reader_is_there: Receiver<()>,
) -> Result<(Receiver<Extracted>, Stage<'scope, usize>, Stage<'scope, ()>), RunError> {
    let realtime = job.plan.setup.schedule == Schedule::Live { realtime: true };
    let (to_extract, fetched) = bounded(if realtime { 1 } else { AHEAD });
    let (to_track, extracted) = bounded(if realtime { 0 } else { EXTRACTED_AHEAD });
    let (taken, faults) = (fetched.clone(), job.plan.faults("decode"));
    let decode = spawn(scope, "decode", move || {
        if realtime {
            paced(job.feed, job.limit(), faults, (&to_extract, &taken), &reader_is_there)
        } else {
            drop(taken);
            ahead(job.feed, job.limit(), faults, &to_extract)
        }
    })?;
    let extract = spawn(scope, "extract", move || extract(job, &fetched, &to_track))?;
    Ok((extracted, decode, extract))
}

/// The mapping stage with services on threads.
#[allow(clippy::type_complexity, reason = "three things, used once")]
fn start_services<'scope, 'env>(
    scope: &'scope Scope<'scope, 'env>,
    job: &'env Job<'env>,
) -> Result<(MapStage, Option<Stage<'scope, ()>>, Stage<'scope, ()>), RunError> {
    let (to_global, asked) = bounded::<Asked<GlobalQuestion, GlobalAnswer>>(QUESTIONS);
    let work = adjust(&job.plan.setup, job.plan.faults("global"));
    let global = spawn_with_workers(scope, "global", move || serve_newest(&asked, work))?;
    let (mut loops, mut finders) = (None, None);
    if job.plan.wants_loops() {
        let (to_loops, asked) = bounded::<Asked<LoopQuestion, LoopAnswer>>(QUESTIONS);
        let work = find_loops(&job.plan.setup, job.plan.faults("loop"));
        finders = Some(spawn_with_workers(scope, "loop", move || serve(&asked, work))?);
        loops = Some(Service::Thread(to_loops));
    }
    let stage = MapStage::new(&job.plan, loops, Service::Thread(to_global));
    Ok((stage, finders, global))
}

/// Maps until tracking or a service thread has ended.
pub(crate) fn map(
    job: &Job<'_>,
    mut stage: MapStage,
    messages: Receiver<Message>,
    (publish, shown): (Sender<Published>, Receiver<Published>),
    to_observer: Sender<Event>,
) -> MapLeft {
    let mut log = MapLog::default();
    let mut emit = |event: Event| drop(to_observer.send(event));
    let rule = job.exact_rule();
    let mut publish = |state: Published| match rule {
        Some(_) => drop(publish.send(state)),
        None => replace(&publish, &shown, state),
    };
    let mut out = Out { log: &mut log, emit: &mut emit, publish: &mut publish };
    let mut faults = job.plan.faults("map");
    let ended = map_caught(|| match rule {
        Some(rule) => {
            for message in messages {
                faults.step();
                stage.take_in(&message, Some(rule), &mut out)?;
            }
            stage.finish(rule, job.stop, &mut out)
        }
        None => stage.live(&messages, (job.plan.setup.rule(), job.stop), &mut faults, &mut out),
    });
    let (is_whole, failure) = ended.map_or_else(|end| (end.is_whole, end.failure), |()| (true, None));
    MapLeft { log, world: is_whole.then(|| stage.mapper.into_world()), failure }
}
