//! `dsslam eval traj`: two files in, all figures out.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use io::{Stamps, TrajectoryFile, TrajectoryFormat, read_trajectory};

use super::hints::{self, Named};
use super::out::{hint, say};
use crate::figures::path_figures;
use crate::plot::{self, DriftAxis};
use crate::{
    Alignment, Association, DeltaUnit, Estimate, Evaluation, EvaluationOptions, KITTI_LENGTHS_M, LostFrames,
    PairMode, RpeOptions, Statistics, TIMESTAMP_TOLERANCE_S,
};

/// Arguments of `dsslam eval traj`.
#[derive(Debug, Args)]
pub struct TrajArgs {
    /// Estimated trajectory.
    #[arg(value_name = "ESTIMATE")]
    est: PathBuf,
    /// Ground truth.
    #[arg(value_name = "GROUND_TRUTH")]
    gt: PathBuf,
    /// Format of both files [default: detected from the first line].
    #[arg(long, value_enum)]
    format: Option<FormatArg>,
    /// Format of the ground truth, if different.
    #[arg(long, value_enum)]
    gt_format: Option<FormatArg>,
    /// Alignment before ATE; use sim3 for monocular estimates.
    #[arg(long, value_enum, default_value = "se3")]
    align: Alignment,
    /// How to match poses [default: by frame for KITTI files, else by time].
    #[arg(long, value_enum)]
    associate: Option<AssociateArg>,
    /// Maximum difference between timestamps, seconds.
    #[arg(long, value_name = "SECONDS", default_value_t = TIMESTAMP_TOLERANCE_S)]
    tolerance: f64,
    /// Segment lengths of t_rel and r_rel, meters.
    #[arg(long, value_name = "M,M,...", value_delimiter = ',', default_values_t = KITTI_LENGTHS_M)]
    lengths: Vec<f64>,
    /// How t_rel and r_rel treat lost frames.
    #[arg(long, value_enum, default_value = "fill")]
    lost: LostFrames,
    /// Distance of the two frames of a relative pose error.
    #[arg(long, value_name = "D", default_value_t = 1.0)]
    rpe_delta: f64,
    /// Unit of that distance.
    #[arg(long, value_enum, default_value = "frames")]
    rpe_unit: DeltaUnit,
    /// Consecutive pairs or all.
    #[arg(long, value_enum, default_value = "consecutive")]
    rpe_pairs: PairMode,
    /// Window of the scale drift, meters.
    #[arg(long, value_name = "M", default_value_t = 50.0)]
    scale_window: f64,
    /// Frames per second of a KITTI file, for drift by speed.
    #[arg(long, value_name = "HZ", default_value_t = 10.0)]
    frame_rate: f64,
    /// Prints JSON instead of text.
    #[arg(long)]
    json: bool,
    /// Writes plots (PNG and SVG) into this folder.
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum AssociateArg {
    Index,
    Time,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FormatArg {
    /// 12 numbers a line (3x4 of world_from_cam), one line per frame; or 13 with a frame number or time in front.
    Kitti,
    /// 8 numbers a line: seconds, position, quaternion x y z w.
    Tum,
    /// Comma separated: nanoseconds, position, quaternion w x y z, anything more.
    Euroc,
}

impl From<FormatArg> for TrajectoryFormat {
    fn from(format: FormatArg) -> Self {
        match format {
            FormatArg::Kitti => TrajectoryFormat::Kitti,
            FormatArg::Tum => TrajectoryFormat::Tum,
            FormatArg::Euroc => TrajectoryFormat::Euroc,
        }
    }
}

pub(super) fn run(args: &TrajArgs) -> Result<()> {
    let est = read_trajectory(&args.est, args.format.map(Into::into))?;
    let gt = read_trajectory(&args.gt, args.gt_format.or(args.format).map(Into::into))?;
    let [est_name, gt_name] = [&args.est, &args.gt].map(|path| path.display().to_string());
    let (named_est, named_gt) = (Named { name: est_name, file: &est }, Named { name: gt_name, file: &gt });
    let evaluated = evaluate(args, &est, &gt);
    let mut hints = hints::of_files(&named_est, &named_gt);
    if let Ok(evaluation) = &evaluated {
        hints.extend(hints::of_poses(&named_est, &named_gt, evaluation));
    }
    hints.iter().for_each(|text| hint(text));
    let evaluation =
        evaluated.with_context(|| format!("cannot compare {} with {}", named_est.name, named_gt.name))?;
    if args.json {
        say(serde_json::to_string_pretty(&evaluation)?)?;
    } else {
        print_files(args, &est, &gt)?;
        say(text(&evaluation, args))?;
    }
    if let Some(folder) = &args.plots {
        write_plots(folder, args, &evaluation)?;
    }
    Ok(())
}

/// Matches the files as their stamps allow, and compares them.
fn evaluate(args: &TrajArgs, est: &TrajectoryFile, gt: &TrajectoryFile) -> Result<Evaluation> {
    let has_times = |file: &TrajectoryFile| file.stamps == Stamps::Times;
    if args.associate != Some(AssociateArg::Index) && has_times(est) != has_times(gt) {
        bail!("a KITTI file has no timestamps: match by index, or give both files in a format with times");
    }
    let by_time = args.associate.map_or(has_times(est), |by| by == AssociateArg::Time);
    let (estimate, association) = if by_time {
        (Estimate::of_file(est), Association::Timestamp { tolerance_s: args.tolerance })
    } else if est.stamps == Stamps::FrameNumbers && !has_times(gt) {
        (Estimate::of_numbered_file(est, &gt.trajectory)?, Association::FrameNumber)
    } else {
        (Estimate::of_file(est), Association::Index)
    };
    let rpe = RpeOptions {
        delta: args.rpe_delta,
        unit: args.rpe_unit,
        pairs: args.rpe_pairs,
        ..RpeOptions::default()
    };
    let options = EvaluationOptions {
        association,
        alignment: args.align,
        lengths_m: args.lengths.clone(),
        rpe,
        scale_window_m: args.scale_window,
        frame_rate_hz: args.frame_rate,
        lost: args.lost,
    };
    Evaluation::of(&estimate, &gt.trajectory, &options)
}

fn print_files(args: &TrajArgs, est: &TrajectoryFile, gt: &TrajectoryFile) -> Result<()> {
    for (what, path, file) in [("estimate", &args.est, est), ("ground truth", &args.gt, gt)] {
        let repeated = match file.n_repeated_times {
            0 => String::new(),
            n => format!(", {n} rows that repeat the previous time skipped"),
        };
        let n = file.trajectory.poses.len();
        say(format!("{what:<13} {} ({:?}, {n} poses{repeated})", path.display(), file.format))?;
    }
    Ok(())
}

/// The figures, one a line.
fn text(e: &Evaluation, args: &TrajArgs) -> String {
    let scale =
        if e.alignment == Alignment::Sim3 { format!(", scale {:.6}", e.scale) } else { String::new() };
    let mut lines = vec![
        format!(
            "association   {}: {} poses used of {} estimated, {} true",
            e.association, e.n_used, e.n_est, e.n_gt
        ),
        coverage(e),
        format!("alignment     {}{scale}", e.alignment),
        format!("ATE           {}", statistics(&e.ate_m, "m")),
        drift_line(e, &args.lengths),
    ];
    for bin in &e.per_length {
        lines.push(format!(
            "  {:>6} m    t_rel {:.4} %, r_rel {:.4} deg/100 m, {} segments",
            bin.at, bin.t_rel_percent, bin.r_rel_deg_per_100m, bin.n
        ));
    }
    let percent = e.end_error_percent().map(|p| format!(", {p:.4} % of it")).unwrap_or_default();
    lines.push(format!("end           {:.6} m off after {:.3} m{percent}", e.end_error_m, e.path_m));
    if let (Some(m), Some(deg)) = (&e.rpe_m, &e.rpe_deg) {
        let unit = if args.rpe_unit == DeltaUnit::Frames { "frames" } else { "m" };
        let pairs = if args.rpe_pairs == PairMode::All { "all pairs" } else { "consecutive pairs" };
        lines.push(format!("RPE           {} {unit}, {pairs}: {}", args.rpe_delta, statistics(m, "m")));
        lines.push(format!("              rotation: {}", statistics(deg, "deg")));
    } else {
        lines.push("RPE           not defined: no two poses that far apart".to_owned());
    }
    lines.push(match e.scale_drift_percent_per_100m {
        Some(percent) => {
            format!("scale drift   {percent:+.4} % per 100 m (windows of {} m)", args.scale_window)
        }
        None => format!("scale drift   not defined: fewer than two windows of {} m", args.scale_window),
    });
    lines.join("\n")
}

fn coverage(e: &Evaluation) -> String {
    match e.longest_gap_s {
        Some(gap) => format!(
            "coverage      {} estimated poses without a true pose in time; longest gap between matched poses {gap:.3} s",
            e.n_unmatched
        ),
        None => format!(
            "coverage      {:.2} %: {} of {} frames without a pose, longest gap {} frames",
            e.coverage.percent(),
            e.coverage.n_lost,
            e.coverage.n_frames,
            e.coverage.longest_gap
        ),
    }
}

fn drift_line(e: &Evaluation, lengths_m: &[f64]) -> String {
    let (Some(t), Some(r), Some(rms), Some(std)) =
        (e.t_rel_percent, e.r_rel_deg_per_100m, e.t_rms_percent, e.t_std_percent)
    else {
        let shortest = lengths_m.iter().copied().fold(f64::INFINITY, f64::min);
        return format!(
            "t_rel, r_rel  not defined: no segment of the ground truth is longer than {shortest} m (--lengths sets others)"
        );
    };
    let mut notes = vec![format!("{} segments", e.n_segments)];
    notes.push(if e.alignment == Alignment::Sim3 { "after Sim3" } else { "no alignment" }.to_owned());
    if e.n_segments_skipped > 0 {
        notes.push(format!("{} segments without a pose skipped", e.n_segments_skipped));
    } else if e.coverage.n_lost > 0 {
        notes.push(format!("{} lost frames filled", e.coverage.n_lost));
    }
    format!(
        "t_rel         {t:.4} % (RMS {rms:.4}, std {std:.4}), r_rel {r:.4} deg/100 m ({})",
        notes.join(", ")
    )
}

fn statistics(s: &Statistics, unit: &str) -> String {
    format!(
        "RMSE {:.6} {unit}, mean {:.6}, median {:.6}, std {:.6}, min {:.6}, max {:.6} (n = {})",
        s.rmse, s.mean, s.median, s.std, s.min, s.max, s.n
    )
}

fn write_plots(folder: &Path, args: &TrajArgs, e: &Evaluation) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let name = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let title = format!("{} over {}", name(&args.est), name(&args.gt));
    let aligned = |pose: &Option<geometry::SE3>| Some(e.aligned(&pose.as_ref()?.translation));
    let estimate: Vec<_> = e.matched.est.iter().map(aligned).collect();
    let ground_truth = crate::positions(&e.matched.gt);
    for (what, _, figure) in path_figures(&title, &estimate, &ground_truth)? {
        let file = if what == "error" { what.to_owned() } else { format!("trajectory_{what}") };
        plot::save(folder, &file, &figure)?;
    }
    for (file, axis, bins) in
        [("drift_length", DriftAxis::Length, &e.per_length), ("drift_speed", DriftAxis::Speed, &e.per_speed)]
    {
        if !bins.is_empty() {
            let curves = [(name(&args.est), bins.clone())];
            plot::save(folder, file, &plot::drift(&title, axis, &curves)?)?;
        }
    }
    say(format!("plots         {}", folder.display()))?;
    Ok(())
}
