//! What a person wants to be told of a run.

use events::{Level, Text};

use crate::events::Event;
use crate::map_log::{LoopRecord, LoopResult};
use crate::record::FrameStatus;

/// Texts of events; knows the last state, since only changes of it are told.
#[derive(Debug, Default)]
pub(super) struct Texts {
    last: &'static str,
}

impl Texts {
    /// The text of an event, if there is something to tell.
    pub(super) fn of(&mut self, event: &Event) -> Option<Text> {
        let info = |frame: Option<u32>, text: String| Some(Text { frame, level: Level::Info, text });
        let warning = |frame: Option<u32>, text: String| Some(Text { frame, level: Level::Warning, text });
        match event {
            Event::Started { frames: None } => info(None, "run begins".to_owned()),
            Event::Started { frames: Some(frames) } => info(None, format!("run over {frames} frames")),
            Event::Calibrated { estimate: Some(estimate) } => info(
                None,
                format!("disparity offset {:+.3} px from the calibration pass", estimate.offset_px),
            ),
            Event::Frame(answer) => self.of_status(answer.index, &answer.status),
            Event::Relocalised { frame, keyframe, .. } => {
                info(Some(*frame), format!("place recognised near keyframe {keyframe}"))
            }
            Event::Keyframe { id, frame, reason, .. } => {
                info(Some(*frame), format!("keyframe {id} ({reason})"))
            }
            Event::SubmapStarted { frame, keyframe } => {
                warning(Some(*frame), format!("new sub-map from keyframe {keyframe} on"))
            }
            Event::LoopFound { keyframe, matched, inliers } => {
                info(None, format!("loop found from keyframe {keyframe} to {matched}, {inliers} points"))
            }
            Event::Loop(record) => Some(of_loop(record)),
            Event::GlobalAdopted { cost: [before, after] } => {
                info(None, format!("global bundle adjustment: cost {before:.0} to {after:.0}"))
            }
            Event::GlobalDiscarded => {
                info(None, "global bundle adjustment given up for a newer one".to_owned())
            }
            Event::GlobalRefused { reason } => {
                warning(None, format!("global bundle adjustment refused: {reason}"))
            }
            Event::Calibrating { .. }
            | Event::Calibrated { estimate: None }
            | Event::Details(_)
            | Event::Published(_)
            | Event::Stages { .. } => None,
        }
    }

    /// Changes of state, and every dropped frame.
    fn of_status(&mut self, index: u32, status: &FrameStatus) -> Option<Text> {
        let (name, level, text) = match status {
            FrameStatus::Dropped(reason) => {
                let text = format!("frame {index} dropped: {reason}");
                return Some(Text { frame: Some(index), level: Level::Warning, text });
            }
            FrameStatus::NotReady(reason) => {
                ("not ready", Level::Info, format!("frame {index} starts no map: {reason}"))
            }
            FrameStatus::Tracked { .. } => {
                ("tracked", Level::Info, format!("tracking from frame {index} on"))
            }
            FrameStatus::Lost(reason) => ("lost", Level::Warning, format!("lost at frame {index}: {reason}")),
        };
        let is_change = self.last != name;
        self.last = name;
        is_change.then_some(Text { frame: Some(index), level, text })
    }
}

fn of_loop(record: &LoopRecord) -> Text {
    let way = format!("loop from frame {} to {}", record.frame, record.matched_frame);
    let (level, text) = match &record.result {
        LoopResult::Closed { inliers, moved_m, turned_deg, joined } => {
            let joined = if *joined { ", joining two sub-maps" } else { "" };
            let moved = format!("{moved_m:.2} m, {turned_deg:.2} deg, {inliers} points");
            (Level::Info, format!("{way} closed{joined}: {moved}"))
        }
        LoopResult::Rejected(reason) => (Level::Info, format!("{way} rejected: {reason}")),
        LoopResult::Refused(reason) => (Level::Warning, format!("{way} refused by the map: {reason}")),
    };
    Text { frame: Some(record.frame), level, text }
}
