//! From what the run has to what is written.

use std::collections::BTreeMap;

use events::{
    ActivationMap, Counts, End, FeatureState, Features, FinalPose, FramePose, FrameRecord, Image, Level,
    Pose, StageTime, Text, Trust,
};
use features::{Frame, Keypoint};
use geometry::SE3;
use io::Preview;

use crate::events::{FrameAnswer, FrameDetails};
use crate::record::RunOutcome;
use crate::words::{Weight, Words};

/// A frame after tracking.
pub(super) fn frame(details: &FrameDetails) -> FrameRecord {
    let (answer, has_pose) = (&details.answer, details.answer.status.has_pose());
    let cam_from_keyframe = details.pose.map_or(SE3::identity(), |pose| pose.cam_from_keyframe);
    let (trusted, stats) = (&answer.assessment, &answer.stats);
    FrameRecord {
        pose: has_pose.then(|| FramePose {
            keyframe: details.pose.map(|pose| pose.keyframe.0),
            cam_from_keyframe: Pose::from(&cam_from_keyframe),
            scale: details.scale,
            world_from_cam: Pose::from(&details.world_from_cam),
        }),
        trust: has_pose.then(|| Trust::new(trusted.quality, trusted.covariance.as_ref())),
        counts: Counts {
            features: count(answer.features),
            with_depth: count(answer.with_depth),
            visible: count(stats.visible),
            matches: count(stats.matches),
            inliers: count(stats.inliers),
            keyframes: count(answer.keyframes),
            points: count(answer.points),
        },
        stages: stage_times(&details.stages),
        ..untracked(answer)
    }
}

/// A frame of which nothing but its state is known.
pub(super) fn untracked(answer: &FrameAnswer) -> FrameRecord {
    FrameRecord {
        index: answer.index,
        timestamp_s: answer.timestamp_s,
        state: answer.status.state(),
        reason: answer.status.reason().unwrap_or_default(),
        pose: None,
        trust: None,
        counts: Counts::default(),
        stages: Vec::new(),
    }
}

/// Times, those of a stage that ran several times added up, in the order of the first.
pub(super) fn stage_times(stages: &[(&'static str, f64)]) -> Vec<StageTime> {
    let mut times: Vec<StageTime> = Vec::new();
    for (name, ms) in stages {
        match times.iter_mut().find(|time| time.name == *name) {
            Some(time) => time.ms += *ms as f32,
            None => times.push(StageTime { name: (*name).to_owned(), ms: *ms as f32 }),
        }
    }
    times
}

/// Features of a frame and what tracking made of them.
pub(super) fn features(details: &FrameDetails) -> Features {
    let frame = &details.frame;
    let mut states = vec![FeatureState::New; frame.len()];
    let marks = [(&details.matched, FeatureState::Outlier), (&details.inliers, FeatureState::Tracked)];
    for (matches, state) in marks {
        for &(feature, _) in matches {
            if let Some(mark) = states.get_mut(feature as usize) {
                *mark = state;
            }
        }
    }
    // A feature without a point has the network's word alone.
    let mut activations: Vec<u8> = frame.activation.iter().map(|a| quantized(*a)).collect();
    for (&(feature, _), &trust) in details.matched.iter().zip(&details.trust) {
        if let Some(shown) = activations.get_mut(feature as usize) {
            *shown = quantized(trust);
        }
    }
    Features { frame: details.answer.index, pixels: pixels(frame), states, activations }
}

/// An image, made smaller.
pub(super) fn image(frame: u32, preview: Preview) -> Image {
    Image { frame, size: [count(preview.width), count(preview.height)], jpeg: preview.jpeg }
}

/// An activation map.
pub(super) fn activation(frame: u32, map: &features::ActivationMap) -> ActivationMap {
    let values = map.values();
    ActivationMap {
        frame,
        size: [count(values.width), count(values.height)],
        values: values.data.iter().map(|value| quantized(*value)).collect(),
    }
}

/// A share of 0 to 1 as 0 to 255.
fn quantized(share: f32) -> u8 {
    (share.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// Where each feature is in the image: lens distortion, which frames are free of, put back.
fn pixels(frame: &Frame) -> Vec<[f32; 2]> {
    let shown = |keypoint: &Keypoint| {
        let pixel = frame.rig.distort(&keypoint.pixel());
        [pixel.x as f32, pixel.y as f32]
    };
    frame.keypoints.iter().map(shown).collect()
}

/// The end of a run.
pub(super) fn end(outcome: &RunOutcome, summary: String, left_out: u64) -> End {
    let own: BTreeMap<u32, FinalPose> = outcome
        .frames
        .iter()
        .filter(|frame| frame.status.has_pose())
        .filter_map(|frame| {
            let world_from_cam = Pose::from(&frame.world_from_cam?);
            let submap = frame.submap.map(|root| root.0);
            Some((frame.index, FinalPose { frame: frame.index, world_from_cam, submap }))
        })
        .collect();
    End { trajectory: own.into_values().collect(), summary, left_out }
}

/// A count as it is written.
fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

/// Words of the run as a text of the stream; those about every frame are none of its texts.
pub(super) fn text(words: Words) -> Option<Text> {
    let level = match words.weight {
        Weight::Warning => Level::Warning,
        Weight::Info | Weight::Detail => Level::Info,
        Weight::Trace => return None,
    };
    Some(Text { frame: words.frame(), level, text: words.text })
}
