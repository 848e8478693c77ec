//! `dsslam eval loops`: detected loops against ground truth.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use clap::Args;

use super::out::say;
use crate::detections::detections_csv;
use crate::plot;
use crate::{Detection, LoopTruth, SamePlace, precision_recall, score_loops};

/// Arguments of `dsslam eval loops`.
#[derive(Debug, Args)]
pub struct LoopsArgs {
    /// Detected loops (CSV).
    #[arg(value_name = "DETECTIONS")]
    detections: PathBuf,
    /// Ground truth: a square matrix of 0 and 1, row = query, column = earlier frame.
    #[arg(long, value_name = "FILE", required_unless_present = "poses", conflicts_with = "poses")]
    matrix: Option<PathBuf>,
    /// Ground truth: the poses of all frames.
    #[arg(long, value_name = "FILE")]
    poses: Option<PathBuf>,
    /// With --poses: largest distance of two frames at the same place, meters.
    #[arg(long, value_name = "M", default_value_t = 4.0)]
    radius: f64,
    /// With --poses: largest angle between their viewing directions, degrees; 180 accepts opposite directions.
    #[arg(long, value_name = "DEG", default_value_t = 45.0)]
    max_angle: f64,
    /// With --poses: minimum number of frames between them.
    #[arg(long, value_name = "FRAMES", default_value_t = 100)]
    min_gap: usize,
    /// Writes the scored detections to this file; named detections.csv in a run's folder, it feeds tables and plots.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Writes the precision-recall curve (PNG and SVG) into this folder.
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
}

pub(super) fn run(args: &LoopsArgs) -> Result<()> {
    let truth = truth(args)?;
    let rows = read_rows(&args.detections)?;
    let pairs: Vec<(usize, usize)> = rows.iter().map(|row| (row.0, row.1)).collect();
    let score = score_loops(&pairs, &truth).with_context(|| format!("{}", args.detections.display()))?;
    let percent =
        |v: Option<f64>| v.map_or_else(|| "not defined".to_owned(), |v| format!("{:.2} %", 100.0 * v));
    say(format!(
        "precision  {}: {} of {} detections",
        percent(score.precision),
        score.n_correct,
        score.n_detections
    ))?;
    say(format!(
        "recall     {}: of {} frames that show a place again",
        percent(score.recall),
        score.n_queries
    ))?;
    say(format!(
        "revisits   {}: of {} returns to known places",
        percent(score.revisit_recall),
        score.n_revisits
    ))?;
    let judged: Option<Vec<Detection>> = rows
        .iter()
        .map(|&(query, answer, score)| {
            Some(Detection { score: score?, is_correct: truth.is_correct(query, answer) })
        })
        .collect();
    let Some(judged) = judged.filter(|list| !list.is_empty()) else { return Ok(()) };
    let curve = precision_recall(&judged, score.n_queries)?;
    say(format!("AUC        {:.4}", curve.auc))?;
    say(format!("recall at full precision {:.2} %", 100.0 * curve.recall_at_full_precision))?;
    if let Some(path) = &args.out {
        std::fs::write(path, detections_csv(&judged, score.n_queries))
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    if let Some(folder) = &args.plots {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
        let name = args.detections.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let figure = plot::precision_recall("Place recognition", &[(name, curve)])?;
        plot::save(folder, "precision_recall", &figure)?;
    }
    Ok(())
}

fn truth(args: &LoopsArgs) -> Result<LoopTruth> {
    if let Some(path) = &args.matrix {
        let text =
            std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        return LoopTruth::from_matrix_text(&text).with_context(|| format!("{}", path.display()));
    }
    let Some(path) = &args.poses else { bail!("give --matrix or --poses") };
    let trajectory = io::read_trajectory(path, None)?.trajectory;
    let poses: Vec<_> = trajectory.poses.iter().map(|p| p.world_from_cam).collect();
    let same = SamePlace { radius_m: args.radius, max_angle_deg: args.max_angle, min_gap: args.min_gap };
    Ok(LoopTruth::from_poses(&poses, &same))
}

/// Query, answer and score of each line.
fn read_rows(path: &Path) -> Result<Vec<(usize, usize, Option<f64>)>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut rows = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') || line.starts_with("query") {
            continue;
        }
        let place = || {
            format!(
                "{}:{}: found '{line}', expected query,answer or query,answer,score",
                path.display(),
                i + 1
            )
        };
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        ensure!(matches!(fields.len(), 2 | 3), "{}", place());
        let score = fields.get(2).map(|s| s.parse::<f64>()).transpose().with_context(place)?;
        rows.push((fields[0].parse().with_context(place)?, fields[1].parse().with_context(place)?, score));
    }
    Ok(rows)
}
