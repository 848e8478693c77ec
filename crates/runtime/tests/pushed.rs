//! Frames that the caller pushes: the bits of a run over the same frames, and an orderly end whatever happens.
#![allow(clippy::unwrap_used, reason = "a test stops at the first problem")]

mod common;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use common::{Feed, Kind, setup};
use dsslam_runtime::{
    Event, Faults, FrameAnswer, FrameFeed, FrameStatus, Observer, RunOutcome, Schedule, Selection,
    Sequential, Setup, Silent, Threaded, Unusable, run,
};
use features::{ActivationError, ActivationMap, ActivationSource, SelectionConfig, SelectionRule, Spread};
use geometry::{GrayImage, Raster};

/// Frames of which some are unusable.
fn feed() -> Feed {
    use Kind::{Black, Broken, Good, NoRight};
    Feed(vec![Broken, Black, Good, Good, Good, NoRight, Good, Good])
}

/// Everything of a run that must not depend on how the frames come.
fn bits(outcome: &RunOutcome) -> (Vec<dsslam_runtime::FrameRecord>, u64, bool) {
    (outcome.frames.clone(), outcome.map.digest(), outcome.interrupted)
}

fn in_one_go() -> RunOutcome {
    run(&feed(), &setup(), &mut Silent, &AtomicBool::new(false)).unwrap()
}

/// Remembers the answers about frames.
#[derive(Default)]
struct Answers(Vec<FrameAnswer>);

impl Observer for Answers {
    fn event(&mut self, event: &Event) {
        if let Event::Frame(answer) = event {
            self.0.push(answer.as_ref().clone());
        }
    }
}

/// Equal but for the time that it took.
fn without_times(answers: &[FrameAnswer]) -> Vec<FrameAnswer> {
    let mut answers = answers.to_vec();
    answers.iter_mut().for_each(|answer| answer.track_ms = 0.0);
    answers
}

#[test]
fn frames_pushed_in_turn_give_the_bits_of_a_run_and_an_answer_each() {
    let (feed, mut heard, mut slam) = (feed(), Answers::default(), Sequential::new(setup()));
    let step = |i: usize, slam: &mut Sequential, heard: &mut Answers| {
        slam.step(feed.info(i), feed.load(i), None, heard).unwrap()
    };
    let answers: Vec<FrameAnswer> = (0..8).map(|i| step(i, &mut slam, &mut heard)).collect();
    assert_eq!(answers, heard.0, "an answer is what observers hear");
    let outcome = slam.finish(&mut heard);
    assert_eq!(bits(&outcome), bits(&in_one_go()));
    assert_eq!(outcome.journal, in_one_go().journal);
    let posed: Vec<bool> = answers.iter().map(|answer| answer.world_from_cam.is_some()).collect();
    assert_eq!(posed, outcome.frames.iter().map(|frame| frame.status.has_pose()).collect::<Vec<_>>());
    // The frame that starts the map is asked for as its first keyframe, at the origin; the next ones see it.
    assert!(answers[2].keyframe.is_some() && answers[2].submap.is_none());
    assert_eq!(answers[2].world_from_cam.unwrap().translation.norm(), 0.0);
    assert_eq!(answers[3].submap, outcome.map.roots().first().copied());
    assert_eq!(answers[5].status, FrameStatus::Dropped(Unusable::Missing("right")));
}

#[test]
fn frames_pushed_to_threads_give_the_bits_of_a_run() {
    let threaded = Setup { schedule: Schedule::Lockstep, ..setup() };
    let slam = Threaded::start(threaded).unwrap();
    let (feed, mut answers) = (feed(), Vec::new());
    for i in 0..8 {
        slam.push(feed.info(i), feed.load(i), None).unwrap();
        // Some are waited for, the others are left for the end.
        if i < 4 {
            answers.push(slam.answer().unwrap());
        }
    }
    let (outcome, rest) = slam.finish().unwrap();
    answers.extend(rest);
    assert_eq!(bits(&outcome), bits(&in_one_go()));
    let mut expected = Answers::default();
    run(&feed, &setup(), &mut expected, &AtomicBool::new(false)).unwrap();
    assert_eq!(without_times(&answers), without_times(&expected.0));
}

/// Trusts the half of the image that a pixel of it decides on.
#[derive(Debug)]
struct Halves;

impl ActivationSource for Halves {
    fn activation(&self, image: &GrayImage) -> Result<ActivationMap, ActivationError> {
        let trusts_left = image.at(20, 20).is_multiple_of(2);
        let values = Raster::from_fn(16, 10, |x, _| if (x < 8) == trusts_left { 1.0 } else { 0.3 });
        ActivationMap::new(values, image.width, image.height).ok_or(ActivationError::Unknown)
    }
}

#[test]
fn answers_of_a_network_serve_the_same_frames_by_every_schedule() {
    let of = |schedule: Schedule, delays: Option<u64>| {
        let config = SelectionConfig { rule: SelectionRule::Activation, keep: 150, spread: Spread::Cells };
        let mut setup = Setup { schedule, faults: Faults { delays, ..Faults::default() }, ..setup() };
        setup.extractor.network_every = 2;
        setup.selection = Some(Selection { config, source: Arc::new(Halves), identity: 0 });
        let outcome = run(&feed(), &setup, &mut Silent, &AtomicBool::new(false)).unwrap();
        assert!(outcome.frames.iter().filter(|frame| frame.status.has_pose()).count() > 3);
        bits(&outcome)
    };
    let expected = of(Schedule::Sequential, None);
    for delays in [None, Some(1), Some(2)] {
        assert_eq!(of(Schedule::Lockstep, delays), expected, "{delays:?}");
    }
}

#[test]
fn a_live_run_in_real_time_answers_for_every_frame_in_order() {
    let live = Setup { schedule: Schedule::Live { realtime: true }, ..setup() };
    let slam = Threaded::start(live).unwrap();
    let feed = Feed(vec![Kind::Good; 40]);
    (0..40).for_each(|i| slam.push(feed.info(i), feed.load(i), None).unwrap());
    let (outcome, answers) = slam.finish().unwrap();
    let order: Vec<u32> = answers.iter().map(|answer| answer.index).collect();
    assert_eq!(order, (0..40).collect::<Vec<u32>>());
    assert_eq!((outcome.frames.len(), outcome.failure, outcome.map.check()), (40, None, Ok(())));
}

#[test]
fn without_frames_the_results_are_empty() {
    let outcome = Sequential::new(setup()).finish(&mut Silent);
    assert_eq!((outcome.frames.len(), outcome.map.n_keyframes(), outcome.interrupted), (0, 0, false));
    for schedule in [Schedule::Lockstep, Schedule::Live { realtime: false }] {
        let slam = Threaded::start(Setup { schedule, ..setup() }).unwrap();
        let (outcome, answers) = slam.finish().unwrap();
        assert_eq!((outcome.frames.len(), answers.len(), outcome.interrupted), (0, 0, false));
    }
}

#[test]
fn a_stage_that_panics_is_named_at_every_later_step_and_the_rest_is_left() {
    let feed = Feed(vec![Kind::Good; 8]);
    for stage in ["extract", "track", "map"] {
        let faults = Faults { panic_at: Some((stage, 3)), ..Faults::default() };
        let mut slam = Sequential::new(Setup { faults, ..setup() });
        for i in 0..8 {
            let stepped = slam.step(feed.info(i), feed.load(i), None, &mut Silent);
            assert_eq!(
                stepped.map_err(|failure| failure.stage).err(),
                (i >= 3).then_some(stage),
                "frame {i}"
            );
        }
        let outcome = slam.finish(&mut Silent);
        assert_eq!(
            outcome.failure.unwrap().to_string(),
            format!("the stage `{stage}` failed: asked to fail at step 3")
        );
        assert!(outcome.frames.len() >= 3 && outcome.map.check() == Ok(()));
    }
}

#[test]
fn a_panic_on_a_thread_ends_the_pushing_and_is_part_of_the_results() {
    let faults = Faults { panic_at: Some(("track", 3)), ..Faults::default() };
    let slam = Threaded::start(Setup { faults, schedule: Schedule::Lockstep, ..setup() }).unwrap();
    let feed = Feed(vec![Kind::Good; 200]);
    let refused = (0..200).find(|&i| slam.push(feed.info(i), feed.load(i), None).is_err());
    assert!(refused.is_some_and(|i| i >= 3), "{refused:?}");
    let heard = std::iter::from_fn(|| slam.answer()).count();
    assert_eq!(heard, 3, "the answers before the panic, then the end");
    assert_eq!(slam.finish().unwrap().0.failure.unwrap().stage, "track");
}

#[test]
fn a_run_that_is_dropped_ends() {
    let feed = Feed(vec![Kind::Good; 3]);
    for schedule in [Schedule::Lockstep, Schedule::Live { realtime: true }] {
        let slam = Threaded::start(Setup { schedule, ..setup() }).unwrap();
        (0..3).for_each(|i| slam.push(feed.info(i), feed.load(i), None).unwrap());
        drop(slam);
    }
    let mut slam = Sequential::new(setup());
    slam.step(feed.info(0), feed.load(0), None, &mut Silent).unwrap();
    drop(slam);
}
