//! The frames of a finished run, out of its results folder: final poses with their stamps to the nanosecond, and covariances.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, anyhow, ensure};
use dsslam::mcap::FinalFrame;
use geometry::PoseCovariance;
use io::TrajectoryFormat;

use crate::outputs::submap_file;

/// A row of `frames.csv`.
struct Row {
    /// Seconds, as they are written.
    time: f64,
    submap: String,
    covariance: Option<PoseCovariance>,
}

/// The sub-map that is asked for.
pub(crate) struct Recorded {
    pub(crate) frames: Vec<FinalFrame>,
    /// Its root, such as `K0`; empty where the run does not tell.
    pub(crate) submap: String,
    /// Sub-maps of the run.
    pub(crate) n_submaps: usize,
}

impl Recorded {
    /// Reads the sub-map that is the `submap`-th by its number of frames, the largest first, of equals the first.
    ///
    /// # Errors
    /// A folder without the files of a run.
    pub(crate) fn read(folder: &Path, submap: usize) -> Result<Self> {
        let rows = rows(folder)?;
        let submaps = submaps(&rows);
        let n_submaps = submaps.len();
        let root = submaps.get(submap).with_context(|| {
            format!(
                "{}: found no sub-map {submap}: the run has {n_submaps}, numbered from 0 by their frames",
                folder.display()
            )
        })?;
        let name = if n_submaps > 1 { submap_file(root) } else { "trajectory.tum.txt".to_owned() };
        let path = folder.join(name);
        let poses = io::read_trajectory(&path, Some(TrajectoryFormat::Tum))?.trajectory.poses;
        let text = read(&path)?;
        let data = text.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
        let stamps: Vec<&str> = data.filter_map(|line| line.split(' ').next()).collect();
        ensure!(
            stamps.len() == poses.len(),
            "{}: found {} lines with {} poses",
            path.display(),
            stamps.len(),
            poses.len()
        );
        let covariances: BTreeMap<u64, Option<PoseCovariance>> =
            rows.iter().map(|row| (row.time.to_bits(), row.covariance)).collect();
        let frame = |(stamp, pose): (&&str, &io::StampedPose)| -> Result<FinalFrame> {
            let t_ns = nanoseconds(stamp).with_context(|| format!("{}: time {stamp}", path.display()))?;
            let covariance = covariances.get(&pose.timestamp_s.to_bits()).copied().flatten();
            Ok(FinalFrame { t_ns, world_from_cam: pose.world_from_cam, covariance })
        };
        let frames = stamps.iter().zip(&poses).map(frame).collect::<Result<Vec<_>>>()?;
        Ok(Self { frames, submap: (*root).clone(), n_submaps })
    }
}

/// Seconds with nine decimals, as trajectories have them.
fn nanoseconds(text: &str) -> Result<i64> {
    let (sign, digits) = text.strip_prefix('-').map_or((1, text), |rest| (-1, rest));
    let (whole, decimals) = digits.split_once('.').context("found no decimals, expected nine")?;
    ensure!(decimals.len() == 9, "found {} decimals, expected nine", decimals.len());
    let [whole, rest]: [i64; 2] = [whole.parse()?, decimals.parse()?];
    let ns = whole.checked_mul(1_000_000_000).and_then(|ns| ns.checked_add(rest));
    ns.map(|ns| sign * ns).ok_or_else(|| anyhow!("out of range"))
}

fn read(path: &Path) -> Result<String> {
    fs::read_to_string(path)
        .with_context(|| format!("{}: cannot be read; `dsslam run` writes it", path.display()))
}

/// The roots of sub-maps, that with the most frames first, of equals the first.
fn submaps(rows: &[Row]) -> Vec<&String> {
    let mut found: Vec<(&String, usize)> = Vec::new();
    for row in rows {
        match found.iter_mut().find(|(root, _)| *root == &row.submap) {
            Some((_, n)) => *n += 1,
            None => found.push((&row.submap, 1)),
        }
    }
    found.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
    found.into_iter().map(|(root, _)| root).collect()
}

/// The frames with a pose in `frames.csv`.
fn rows(folder: &Path) -> Result<Vec<Row>> {
    let path = folder.join("frames.csv");
    let text = read(&path)?;
    let mut table = cells(&text).into_iter();
    let head = table.next().unwrap_or_default();
    let column = |name: &str| head.iter().position(|cell| cell == name);
    let needed =
        |name: &str| column(name).with_context(|| format!("{}: found no column {name}", path.display()));
    let (time, state, submap) = (needed("timestamp_s")?, needed("state")?, needed("submap")?);
    let places: Option<Vec<usize>> =
        PoseCovariance::names().map(|name| column(&format!("cov_{name}"))).collect();
    let row = |cells: Vec<String>| -> Result<Row> {
        let cell = |at: usize| cells.get(at).map_or("", String::as_str);
        let numbers = |places: &Vec<usize>| {
            places.iter().map(|&at| cell(at).parse().ok()).collect::<Option<Vec<f64>>>()
        };
        let triangle = places.as_ref().and_then(numbers).and_then(|numbers| numbers.try_into().ok());
        let covariance = triangle.and_then(|triangle| PoseCovariance::of_triangle(&triangle));
        let time = cell(time);
        let time = time.parse().with_context(|| format!("{}: timestamp_s {time}", path.display()))?;
        Ok(Row { time, submap: cell(submap).to_owned(), covariance })
    };
    table.filter(|cells| cells.get(state).is_some_and(|state| state == "tracked")).map(row).collect()
}

/// The cells of a table with commas and quotes (RFC 4180), row by row.
fn cells(text: &str) -> Vec<Vec<String>> {
    let (mut rows, mut row, mut cell) = (Vec::new(), Vec::new(), String::new());
    let (mut is_quoted, mut characters) = (false, text.chars().peekable());
    while let Some(character) = characters.next() {
        match character {
            '"' if is_quoted && characters.peek() == Some(&'"') => {
                characters.next();
                cell.push('"');
            }
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => row.push(std::mem::take(&mut cell)),
            '\n' if !is_quoted => {
                row.push(std::mem::take(&mut cell));
                rows.push(std::mem::take(&mut row));
            }
            other => cell.push(other),
        }
    }
    if !cell.is_empty() || !row.is_empty() {
        row.push(cell);
        rows.push(row);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_keep_their_nanoseconds() {
        assert_eq!(nanoseconds("1403636579.763555584").unwrap(), 1_403_636_579_763_555_584);
        assert_eq!(nanoseconds("-0.000000001").unwrap(), -1);
        assert!(nanoseconds("1.5").is_err() && nanoseconds("1").is_err());
    }

    #[test]
    fn cells_may_hold_commas_quotes_and_lines() {
        let text = "a,b\n1,\"x, \"\"y\"\"\nz\"\n2,\n";
        assert_eq!(cells(text), [vec!["a", "b"], vec!["1", "x, \"y\"\nz"], vec!["2", ""]]);
    }
}
