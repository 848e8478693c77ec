//! One run, many schedules: the same bits in turn, on threads, under delays and from a journal; and what is left when a
//! stage fails.

use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use geometry::SE3;
use runtime::{
    Faults, FrameFeed, FrameStatus, Journal, JournalError, Lags, LoopResult, RunError, RunOutcome, Schedule,
    Setup, Silent, Unusable, replay, run,
};

use crate::rendered_feed::RenderedFeed;

/// Along a street, then a jump back to its beginning and along it again: lost, a new sub-map, a loop that joins it to
/// the old one, a global bundle adjustment.
pub(crate) fn revisit() -> &'static RenderedFeed {
    static FEED: OnceLock<RenderedFeed> = OnceLock::new();
    FEED.get_or_init(|| RenderedFeed::new((30..62).chain(8..62)))
}

/// Loops as early as possible, since the drive is short.
pub(crate) fn setup(schedule: Schedule) -> Setup {
    let mut setup = Setup { schedule, lags: Lags { lag: 2, loop_lag: 4 }, ..revisit().setup() };
    setup.slam.camera.max_lost_frames = 2;
    setup.slam.loops.min_gap = 4;
    setup.slam.loops.consistency = 1;
    setup
}

fn done(feed: &dyn FrameFeed, setup: &Setup) -> RunOutcome {
    run(feed, setup, &mut Silent, &AtomicBool::new(false)).unwrap()
}

/// Everything in a run that must not depend on how its stages share time.
pub(crate) fn bits(outcome: &RunOutcome) -> (Vec<(FrameStatus, Option<SE3>)>, u64, usize) {
    let frames = outcome.frames.iter().map(|frame| (frame.status.clone(), frame.world_from_cam));
    (frames.collect(), outcome.map.digest(), outcome.loops.len())
}

/// The run in turn, made once.
pub(crate) fn in_turn() -> &'static RunOutcome {
    static OUTCOME: OnceLock<RunOutcome> = OnceLock::new();
    OUTCOME.get_or_init(|| done(revisit(), &setup(Schedule::Sequential)))
}

#[test]
fn the_drive_loses_its_way_starts_a_sub_map_and_joins_it() {
    let outcome = in_turn();
    let statistics = outcome.statistics;
    assert!(statistics.submaps_started >= 1 && statistics.submaps_joined >= 1, "{statistics:?}");
    assert!(statistics.globals_adopted >= 1, "{statistics:?}");
    let closed = outcome.loops.iter().find(|l| matches!(l.result, LoopResult::Closed { joined: true, .. }));
    let closed = closed.unwrap_or_else(|| panic!("{:?}", outcome.loops));
    assert!(closed.frame > 32 && closed.matched_frame < 32, "{closed:?}");
    assert_eq!(outcome.map.roots().len(), 1, "all is one map");
    let root = outcome.map.roots().first().copied();
    assert!(outcome.frames.iter().all(|frame| frame.submap == root), "and all poses are in it");
    assert_eq!((&outcome.failure, outcome.interrupted), (&None, false));
}

#[test]
fn delays_on_threads_change_nothing() {
    let faults = Faults { delays: Some(1), ..Faults::default() };
    let outcome = done(revisit(), &Setup { faults, ..setup(Schedule::Lockstep) });
    assert!(bits(&outcome) == bits(in_turn()), "other bits");
    assert_eq!(outcome.statistics, in_turn().statistics);
    assert_eq!(outcome.journal, in_turn().journal);
}

#[test]
fn the_lag_is_part_of_the_result() {
    let first = RenderedFeed::new(0..14);
    let of = |lag: usize, schedule: Schedule| {
        bits(&done(&first, &Setup { lags: Lags { lag, loop_lag: 4 }, ..setup(schedule) }))
    };
    let one = of(1, Schedule::Sequential);
    assert!(one == of(1, Schedule::Lockstep));
    assert!(one != of(4, Schedule::Sequential), "a lag without effect");
}

#[test]
fn a_journal_does_a_run_in_turn_again() {
    let outcome = in_turn();
    let journal = Journal::from_json(&outcome.journal.to_json()).unwrap();
    let again =
        replay(revisit(), &setup(Schedule::Sequential), &journal, &mut Silent, &AtomicBool::new(false))
            .unwrap();
    assert!(bits(&again) == bits(outcome), "other bits");
    assert_eq!((again.journal, again.statistics), (journal, outcome.statistics));
}

#[test]
fn a_journal_does_a_live_run_again() {
    let faults = Faults { delays: Some(5), ..Faults::default() };
    let live = Setup { faults, ..setup(Schedule::Live { realtime: false }) };
    let outcome = done(revisit(), &live);
    // How well it tracks depends on the machine.
    assert_eq!(outcome.frames.len(), revisit().len());
    let again = replay(revisit(), &live, &outcome.journal, &mut Silent, &AtomicBool::new(false)).unwrap();
    assert!(bits(&again) == bits(&outcome), "other bits");
    assert_eq!(again.journal, outcome.journal);
}

#[test]
fn a_live_run_in_real_time_skips_frames_and_its_journal_knows_which() {
    // A frame per millisecond is too fast for any machine.
    let feed = RenderedFeed::new(0..30).paced(0.001);
    (0..feed.len()).for_each(|i| drop(feed.load(i)));
    let live = setup(Schedule::Live { realtime: true });
    let outcome = done(&feed, &live);
    let skipped = FrameStatus::Dropped(Unusable::Skipped);
    let n_skipped = outcome.frames.iter().filter(|frame| frame.status == skipped).count();
    assert_eq!(outcome.frames.len(), 30);
    assert!((5..30).contains(&n_skipped), "{n_skipped} skipped");
    assert!(outcome.frames[29].status != skipped, "the newest frame is always taken");
    let again = replay(&feed, &live, &outcome.journal, &mut Silent, &AtomicBool::new(false)).unwrap();
    assert!(bits(&again) == bits(&outcome), "other bits");
}

#[test]
fn a_journal_of_something_else_is_refused() {
    let journal = &in_turn().journal;
    let refused = |feed: &RenderedFeed, setup: &Setup| {
        replay(feed, setup, journal, &mut Silent, &AtomicBool::new(false)).unwrap_err()
    };
    let mut other = setup(Schedule::Sequential);
    other.slam.seed += 1;
    assert_eq!(refused(revisit(), &other), RunError::Journal(JournalError::OtherSetup));
    let setup = setup(Schedule::Sequential);
    let short = RenderedFeed::new(0..3);
    assert_eq!(
        refused(&short, &setup),
        RunError::Journal(JournalError::TooLong { frames: revisit().len(), available: 3 })
    );
    // Frames from elsewhere: there, other frames asked for keyframes.
    let elsewhere = RenderedFeed::new((300..332).chain(8..62));
    let error = refused(&elsewhere, &setup).to_string();
    assert!(
        error.starts_with("the journal cannot be replayed: the journal does not match these frames: "),
        "{error}"
    );
}

#[test]
fn a_stage_that_fails_is_named_and_what_was_computed_is_left() {
    let short = RenderedFeed::new(0..24);
    for schedule in [Schedule::Sequential, Schedule::Lockstep, Schedule::Live { realtime: false }] {
        // The step of each stage at which it fails, after some frames.
        for (stage, step) in [("decode", 16), ("extract", 16), ("track", 16), ("map", 16), ("loop", 2)] {
            check_failure(&short, schedule, stage, step);
        }
    }
    // A live run may see no loop, so that there is nothing to adjust.
    check_failure(revisit(), Schedule::Sequential, "global", 0);
    check_failure(revisit(), Schedule::Lockstep, "global", 0);
}

#[track_caller]
fn check_failure(feed: &RenderedFeed, schedule: Schedule, stage: &'static str, step: usize) {
    let faults = Faults { panic_at: Some((stage, step)), ..Faults::default() };
    let outcome = done(feed, &Setup { faults, ..setup(schedule) });
    let context = format!("{stage} under {schedule:?}");
    let failure = outcome.failure.unwrap_or_else(|| panic!("{context}: no failure"));
    let expected = format!("the stage `{stage}` failed: asked to fail at step {step}");
    assert_eq!(failure.to_string(), expected, "{context}");
    let posed = outcome.frames.iter().filter(|frame| frame.world_from_cam.is_some()).count();
    assert!(posed >= 2, "{context}: {posed} poses of {}", outcome.frames.len());
    assert!(outcome.map.n_keyframes() >= 1, "{context}");
    assert_eq!(outcome.map.check(), Ok(()), "{context}");
}

#[test]
fn a_map_is_gone_on_with_and_in_localization_left_alone() {
    let first = done(&RenderedFeed::new(0..30), &setup(Schedule::Lockstep));
    let again = RenderedFeed::new(10..40);
    let mut further = Setup { start: Some(first.map.clone()), ..setup(Schedule::Lockstep) };
    let outcome = done(&again, &further);
    assert_eq!(outcome.statistics.relocalizations, 1, "{:?}", outcome.frames[0]);
    assert!(outcome.map.n_keyframes() > first.map.n_keyframes());
    assert_eq!(outcome.map.roots(), first.map.roots(), "no new sub-map");
    further.slam.tracking.localize_only = true;
    let outcome = done(&RenderedFeed::new(10..25), &further);
    let ids = |map: &map::Map| map.keyframes().map(|k| (k.id, k.cam_from_world)).collect::<Vec<_>>();
    assert_eq!(ids(&outcome.map), ids(&first.map));
    // Frame 20 of the first drive is frame 10 of the second.
    let found = outcome.frames[10].world_from_cam.unwrap().translation;
    let known = first.frames[20].world_from_cam.unwrap().translation;
    assert!((found - known).norm() < 0.05, "{found} {known}");
}
