//! When loops are looked for at all, and what is said where there is none.

use geometry::SE3;

use super::*;
use crate::probe::NoProbe;
use crate::scene::{chain, described, line, params};

fn detect(closer: &mut LoopCloser, keyframe: u32, world: &World) -> NoLoop {
    match closer.detect(KeyframeId(keyframe), world, &mut NoProbe) {
        LoopOutcome::None(reason) => reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn ten_keyframes_come_first_and_after_each_loop() {
    let world = described(chain(&line(24, 1.0), 16));
    let mut closer = LoopCloser::new(params());
    assert_eq!(detect(&mut closer, 9, &world), NoLoop::TooEarly { keyframes: 9, needed: 10 });
    assert!(!matches!(detect(&mut closer, 10, &world), NoLoop::TooEarly { .. }));
    closer.last_loop = Some(KeyframeId(12));
    assert_eq!(detect(&mut closer, 21, &world), NoLoop::TooEarly { keyframes: 9, needed: 10 });
    assert!(!matches!(detect(&mut closer, 22, &world), NoLoop::TooEarly { .. }));
}

#[test]
fn a_place_must_look_alike_four_times_in_a_row() {
    let world = described(chain(&line(24, 1.0), 16));
    let mut closer = LoopCloser::new(params());
    for (keyframe, seen) in [(18, 0), (19, 1), (20, 2)] {
        let reason = detect(&mut closer, keyframe, &world);
        assert_eq!(reason, NoLoop::NotYetConsistent { seen, needed: 3 }, "keyframe {keyframe}");
    }
    // The fourth time the geometry is looked at; all frames are the same, but no point is where it should be.
    let outcome = closer.detect(KeyframeId(21), &world, &mut NoProbe);
    assert!(!matches!(outcome, LoopOutcome::None(NoLoop::NotYetConsistent { .. })), "{outcome:?}");
}

#[test]
fn switched_off_or_without_words_there_are_no_places() {
    let world = described(chain(&line(12, 1.0), 16));
    let mut off = params();
    off.loops.enabled = false;
    assert_eq!(detect(&mut LoopCloser::new(off), 11, &world), NoLoop::NoPlaces);
    let world = World { map: chain(&[SE3::identity(); 12], 16), ..World::default() };
    assert_eq!(detect(&mut LoopCloser::new(params()), 11, &world), NoLoop::NoPlaces);
}
