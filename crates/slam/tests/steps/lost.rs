//! Of two failures the one that came further is told.

use super::*;

#[test]
fn the_further_failure_wins_and_of_equals_the_first() {
    let matches = |found| Lost::TooFewMatches { found, needed: 20 };
    let predicted = |found| Lost::TooFewPredictedInliers { found, needed: 10 };
    let local = |found| Lost::TooFewLocalInliers { found, needed: 30 };
    assert_eq!(matches(5).further(matches(6)), matches(6));
    assert_eq!(matches(6).further(matches(5)), matches(6));
    assert_eq!(matches(19).further(predicted(0)), predicted(0));
    assert_eq!(local(0).further(predicted(9)), local(0));
    let far = Lost::TooFar { off_m: 1.389, most_m: 0.53 };
    assert_eq!(local(29).further(far), far);
    let first = Lost::TooFewMatches { found: 5, needed: 15 };
    assert_eq!(first.further(matches(5)), first);
}

#[test]
fn reasons_say_what_was_found_and_needed() {
    let lost = Lost::TooFewLocalInliers { found: 12, needed: 30 };
    assert_eq!(lost.to_string(), "the local map confirms too few points: 12 of 30");
    let far = Lost::TooFar { off_m: 1.389, most_m: 0.53 };
    let text = "the pose found is farther away than the camera can have moved: 1.39 m from where it would be \
                had it gone on, 0.53 m at most";
    assert_eq!(far.to_string(), text);
    let early = NotReady::TooFewDepths { found: 3, needed: 100, features: 40 };
    assert_eq!(early.to_string(), "the map cannot start: 3 of 40 features have a depth, 100 needed");
}
