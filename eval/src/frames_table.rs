//! `frames.csv` of a run: what tracking says of each frame.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use csv::StringRecord;
use geometry::PoseCovariance;

/// A row of `frames.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRow {
    /// Number of the frame.
    pub frame: u32,
    /// Time, seconds.
    pub timestamp_s: f64,
    /// `tracked`, `lost`, `not_ready` or `dropped`.
    pub state: String,
    /// Sub-map of its pose.
    pub submap: String,
    /// Matches that agree with its pose; 0 without one.
    pub inliers: u32,
    /// Why it has no pose.
    pub reason: String,
    /// How far it is to be trusted, 0 to 1; `None` in tables of versions before 0.3.
    pub quality: Option<f64>,
    /// Covariance of its pose, if it has one.
    pub covariance: Option<PoseCovariance>,
}

/// Reads the table; columns are found by their names.
///
/// # Errors
/// The file cannot be read, a column is missing, or a cell does not hold what it should; the message names the row.
pub fn read_frames(path: &Path) -> Result<Vec<FrameRow>> {
    let text = io::check_file(path)
        .and_then(|_| std::fs::read_to_string(path))
        .with_context(|| format!("{}: cannot be read; `dsslam run` writes it", path.display()))?;
    let mut table = csv::ReaderBuilder::new().flexible(true).from_reader(text.as_bytes());
    let header = table.headers()?.clone();
    for name in ["frame", "timestamp_s", "state", "submap"] {
        let is_there = header.iter().any(|column| column == name);
        ensure!(is_there, "{}: no column `{name}` in the first line", path.display());
    }
    let row = |cells: csv::Result<StringRecord>| {
        let cells = cells?;
        let line = cells.position().map_or(0, csv::Position::line);
        row(&header, &cells).with_context(|| format!("{} line {line}", path.display()))
    };
    table.records().map(row).collect()
}

fn row(header: &StringRecord, cells: &StringRecord) -> Result<FrameRow> {
    ensure!(cells.len() == header.len(), "{} cells, expected {}", cells.len(), header.len());
    let column = |name: &str| cells.get(header.iter().position(|column| column == name)?);
    let text = |name: &str| column(name).unwrap_or_default();
    let number = |text: &str, what: &str| text.parse::<f64>().with_context(|| format!("{what} `{text}`"));
    let covariance: Option<Vec<&str>> =
        PoseCovariance::names().map(|name| column(&format!("cov_{name}"))).collect();
    Ok(FrameRow {
        frame: text("frame").parse().with_context(|| format!("frame `{}`", text("frame")))?,
        timestamp_s: number(text("timestamp_s"), "time")?,
        state: text("state").to_owned(),
        submap: text("submap").to_owned(),
        inliers: text("inliers").parse().unwrap_or(0),
        reason: text("reason").to_owned(),
        quality: column("quality").map(|cell| number(cell, "quality")).transpose()?,
        covariance: match covariance {
            Some(cells) if cells.iter().any(|cell| !cell.is_empty()) => Some(triangle(&cells)?),
            _ => None,
        },
    })
}

fn triangle(cells: &[&str]) -> Result<PoseCovariance> {
    let mut triangle = [0.0; PoseCovariance::N];
    for (value, cell) in triangle.iter_mut().zip(cells) {
        *value = cell.parse().with_context(|| format!("covariance `{cell}`"))?;
    }
    PoseCovariance::of_triangle(&triangle).context("the covariance is not positive definite")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> String {
        let names: Vec<String> = PoseCovariance::names().map(|name| format!("cov_{name}")).collect();
        format!("frame,timestamp_s,state,submap,inliers,reason,quality,quality_reasons,{}", names.join(","))
    }

    fn read(text: &str) -> Result<Vec<FrameRow>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frames.csv");
        std::fs::write(&path, text).unwrap();
        read_frames(&path)
    }

    #[test]
    fn rows_with_and_without_a_covariance() {
        let triangle: [f64; PoseCovariance::N] =
            std::array::from_fn(|i| if [0, 6, 11, 15, 18, 20].contains(&i) { 0.1 } else { 1e-3 });
        let numbers: Vec<String> = triangle.iter().map(|v| format!("{v:e}")).collect();
        let text = format!(
            "{}\n0,0.5,lost,,,\"the images \"\"a\"\", b\",0,,{}\n1,0.6,tracked,K0,40,,0.5,few_inliers;mostly_far,{}\n",
            header(),
            ",".repeat(20),
            numbers.join(",")
        );
        let rows = read(&text).unwrap();
        assert_eq!((rows[0].frame, rows[0].covariance, rows[0].quality), (0, None, Some(0.0)));
        assert_eq!(rows[1].covariance.map(|c| c.triangle()), Some(triangle));
        let old = read("frame,timestamp_s,state,submap,inliers,reason\n7,0.5,tracked,K0,40,\n").unwrap();
        assert_eq!((old[0].frame, old[0].quality, old[0].covariance), (7, None, None));
    }

    #[test]
    fn damage_is_named_with_its_line() {
        let message = |text: &str| format!("{:#}", read(text).unwrap_err());
        assert!(message("frame,state\n").ends_with("no column `timestamp_s` in the first line"));
        let short = format!("{}\n1,0.5,tracked\n", header());
        assert!(message(&short).ends_with("line 2: 3 cells, expected 29"), "{}", message(&short));
        let flat = format!("{}\n1,0.6,tracked,K0,40,,0.5,,{}\n", header(), ["0"; 21].join(","));
        assert!(message(&flat).ends_with("line 2: the covariance is not positive definite"));
    }

    #[test]
    fn cells_may_hold_commas_quotes_and_lines() {
        let text =
            "frame,timestamp_s,state,submap,reason\n1,0.5,lost,,\"x, \"\"y\"\"\nz\"\n2,0.6,dropped,,\n";
        let reasons: Vec<String> = read(text).unwrap().into_iter().map(|row| row.reason).collect();
        assert_eq!(reasons, ["x, \"y\"\nz", ""]);
    }
}
