//! `dsslam eval consistency`: covariances of a run against its ground truth.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;
use geometry::SE3;
use io::{Trajectory, read_trajectory};

use super::out::say;
use crate::consistency::{Consistency, ConsistencyOptions, ConsistentFrame, interpolated};
use crate::frames_table::{FrameRow, read_frames};
use crate::plot;

/// Times of a frame in two files differ by rounding only, seconds.
const TIME_TOLERANCE_S: f64 = 5e-4;

/// Arguments of `dsslam eval consistency`.
#[derive(Debug, Args)]
pub struct ConsistencyArgs {
    /// Results folder of a run: frames.csv and trajectory.tum.txt.
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// True poses with times, interpolated at the frames; of the body where the run has
    /// trajectory_body.tum.txt [default: RUN/ground_truth.tum.txt, of the left camera].
    #[arg(long, value_name = "FILE")]
    ground_truth: Option<PathBuf>,
    /// Standard deviation of each true position (m) and rotation (deg), added for both ends.
    #[arg(long, value_name = "M,DEG", value_delimiter = ',', num_args = 1)]
    truth_sigma: Vec<f64>,
    /// Frames of a motion; the covariances are those of 10.
    #[arg(long, value_name = "FRAMES", default_value_t = 10)]
    delta: u32,
    /// Factor on all standard deviations.
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    factor: f64,
    /// Writes the curve (PNG and SVG) into this folder.
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
}

pub(super) fn run(args: &ConsistencyArgs) -> Result<()> {
    let [truth_sigma_m, truth_sigma_deg] = match args.truth_sigma[..] {
        [] => [0.0; 2],
        [m, deg] if m >= 0.0 && deg >= 0.0 => [m, deg],
        _ => anyhow::bail!("--truth-sigma: expected two numbers, meters and degrees, such as 0.002,0.15"),
    };
    ensure!(args.factor > 0.0, "--factor: found {}, expected a positive number", args.factor);
    let options = ConsistencyOptions { delta: args.delta, truth_sigma_m, truth_sigma_deg };
    let frames = frames(args)?;
    let found = Consistency::of(&frames, &options).with_context(|| args.run.display().to_string())?;
    say(text(&found))?;
    if let Some(folder) = &args.plots {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
        let title = format!("Consistency of {}", args.run.display());
        plot::save(folder, "consistency", &plot::consistency(&title, &found)?)?;
        say(format!("plots         {}", folder.display()))?;
    }
    Ok(())
}

/// The figures, one a line.
fn text(found: &Consistency) -> String {
    let [x, y, z, rx, ry, rz] = found.per_axis;
    let [by_mean, by_median] = found.factors();
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    format!(
        "motions       {}\nNEES          mean {:.2} (6 is right), median {:.2} (5.35 is right)\n\
         within 95 %   {} ({} above, {} below)\n\
         per axis      error over sigma, RMS: x {x:.2} y {y:.2} z {z:.2}, about x {rx:.2} y {ry:.2} z {rz:.2}\n\
         factor        {by_mean:.2} by the mean, {by_median:.2} by the median, on standard deviations",
        found.nees.len(),
        found.mean,
        found.median,
        percent(found.inside),
        percent(found.above),
        percent(found.below),
    )
}

/// The tracked frames of the run's trajectory that have a true pose.
fn frames(args: &ConsistencyArgs) -> Result<Vec<ConsistentFrame>> {
    let rows = read_frames(&args.run.join("frames.csv"))?;
    let estimate = read_tum(&args.run.join("trajectory.tum.txt"))?;
    let (body_file, truth_file) =
        (args.run.join("trajectory_body.tum.txt"), args.run.join("ground_truth.tum.txt"));
    let body = match &args.ground_truth {
        Some(_) if body_file.is_file() => Some(read_tum(&body_file)?),
        _ => None,
    };
    let truth = read_trajectory(args.ground_truth.as_ref().unwrap_or(&truth_file), None)?.trajectory;
    let found: Vec<ConsistentFrame> =
        rows.iter().filter_map(|row| frame(row, args.factor, &estimate, body.as_ref(), &truth)).collect();
    ensure!(!found.is_empty(), "{}: no tracked frame has a true pose", args.run.display());
    Ok(found)
}

fn frame(
    row: &FrameRow,
    factor: f64,
    estimate: &Trajectory,
    body: Option<&Trajectory>,
    truth: &Trajectory,
) -> Option<ConsistentFrame> {
    if row.state != "tracked" {
        return None;
    }
    let at = |poses: &Trajectory| -> Option<SE3> {
        poses.find_nearest(row.timestamp_s, TIME_TOLERANCE_S).map(|pose| pose.world_from_cam)
    };
    let truth = interpolated(truth, row.timestamp_s)?;
    let world_from_cam = at(estimate)?;
    let scaled = row.covariance.and_then(|c| geometry::PoseCovariance::new(c.in_camera() * factor * factor));
    let (estimate, covariance) = match body {
        None => (world_from_cam, scaled),
        Some(body) => {
            let world_from_body = at(body)?;
            let body_from_cam = world_from_body.inverse() * world_from_cam;
            (world_from_body, scaled.map(|covariance| covariance.of_body(&body_from_cam)))
        }
    };
    Some(ConsistentFrame { frame: row.frame, estimate, truth, covariance })
}

fn read_tum(path: &Path) -> Result<Trajectory> {
    Ok(read_trajectory(path, Some(io::TrajectoryFormat::Tum))?.trajectory)
}
