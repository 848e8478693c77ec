//! `frames.csv` of a run: what tracking says of each frame.

use std::path::Path;

use anyhow::{Context, Result, ensure};
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
    /// How far it is to be trusted, 0 to 1; `None` in tables of versions before 0.3.
    pub quality: Option<f64>,
    /// What lowers that.
    pub quality_reasons: Vec<String>,
    /// Covariance of its pose, if it has one.
    pub covariance: Option<PoseCovariance>,
}

/// Reads the table; columns are found by their names.
///
/// # Errors
/// The file cannot be read, a column is missing, or a cell does not hold what it should; the message names the line.
pub fn read_frames(path: &Path) -> Result<Vec<FrameRow>> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("{}: cannot be read; `dsslam run` writes it", path.display()))?;
    let mut lines = text.lines().enumerate();
    let header = lines.next().map(|(_, line)| cells(line)).unwrap_or_default();
    let columns = Columns::of(&header).with_context(|| path.display().to_string())?;
    let row = |(i, line): (usize, &str)| {
        columns.row(&cells(line)).with_context(|| format!("{} line {}", path.display(), i + 1))
    };
    lines.map(row).collect()
}

/// The cells of a line; quotes around a cell keep its commas and are taken off.
pub fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut is_quoted = false;
    let mut characters = line.chars().peekable();
    while let Some(character) = characters.next() {
        match (character, is_quoted, cells.last_mut()) {
            ('"', true, Some(cell)) if characters.peek() == Some(&'"') => {
                cell.push('"');
                characters.next();
            }
            ('"', ..) => is_quoted = !is_quoted,
            (',', false, _) => cells.push(String::new()),
            (other, _, Some(cell)) => cell.push(other),
            _ => {}
        }
    }
    cells
}

/// Where the columns stand.
struct Columns {
    n: usize,
    frame: usize,
    timestamp_s: usize,
    state: usize,
    submap: usize,
    quality: Option<usize>,
    quality_reasons: Option<usize>,
    /// Of the covariance; empty where the table has none.
    covariance: Vec<usize>,
}

impl Columns {
    fn of(header: &[String]) -> Result<Self> {
        let at = |name: &str| header.iter().position(|column| column == name);
        let need = |name: &str| at(name).with_context(|| format!("no column `{name}` in the first line"));
        let covariance: Option<Vec<usize>> =
            PoseCovariance::names().map(|name| at(&format!("cov_{name}"))).collect();
        Ok(Columns {
            n: header.len(),
            frame: need("frame")?,
            timestamp_s: need("timestamp_s")?,
            state: need("state")?,
            submap: need("submap")?,
            quality: at("quality"),
            quality_reasons: at("quality_reasons"),
            covariance: covariance.unwrap_or_default(),
        })
    }

    fn row(&self, cells: &[String]) -> Result<FrameRow> {
        ensure!(cells.len() == self.n, "{} cells, expected {}", cells.len(), self.n);
        let number = |at: usize, what: &str| -> Result<f64> {
            cells[at].parse().with_context(|| format!("{what} `{}`", cells[at]))
        };
        let reasons = self.quality_reasons.map_or("", |at| &cells[at]);
        Ok(FrameRow {
            frame: cells[self.frame].parse().with_context(|| format!("frame `{}`", cells[self.frame]))?,
            timestamp_s: number(self.timestamp_s, "time")?,
            state: cells[self.state].clone(),
            submap: cells[self.submap].clone(),
            quality: self.quality.map(|at| number(at, "quality")).transpose()?,
            quality_reasons: reasons.split(';').filter(|r| !r.is_empty()).map(str::to_owned).collect(),
            covariance: self.covariance(cells)?,
        })
    }

    fn covariance(&self, row: &[String]) -> Result<Option<PoseCovariance>> {
        let Some(&first) = self.covariance.first() else { return Ok(None) };
        if row[first].is_empty() {
            return Ok(None);
        }
        let mut triangle = [0.0; PoseCovariance::N];
        for (value, &at) in triangle.iter_mut().zip(&self.covariance) {
            *value = row[at].parse().with_context(|| format!("covariance `{}`", row[at]))?;
        }
        PoseCovariance::of_triangle(&triangle).context("the covariance is not positive definite").map(Some)
    }
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
        assert_eq!(rows[1].quality_reasons, ["few_inliers", "mostly_far"]);
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
    fn cells_keep_commas_and_quotes() {
        assert_eq!(cells("a,\"b, \"\"c\"\"\",,d"), ["a", "b, \"c\"", "", "d"]);
    }
}
