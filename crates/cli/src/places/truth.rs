//! Which frames show the same place, from the poses of the sequence or of a file.

use anyhow::{Context, Result, bail, ensure};

use geometry::SE3;
use io::{Sequence, Trajectory, read_trajectory};

use super::args::PlacesArgs;
use eval::{LoopTruth, SamePlace};

/// Largest time between a frame and its true pose, seconds.
const TOLERANCE_S: f64 = 0.02;

/// The truth about the frames that the arguments choose.
///
/// # Errors
/// No poses, poses of other frames, or no frame that shows a place again.
pub(super) fn of(sequence: &Sequence, args: &PlacesArgs) -> Result<LoopTruth> {
    let poses = match &args.ground_truth {
        Some(file) => poses(sequence, &read_trajectory(file, None)?.trajectory)
            .with_context(|| file.display().to_string())?,
        None => match &sequence.ground_truth {
            Some(truth) => poses(sequence, truth)?,
            None => bail!(
                "{}: the sequence has no ground truth; give poses with --ground-truth FILE",
                args.sequence.display()
            ),
        },
    };
    let chosen: Vec<SE3> = poses.into_iter().step_by(args.every as usize).collect();
    let same = SamePlace { radius_m: args.radius, max_angle_deg: args.max_angle, min_gap: args.min_gap() };
    let truth = LoopTruth::from_poses(&chosen, &same);
    ensure!(
        truth.n_queries() > 0,
        "{}: no frame shows a place that was seen {} frames earlier (within {} m and {} degrees)",
        args.sequence.display(),
        args.gap,
        args.radius,
        args.max_angle
    );
    Ok(truth)
}

/// A pose per frame: by position where there are as many, else by the nearest time.
fn poses(sequence: &Sequence, truth: &Trajectory) -> Result<Vec<SE3>> {
    let all = &truth.poses;
    if all.len() == sequence.frames.len() {
        return Ok(all.iter().map(|pose| pose.world_from_cam).collect());
    }
    let pose = |frame: &io::FrameSource| {
        truth.find_nearest(frame.timestamp_s(), TOLERANCE_S).map(|pose| pose.world_from_cam).with_context(
            || {
                format!(
                    "found no pose within {TOLERANCE_S} s of the frame at {} s, expected one per frame",
                    frame.timestamp_s()
                )
            },
        )
    };
    sequence.frames.iter().map(pose).collect()
}
