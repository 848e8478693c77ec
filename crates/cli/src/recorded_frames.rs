//! The frames of a finished run, out of its results folder: final poses with their stamps to the nanosecond, and covariances.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use dsslam::mcap::FinalFrame;
use eval::frames_table::{FrameRow, read_frames};
use geometry::PoseCovariance;
use io::TrajectoryFormat;

use crate::outputs::submap_file;

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
        let mut rows = read_frames(&folder.join("frames.csv"))?;
        rows.retain(|row| row.state == "tracked");
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
        let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
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
            rows.iter().map(|row| (row.timestamp_s.to_bits(), row.covariance)).collect();
        let frame = |(stamp, pose): (&&str, &io::StampedPose)| -> Result<FinalFrame> {
            let t_ns = io::nanoseconds_of(stamp);
            let t_ns = t_ns.with_context(|| format!("{}: time {stamp}, expected seconds", path.display()))?;
            let covariance = covariances.get(&pose.timestamp_s.to_bits()).copied().flatten();
            Ok(FinalFrame { t_ns, world_from_cam: pose.world_from_cam, covariance })
        };
        let frames = stamps.iter().zip(&poses).map(frame).collect::<Result<Vec<_>>>()?;
        Ok(Self { frames, submap: (*root).clone(), n_submaps })
    }
}

/// The roots of sub-maps, that with the most frames first, of equals the first.
fn submaps(rows: &[FrameRow]) -> Vec<&String> {
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
