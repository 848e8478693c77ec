//! What a run tells in words, once for all who listen: the terminal, the log for programs and the viewer.

use events::FrameState;
use serde_json::Value;
use slam::QualityReason;

use crate::events::{Event, FrameAnswer};
use crate::record::{LoopRecord, LoopResult};

/// How much it matters, from the most to the least.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Weight {
    /// Something went wrong.
    Warning,
    /// Good to know.
    Info,
    /// One of many steps.
    Detail,
    /// Every frame.
    Trace,
}

/// Something that happened, in words and as values for programs.
#[derive(Clone, Debug, PartialEq)]
pub struct Words {
    /// How much it matters.
    pub weight: Weight,
    /// What happened, in one word.
    pub event: &'static str,
    /// The words.
    pub text: String,
    /// Its values by name; `frame` is the number of a frame in its sequence.
    pub values: Vec<(&'static str, Value)>,
}

impl Words {
    fn new(weight: Weight, event: &'static str, text: impl Into<String>) -> Self {
        Words { weight, event, text: text.into(), values: Vec::new() }
    }

    fn with(mut self, name: &'static str, value: impl Into<Value>) -> Self {
        self.values.push((name, value.into()));
        self
    }

    /// Number of the frame that it is about, if it is about one.
    pub fn frame(&self) -> Option<u32> {
        let (_, frame) = self.values.iter().find(|(name, _)| *name == "frame")?;
        u32::try_from(frame.as_u64()?).ok()
    }
}

/// Puts events into words; knows the state of tracking, since only its changes are told.
#[derive(Clone, Debug, Default)]
pub struct Narrator {
    /// Of the last frame that could be used; `None` before the first frame.
    state: Option<FrameState>,
    /// Whether one camera turned on the spot in it.
    turning: bool,
}

impl Narrator {
    /// What there is to tell of an event, if anything: a change of state first.
    pub fn tell(&mut self, event: &Event) -> Vec<Words> {
        let change = match event {
            Event::Frame(answer) => self.change(answer),
            _ => None,
        };
        change.into_iter().chain(of_event(event)).collect()
    }

    /// A change of the state of tracking, and every dropped frame.
    fn change(&mut self, answer: &FrameAnswer) -> Option<Words> {
        use FrameState::{Dropped, Lost, NotReady, Tracked};
        let (frame, now) = (answer.index, answer.status.state());
        let reason = answer.status.reason().unwrap_or_default();
        let of = |weight, event, text: String| Some(Words::new(weight, event, text).with("frame", frame));
        let turning = answer.assessment.reasons.contains(&QualityReason::TurningOnTheSpot);
        let words = match (self.state.unwrap_or(NotReady), now) {
            (_, Tracked) if turning && !self.turning => {
                let text = "only the rotation is tracked, the position is held";
                of(Weight::Info, "turning", format!("turning on the spot at frame {frame}: {text}"))
            }
            (_, Tracked) if self.turning && !turning => {
                of(Weight::Info, "position_again", format!("position known again at frame {frame}"))
            }
            (_, Dropped) => of(Weight::Warning, "dropped", format!("frame {frame} dropped: {reason}")),
            (Tracked, Lost) => of(Weight::Warning, "lost", format!("lost at frame {frame}: {reason}")),
            (Lost, Tracked) => of(Weight::Info, "tracking_again", format!("tracking again at frame {frame}")),
            (NotReady, Tracked) if frame > 0 => {
                of(Weight::Info, "map_started", format!("map started at frame {frame}"))
            }
            (_, NotReady) if self.state.is_none() => {
                of(Weight::Info, "not_ready", format!("frame {frame}: {reason}"))
            }
            _ => None,
        };
        if now != Dropped {
            self.state = Some(now);
            self.turning = turning;
        }
        words.map(|words| if reason.is_empty() { words } else { words.with("reason", reason) })
    }
}

fn of_event(event: &Event) -> Option<Words> {
    let detail = |event, text: String| Words::new(Weight::Detail, event, text);
    let info = |event, text: String| Words::new(Weight::Info, event, text);
    Some(match event {
        Event::Started { frames } => {
            let length = frames.map_or("unknown length".to_owned(), |frames| format!("{frames} frames"));
            detail("started", format!("run of {length}")).with("frames", *frames)
        }
        Event::Calibrated { frame, calibration } => {
            let text = format!("calibration refined at frame {frame}: {calibration}");
            info("calibrated", text).with("frame", *frame).with("keyframes", calibration.keyframes)
        }
        Event::Frame(answer) => of_frame(answer),
        Event::Keyframe { id, frame, reason, report } => {
            let text = format!(
                "keyframe {id} from frame {frame} ({reason}): {} points triangulated, {} fused, {} culled",
                report.triangulated, report.fused, report.culled_points
            );
            detail("keyframe", text)
                .with("frame", *frame)
                .with("keyframe", id.0)
                .with("reason", reason.to_string())
                .with("triangulated", report.triangulated)
                .with("culled_keyframes", report.culled_keyframes)
        }
        Event::Details(_) | Event::Published(_) | Event::Stages { .. } => {
            return None;
        }
        _ => of_place(event)?,
    })
}

fn of_frame(answer: &FrameAnswer) -> Words {
    let FrameAnswer { index, status, keyframes, points, track_ms, .. } = answer;
    Words::new(Weight::Trace, "frame", format!("frame {index}: {status} ({track_ms:.1} ms)"))
        .with("frame", *index)
        .with("state", status.state().key())
        .with("inliers", status.inliers())
        .with("keyframes", *keyframes)
        .with("points", *points)
        .with("track_ms", *track_ms)
}

/// Loops, relocalizations, sub-maps and global bundle adjustments.
fn of_place(event: &Event) -> Option<Words> {
    Some(match event {
        Event::Relocalized { frame, keyframe, .. } => {
            Words::new(Weight::Info, "relocalized", format!("place recognized at frame {frame}"))
                .with("frame", *frame)
                .with("keyframe", keyframe.0)
        }
        Event::SubmapStarted { frame, keyframe } => {
            Words::new(Weight::Warning, "submap_started", format!("new sub-map starts at frame {frame}"))
                .with("frame", *frame)
                .with("keyframe", keyframe.0)
        }
        Event::LoopFound { keyframe, matched, inliers } => {
            let text = format!("loop found from keyframe {keyframe} to {matched}: {inliers} points");
            Words::new(Weight::Detail, "loop_found", text)
                .with("keyframe", keyframe.0)
                .with("matched", matched.0)
                .with("inliers", *inliers)
        }
        Event::Loop(record) => of_loop(record),
        Event::GlobalAdopted { cost: [before, after] } => {
            let text = format!("global bundle adjustment applied: cost {before:.1} to {after:.1}");
            Words::new(Weight::Detail, "global_adopted", text)
                .with("cost_before", *before)
                .with("cost_after", *after)
        }
        Event::GlobalDiscarded => {
            let text = "global bundle adjustment discarded: another loop was closed meanwhile";
            Words::new(Weight::Detail, "global_discarded", text)
        }
        Event::GlobalRefused { reason } => {
            let text = format!("global bundle adjustment rejected: {reason}");
            Words::new(Weight::Warning, "global_refused", text).with("reason", reason.as_str())
        }
        _ => return None,
    })
}

fn of_loop(record: &LoopRecord) -> Words {
    let LoopRecord { frame, matched_frame, result, .. } = record;
    let way = format!("loop from frame {frame} to {matched_frame}");
    let words = match result {
        LoopResult::Closed { inliers, moved_m, turned_deg, joined } => {
            let joining = if *joined { ", joining two sub-maps" } else { "" };
            let moved = format!("{moved_m:.2} m, {turned_deg:.2} deg, {inliers} points");
            Words::new(Weight::Info, "loop_closed", format!("{way} closed{joining}: {moved}"))
                .with("inliers", *inliers)
                .with("moved_m", *moved_m)
                .with("joined", *joined)
        }
        LoopResult::TakenBack { by } => {
            let text = format!("{way} taken back: the loop from frame {by} contradicts it");
            Words::new(Weight::Warning, "loop_taken_back", text).with("by", *by)
        }
        LoopResult::Rejected(reason) => {
            Words::new(Weight::Info, "loop_rejected", format!("{way} rejected: {reason}"))
                .with("reason", reason.as_str())
        }
        LoopResult::Refused(reason) => {
            Words::new(Weight::Warning, "loop_refused", format!("{way} rejected by the map: {reason}"))
                .with("reason", reason.as_str())
        }
    };
    words.with("frame", *frame).with("matched_frame", *matched_frame)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::FrameInfo;
    use crate::record::{FrameStatus, Unusable};
    use map::KeyframeId;
    use slam::{Lost, NotReady};

    fn frame(index: u32, status: FrameStatus) -> Event {
        let info = FrameInfo { index, timestamp_s: 0.0 };
        Event::Frame(Box::new(FrameAnswer {
            track_ms: 2.0,
            ..FrameAnswer::without_pose(info, status, (7, 9))
        }))
    }

    #[test]
    fn changes_of_state_are_told_once_and_dropped_frames_each_time() {
        let not_ready = || FrameStatus::NotReady(NotReady::MapStarting);
        let tracked = || FrameStatus::Tracked { inliers: 30 };
        let lost = || FrameStatus::Lost(Lost::TooFewMatches { found: 1, needed: 15 });
        let dropped = || FrameStatus::Dropped(Unusable::Skipped);
        let states = [
            not_ready(),
            not_ready(),
            tracked(),
            tracked(),
            dropped(),
            tracked(),
            lost(),
            dropped(),
            lost(),
            tracked(),
        ];
        let mut narrator = Narrator::default();
        let mut told = Vec::new();
        for (i, status) in states.into_iter().enumerate() {
            let words = narrator.tell(&frame(i as u32, status));
            assert_eq!(words.last().map(|words| (words.event, words.weight)), Some(("frame", Weight::Trace)));
            told.extend(words.into_iter().filter(|words| words.weight < Weight::Trace));
        }
        let told: Vec<(&str, Option<u32>)> = told.iter().map(|words| (words.event, words.frame())).collect();
        let expected = [
            ("not_ready", 0),
            ("map_started", 2),
            ("dropped", 4),
            ("lost", 6),
            ("dropped", 7),
            ("tracking_again", 9),
        ];
        assert_eq!(told, expected.map(|(event, frame)| (event, Some(frame))));
    }

    #[test]
    fn a_map_that_starts_with_the_first_frame_is_no_news() {
        let words = Narrator::default().tell(&frame(0, FrameStatus::Tracked { inliers: 0 }));
        assert_eq!(words.iter().map(|words| words.event).collect::<Vec<_>>(), ["frame"]);
        assert_eq!(words[0].text, "frame 0: tracking 0 points (2.0 ms)");
        let values = [("frame", 0.into()), ("state", "tracked".into()), ("inliers", 0.into())];
        assert_eq!(words[0].values[..3], values);
    }

    #[test]
    fn loops_say_what_became_of_them() {
        let of = |result| LoopRecord {
            frame: 90,
            keyframe: KeyframeId(30),
            matched_frame: 2,
            matched: KeyframeId(1),
            result,
        };
        let told = |result| Narrator::default().tell(&Event::Loop(of(result))).remove(0);
        let closed = told(LoopResult::Closed { inliers: 80, moved_m: 1.25, turned_deg: 0.5, joined: true });
        assert_eq!(
            closed.text,
            "loop from frame 90 to 2 closed, joining two sub-maps: 1.25 m, 0.50 deg, 80 points"
        );
        assert_eq!((closed.weight, closed.frame()), (Weight::Info, Some(90)));
        let taken_back = told(LoopResult::TakenBack { by: 140 });
        assert_eq!((taken_back.weight, taken_back.event), (Weight::Warning, "loop_taken_back"));
        assert_eq!(
            taken_back.text,
            "loop from frame 90 to 2 taken back: the loop from frame 140 contradicts it"
        );
        let refused = told(LoopResult::Refused("no such point".into()));
        assert_eq!((refused.weight, refused.event), (Weight::Warning, "loop_refused"));
        assert_eq!(refused.text, "loop from frame 90 to 2 rejected by the map: no such point");
    }

    #[test]
    fn a_turn_on_the_spot_is_told_when_it_begins_and_when_it_ends() {
        let event = |index: u32, reasons: Vec<QualityReason>| {
            let Event::Frame(answer) = frame(index, FrameStatus::Tracked { inliers: 60 }) else {
                panic!("a frame")
            };
            let assessment = slam::Assessment { reasons, ..Default::default() };
            Event::Frame(Box::new(FrameAnswer { assessment, ..*answer }))
        };
        let turning = || vec![QualityReason::TurningOnTheSpot];
        let mut narrator = Narrator::default();
        let mut told = Vec::new();
        for event in [event(0, vec![]), event(1, turning()), event(2, turning()), event(3, vec![])] {
            let words = narrator.tell(&event).into_iter().filter(|words| words.weight < Weight::Trace);
            told.extend(words.map(|words| (words.event, words.frame())));
        }
        assert_eq!(told, [("turning", Some(1)), ("position_again", Some(3))]);
    }
}
