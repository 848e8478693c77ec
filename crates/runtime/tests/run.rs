//! A run over frames that are partly unusable: what is dropped, with which reason, and what is still there at the end.
#![allow(clippy::unwrap_used, reason = "a test stops at the first problem")]

mod common;

use std::sync::atomic::{AtomicBool, Ordering};

use common::{Feed, Kind, broken, setup};
use dsslam_runtime::{Event, FrameStatus, Observer, RunError, Schedule, Setup, Silent, run};
use slam::NotReady;

#[test]
fn unusable_frames_are_dropped_with_their_reasons() {
    for schedule in [Schedule::Sequential, Schedule::Lockstep, Schedule::Live { realtime: false }] {
        check_unusable_frames(schedule);
    }
}

fn check_unusable_frames(schedule: Schedule) {
    use Kind::{Black, Broken, Good, NoRight, OtherSize};
    let feed = Feed(vec![Broken, Black, Good, Broken, Good, NoRight, OtherSize, Good]);
    let setup = Setup { schedule, ..setup() };
    let outcome = run(&feed, &setup, &mut Silent, &AtomicBool::new(false)).unwrap();
    let status: Vec<_> = outcome.frames.iter().map(|frame| frame.status.clone()).collect();
    assert_eq!(status[0], FrameStatus::Dropped(broken()));
    assert_eq!(status[0].reason().unwrap(), "left.png: cannot be read: unexpected end of file");
    let nothing = NotReady::TooFewDepths { found: 0, needed: 100, features: 0 };
    assert_eq!(status[1], FrameStatus::NotReady(nothing));
    assert_eq!(status[3], FrameStatus::Dropped(broken()));
    assert_eq!(status[5].reason().unwrap(), "the right image is missing");
    assert_eq!(status[6].reason().unwrap(), "the right image is 160 x 200 pixels, expected 320 x 200");
    // When a live map starts is a matter of time.
    let tracked = if matches!(schedule, Schedule::Live { .. }) { &[2][..] } else { &[2, 4, 7] };
    for &i in tracked {
        assert!(status[i].has_pose(), "frame {i}: {:?}", status[i]);
    }
    let center = outcome.frames[7].world_from_cam.map_or(0.0, |pose| pose.translation.norm());
    assert!(center < 0.05, "a camera that stands still moved {center} m");
    assert_eq!(outcome.frames[1].world_from_cam, None);
    assert_eq!(outcome.frames[3].world_from_cam, outcome.frames[2].world_from_cam);
    assert!(!outcome.interrupted);
}

#[test]
fn an_empty_feed_is_refused() {
    let error = run(&Feed(Vec::new()), &setup(), &mut Silent, &AtomicBool::new(false)).unwrap_err();
    assert_eq!(error, RunError::NoFrames);
    assert_eq!(error.to_string(), "the sequence has no frames");
}

/// Raises the stop flag after some frames.
struct Stopper<'a> {
    stop: &'a AtomicBool,
    after: usize,
}

impl Observer for Stopper<'_> {
    fn event(&mut self, event: &Event) {
        if let Event::Frame(_) = event {
            self.after = self.after.saturating_sub(1);
            if self.after == 0 {
                self.stop.store(true, Ordering::Relaxed);
            }
        }
    }
}

#[test]
fn a_stopped_run_keeps_what_it_has() {
    let stop = AtomicBool::new(false);
    let feed = Feed(vec![Kind::Good; 50]);
    let outcome = run(&feed, &setup(), &mut Stopper { stop: &stop, after: 3 }, &stop).unwrap();
    assert!(outcome.interrupted);
    assert_eq!(outcome.frames.len(), 3);
    assert!(outcome.frames.iter().all(|frame| frame.world_from_cam.is_some()));
    assert_eq!(outcome.map.check(), Ok(()));
}

#[test]
fn a_run_on_threads_stops_soon_and_keeps_what_it_has() {
    for schedule in [Schedule::Lockstep, Schedule::Live { realtime: true }] {
        let stop = AtomicBool::new(false);
        let feed = Feed(vec![Kind::Good; 2000]);
        let setup = Setup { schedule, ..setup() };
        let outcome = run(&feed, &setup, &mut Stopper { stop: &stop, after: 3 }, &stop).unwrap();
        assert!(outcome.interrupted && (3..2000).contains(&outcome.frames.len()), "{}", outcome.frames.len());
        assert!(outcome.frames[2].world_from_cam.is_some());
        assert_eq!((outcome.failure, outcome.map.check()), (None, Ok(())));
    }
}
