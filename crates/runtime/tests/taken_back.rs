//! A drive through a field in which two places look alike: a wrong loop passes the gate, and what is seen later takes it back, with the
//! same bits in turn, on threads and on one thread.
#![allow(clippy::unwrap_used, reason = "a test stops at the first problem")]

mod alike;

use std::sync::atomic::AtomicBool;

use alike::{Drive, SIDE_M};
use dsslam_runtime::{Faults, FrameStatus, LoopResult, RunOutcome, Schedule, Setup, Silent, run};
use geometry::SE3;

fn done(drive: &Drive, schedule: Schedule, delays: Option<u64>) -> RunOutcome {
    let faults = Faults { delays, ..Faults::default() };
    let setup = Setup { schedule, faults, ..drive.setup() };
    run(drive, &setup, &mut Silent, &AtomicBool::new(false)).unwrap()
}

/// Everything that must not depend on how the stages share time.
fn bits(outcome: &RunOutcome) -> (Vec<(FrameStatus, Option<SE3>)>, u64) {
    let frames = outcome.frames.iter().map(|frame| (frame.status.clone(), frame.world_from_cam));
    (frames.collect(), outcome.map.digest())
}

/// Root mean square distance of the frames to where they were, meters.
fn error_m(drive: &Drive, outcome: &RunOutcome) -> f64 {
    let errors = outcome.frames.iter().zip(&drive.centers).map(|(frame, center)| {
        let pose = frame.world_from_cam.unwrap();
        (drive.centers[0] + pose.translation - center).norm_squared()
    });
    (errors.sum::<f64>() / outcome.frames.len() as f64).sqrt()
}

#[test]
fn a_wrong_loop_is_taken_back_with_the_same_bits_under_every_schedule() {
    let drive = Drive::new();
    let in_turn = done(&drive, Schedule::Sequential, None);
    let apart_m =
        |frame: u32, other: u32| (drive.centers[frame as usize] - drive.centers[other as usize]).norm();
    let changes = in_turn.loops.iter().filter_map(|l| {
        let apart_m = apart_m(l.frame, l.matched_frame);
        match l.result {
            LoopResult::Closed { moved_m, .. } => Some((l.frame, apart_m, Ok(moved_m))),
            LoopResult::TakenBack { by } => Some((l.frame, apart_m, Err(by))),
            _ => None,
        }
    });
    let changes: Vec<_> = changes.collect();
    let [(wrong, off_m, Ok(bent_m)), (right, beside_m, Ok(_)), (gone, _, Err(by))] = changes[..] else {
        panic!("{changes:?}")
    };
    assert!((off_m - SIDE_M).abs() < 0.5 && bent_m > 10.0 && beside_m < 1.0, "{changes:?}");
    assert_eq!((gone, by, in_turn.statistics.loops_taken_back), (wrong, right, 1));
    let error_m = error_m(&drive, &in_turn);
    assert!(error_m < 0.5, "{error_m} m at the end");
    assert_eq!((in_turn.map.check(), &in_turn.failure), (Ok(()), &None));

    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let on_one = alone.install(|| done(&drive, Schedule::Sequential, None));
    assert!(bits(&on_one) == bits(&in_turn), "other bits on one thread");
    let on_threads = done(&drive, Schedule::Lockstep, Some(1));
    assert!(bits(&on_threads) == bits(&in_turn), "other bits on threads under delays");
    assert_eq!((&on_one.loops, &on_threads.loops), (&in_turn.loops, &in_turn.loops));
}
