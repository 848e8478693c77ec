//! Published results shown beside ours in tables and charts, each with its source (`eval/baselines/*.yaml`).

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;

/// A figure of a run that tables compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// KITTI translation drift, percent.
    TRelPercent,
    /// KITTI rotation drift, degrees per 100 m.
    #[serde(rename = "r_rel_deg_per_100m")]
    RRelDegPer100m,
    /// Absolute trajectory error, root mean square, meters.
    AteRmseM,
    /// Area under the precision-recall curve of place recognition.
    Auc,
}

impl Metric {
    /// All of them, in the order of tables and figures.
    pub const ALL: [Self; 4] = [Self::TRelPercent, Self::RRelDegPer100m, Self::AteRmseM, Self::Auc];

    /// Name with unit, for heads and axes.
    pub fn label(self) -> &'static str {
        match self {
            Metric::TRelPercent => "t_rel [%]",
            Metric::RRelDegPer100m => "r_rel [deg/100 m]",
            Metric::AteRmseM => "ATE RMSE [m]",
            Metric::Auc => "AUC",
        }
    }

    /// Name of files.
    pub fn file_name(self) -> &'static str {
        match self {
            Metric::TRelPercent => "t_rel",
            Metric::RRelDegPer100m => "r_rel",
            Metric::AteRmseM => "ate",
            Metric::Auc => "auc",
        }
    }

    /// Whether a larger value is the better one.
    pub fn larger_is_better(self) -> bool {
        self == Metric::Auc
    }
}

/// Published figures of one system on one dataset.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    /// Name, a column of the tables.
    pub name: String,
    /// Where the figures are from.
    pub source: String,
    /// Data set, as suites name it.
    pub dataset: String,
    /// Sensor used: `stereo`, `rgbd`, `mono`, or `any`.
    pub sensor: String,
    /// Frames of each whole sequence, where known: a part of a sequence has no published figure.
    #[serde(default)]
    pub frames: BTreeMap<String, usize>,
    /// Value of each metric for each sequence.
    pub metrics: BTreeMap<Metric, BTreeMap<String, f64>>,
}

impl Baseline {
    /// The value for a sequence.
    pub fn value(&self, metric: Metric, sequence: &str) -> Option<f64> {
        self.metrics.get(&metric)?.get(sequence).copied()
    }
}

/// The files of `eval/baselines`, part of the program.
const BUILT_IN: [(&str, &str); 13] = [
    ("euroc_droid.yaml", include_str!("../baselines/euroc_droid.yaml")),
    ("euroc_orbslam2.yaml", include_str!("../baselines/euroc_orbslam2.yaml")),
    ("euroc_orbslam3.yaml", include_str!("../baselines/euroc_orbslam3.yaml")),
    ("kitti_auc_orb_ours.yaml", include_str!("../baselines/kitti_auc_orb_ours.yaml")),
    ("kitti_auc_orb_seman.yaml", include_str!("../baselines/kitti_auc_orb_seman.yaml")),
    ("kitti_auc_orb_trad.yaml", include_str!("../baselines/kitti_auc_orb_trad.yaml")),
    ("kitti_auc_superpoint_ours.yaml", include_str!("../baselines/kitti_auc_superpoint_ours.yaml")),
    ("kitti_auc_superpoint_seman.yaml", include_str!("../baselines/kitti_auc_superpoint_seman.yaml")),
    ("kitti_auc_superpoint_trad.yaml", include_str!("../baselines/kitti_auc_superpoint_trad.yaml")),
    ("kitti_dsfeat.yaml", include_str!("../baselines/kitti_dsfeat.yaml")),
    ("kitti_orbslam2_dsfeat_rerun.yaml", include_str!("../baselines/kitti_orbslam2_dsfeat_rerun.yaml")),
    ("kitti_orbslam2_published.yaml", include_str!("../baselines/kitti_orbslam2_published.yaml")),
    ("tum_orbslam2.yaml", include_str!("../baselines/tum_orbslam2.yaml")),
];

/// All built-in baselines, and those of the YAML files in `extra`.
///
/// # Errors
/// A file cannot be read or parsed.
pub fn read_baselines(extra: Option<&Path>) -> Result<Vec<Baseline>> {
    let mut baselines = Vec::new();
    for (name, text) in BUILT_IN {
        baselines.push(parse(text).with_context(|| format!("baselines/{name}"))?);
    }
    let Some(folder) = extra else { return Ok(baselines) };
    let entries = std::fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))?;
    let mut files: Vec<_> = entries.filter_map(|entry| entry.ok().map(|e| e.path())).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "yaml"));
    files.sort();
    for path in files {
        let text =
            std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        baselines.push(parse(&text).with_context(|| format!("{}", path.display()))?);
    }
    Ok(baselines)
}

fn parse(text: &str) -> Result<Baseline> {
    let baseline: Baseline = serde_saphyr::from_str(text)?;
    ensure!(!baseline.source.trim().is_empty(), "the source is empty: every published figure needs a source");
    Ok(baseline)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_files_are_complete() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("baselines");
        assert_eq!(std::fs::read_dir(folder).unwrap().count(), BUILT_IN.len(), "a file is not built in");
        assert_eq!(read_baselines(None).unwrap().len(), BUILT_IN.len());
    }

    /// The means that the papers' tables end in.
    #[test]
    fn means_are_those_of_the_tables() {
        let baselines = read_baselines(None).unwrap();
        let mean = |name: &str, metric: Metric| {
            let is_it = |b: &&Baseline| b.name == name && b.dataset == "kitti";
            let values = &baselines.iter().find(is_it).unwrap().metrics[&metric];
            assert_eq!(values.len(), 11);
            values.values().sum::<f64>() / 11.0
        };
        for (name, t, r) in [
            ("ORB-SLAM2 (published)", 0.7245, 0.2227),
            ("ORB-SLAM2 (DSFeat paper)", 0.787, 0.258),
            ("DSFeat (paper)", 0.718, 0.221),
        ] {
            assert!((mean(name, Metric::TRelPercent) - t).abs() < 6e-4, "{name}");
            assert!((mean(name, Metric::RRelDegPer100m) - r).abs() < 6e-4, "{name}");
        }
        assert!((mean("ORB-SLAM2 (published)", Metric::AteRmseM) - 2.55).abs() < 0.01);
    }

    #[test]
    fn a_baseline_without_source_is_refused() {
        let text =
            "name: a\nsource: ''\ndataset: kitti\nsensor: stereo\nmetrics: {ate_rmse_m: {'00': 1.0}}\n";
        assert_eq!(
            parse(text).unwrap_err().to_string(),
            "the source is empty: every published figure needs a source"
        );
    }
}
