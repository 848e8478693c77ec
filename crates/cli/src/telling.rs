//! Events of a run as text, with their values for programs (`--log-format json`).

use runtime::{Event, FrameAnswer, FrameStatus, LoopRecord, LoopResult};
use serde_json::Value;

use crate::console::{Level, Message};

/// What an event says on its own; `None` for those that only move the bar.
pub(crate) fn message(event: &Event) -> Option<Message> {
    Some(match event {
        Event::Started { frames } => {
            let length = frames.map_or("unknown length".to_owned(), |frames| format!("{frames} frames"));
            detail(format!("run of {length}"))
                .event("started")
                .with("frames", frames.map_or(Value::Null, Value::from))
        }
        Event::Frame(FrameAnswer { index, status, keyframes, points, track_ms, .. }) => {
            Message::new(Level::Trace, format!("frame {index}: {} ({track_ms:.1} ms)", self::status(status)))
                .event("frame")
                .with("frame", *index)
                .with("state", state(status))
                .with("inliers", status.inliers().map_or(Value::Null, Value::from))
                .with("keyframes", *keyframes)
                .with("points", *points)
                .with("track_ms", *track_ms)
        }
        Event::Keyframe { id, frame, reason, report } => detail(format!(
            "keyframe {id} from frame {frame} ({reason}): {} points triangulated, {} fused, {} culled",
            report.triangulated, report.fused, report.culled_points
        ))
        .event("keyframe")
        .with("frame", *frame)
        .with("keyframe", id.0)
        .with("reason", reason.to_string())
        .with("triangulated", report.triangulated)
        .with("culled_keyframes", report.culled_keyframes),
        Event::Calibrating { .. } => return None,
        Event::Calibrated { estimate: Some(estimate) } => info(format!(
            "stereo calibration refined from the images: disparity offset {:+.3} px (+- {:.3} px)",
            estimate.offset_px, estimate.sigma_px
        ))
        .event("calibrated")
        .with("offset_px", estimate.offset_px)
        .with("sigma_px", estimate.sigma_px),
        Event::Calibrated { estimate: None } => {
            info("stereo calibration unchanged: too few keyframes constrain the disparity offset")
                .event("calibrated")
                .with("offset_px", Value::Null)
        }
        _ => return places(event),
    })
}

/// Loops, relocalisations and sub-maps.
fn places(event: &Event) -> Option<Message> {
    Some(match event {
        Event::Relocalised { frame, keyframe, .. } => info(format!("place recognised at frame {frame}"))
            .event("relocalised")
            .with("frame", *frame)
            .with("keyframe", keyframe.0),
        Event::SubmapStarted { frame, keyframe } => {
            Message::new(Level::Warning, format!("new sub-map starts at frame {frame}"))
                .event("submap_started")
                .with("frame", *frame)
                .with("keyframe", keyframe.0)
        }
        Event::LoopFound { keyframe, matched, inliers } => {
            detail(format!("loop found from keyframe {keyframe} to {matched}: {inliers} points"))
                .event("loop_found")
                .with("keyframe", keyframe.0)
                .with("matched", matched.0)
                .with("inliers", *inliers)
        }
        Event::Loop(record) => closed_loop(record),
        Event::GlobalAdopted { cost: [before, after] } => {
            detail(format!("global bundle adjustment applied: cost {before:.1} to {after:.1}"))
                .event("global_adopted")
                .with("cost_before", *before)
                .with("cost_after", *after)
        }
        Event::GlobalDiscarded => {
            detail("global bundle adjustment discarded: another loop was closed meanwhile")
                .event("global_discarded")
        }
        Event::GlobalRefused { reason } => {
            Message::new(Level::Warning, format!("global bundle adjustment rejected: {reason}"))
                .event("global_refused")
        }
        _ => return None,
    })
}

/// A change of the state of tracking at a frame.
pub(crate) fn frame_event(level: Level, event: &str, frame: u32, reason: Option<&str>) -> Message {
    let why = reason.unwrap_or_default();
    let text = match event {
        "dropped" => format!("frame {frame} dropped: {why}"),
        "lost" => format!("lost at frame {frame}: {why}"),
        "tracking_again" => format!("tracking again at frame {frame}"),
        "map_started" => format!("map started at frame {frame}"),
        _ => format!("frame {frame}: {why}"),
    };
    let message = Message::new(level, text).event(event).with("frame", frame);
    match reason {
        Some(reason) => message.with("reason", reason),
        None => message,
    }
}

fn closed_loop(record: &LoopRecord) -> Message {
    let LoopRecord { frame, matched_frame, result, .. } = record;
    let message = match result {
        LoopResult::Closed { inliers, moved_m, joined, .. } => {
            let words = if *joined { ", joining two sub-maps" } else { "" };
            info(format!(
                "loop closed from frame {frame} to {matched_frame}{words}: {moved_m:.2} m, {inliers} points"
            ))
            .event("loop_closed")
            .with("inliers", *inliers)
            .with("moved_m", *moved_m)
            .with("joined", *joined)
        }
        LoopResult::Rejected(reason) => {
            info(format!("loop from frame {frame} to {matched_frame} rejected: {reason}"))
                .event("loop_rejected")
                .with("reason", reason.as_str())
        }
        LoopResult::Refused(reason) => {
            info(format!("loop from frame {frame} to {matched_frame} rejected by the map: {reason}"))
                .event("loop_refused")
                .with("reason", reason.as_str())
        }
    };
    message.with("frame", *frame).with("matched_frame", *matched_frame)
}

fn info(text: impl Into<String>) -> Message {
    Message::new(Level::Info, text)
}

fn detail(text: impl Into<String>) -> Message {
    Message::new(Level::Detail, text)
}

/// The state as the bar shows it.
pub(crate) fn status(status: &FrameStatus) -> String {
    match status {
        FrameStatus::NotReady(_) => "waiting for initialization".to_owned(),
        FrameStatus::Tracked { inliers } => format!("tracking {inliers} points"),
        FrameStatus::Lost(_) => "LOST".to_owned(),
        FrameStatus::Dropped(_) => "frame dropped".to_owned(),
    }
}

/// The state in one word.
fn state(status: &FrameStatus) -> &'static str {
    match status {
        FrameStatus::NotReady(_) => "not_ready",
        FrameStatus::Tracked { .. } => "tracked",
        FrameStatus::Lost(_) => "lost",
        FrameStatus::Dropped(_) => "dropped",
    }
}
