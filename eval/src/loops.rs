//! Loop detection against ground truth: which frames show the same place, and how many of them were found.

use anyhow::{Result, bail, ensure};
use geometry::SE3;
use serde::Serialize;

/// Which earlier frames show the same place as a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoopTruth {
    /// For each query frame, the matching earlier frames, ascending.
    matches: Vec<Vec<usize>>,
}

/// When two poses count as the same place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamePlace {
    /// Largest distance, meters.
    pub radius_m: f64,
    /// Largest angle between the viewing directions (optical axes), degrees; 180 accepts opposite directions.
    pub max_angle_deg: f64,
    /// Smallest number of frames between the two, so that neighbors do not count.
    pub min_gap: usize,
}

/// Precision and recall of loop detections.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LoopScore {
    /// Correct detections over detections; `None` without detections.
    pub precision: Option<f64>,
    /// Queries with a correct detection over queries that have a loop; `None` when none has.
    pub recall: Option<f64>,
    /// Revisits (unbroken runs of queries that have a loop) with a correct detection, over all revisits.
    pub revisit_recall: Option<f64>,
    /// Number of detections.
    pub n_detections: usize,
    /// Correct ones.
    pub n_correct: usize,
    /// Queries that have a loop.
    pub n_queries: usize,
    /// Revisits.
    pub n_revisits: usize,
}

impl LoopTruth {
    /// Truth of a square matrix in text (rows of 0 and 1, separated by spaces or commas): entry (i, j) says whether
    /// frame j < i shows the place of frame i; entries with j >= i are ignored.
    ///
    /// # Errors
    /// An empty text, a row whose length is not the number of rows, or an entry that is neither 0 nor 1.
    pub fn from_matrix_text(text: &str) -> Result<LoopTruth> {
        let rows: Vec<&str> =
            text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#')).collect();
        ensure!(!rows.is_empty(), "the matrix is empty");
        let mut matches = Vec::with_capacity(rows.len());
        for (i, row) in rows.iter().enumerate() {
            let entries: Vec<&str> =
                row.split(|c: char| c == ',' || c.is_whitespace()).filter(|e| !e.is_empty()).collect();
            ensure!(
                entries.len() == rows.len(),
                "row {} of the matrix has {} entries, expected {} (as many as rows)",
                i + 1,
                entries.len(),
                rows.len()
            );
            let mut found = Vec::new();
            for (j, entry) in entries.iter().enumerate() {
                match entry.parse::<f64>() {
                    Ok(1.0) if j < i => found.push(j),
                    Ok(0.0 | 1.0) => {}
                    _ => bail!("row {} of the matrix: found '{entry}', expected 0 or 1", i + 1),
                }
            }
            matches.push(found);
        }
        Ok(LoopTruth { matches })
    }

    /// Truth of the poses `world_from_cam` of all frames.
    pub fn from_poses(poses: &[SE3], same: &SamePlace) -> LoopTruth {
        let axis = |pose: &SE3| pose.rotation.matrix().column(2).into_owned();
        let min_cosine = same.max_angle_deg.to_radians().cos();
        let shows_same = |i: usize, j: usize| {
            (poses[i].translation - poses[j].translation).norm_squared() <= same.radius_m * same.radius_m
                && (same.max_angle_deg >= 180.0 || axis(&poses[i]).dot(&axis(&poses[j])) >= min_cosine)
        };
        let earlier = |i: usize| 0..(i + 1).saturating_sub(same.min_gap.max(1));
        let matches = (0..poses.len()).map(|i| earlier(i).filter(|&j| shows_same(i, j)).collect()).collect();
        LoopTruth { matches }
    }

    /// Number of frames.
    pub fn n_frames(&self) -> usize {
        self.matches.len()
    }

    /// Frames that show a place seen earlier.
    pub fn n_queries(&self) -> usize {
        self.matches.iter().filter(|m| !m.is_empty()).count()
    }

    /// Whether the detection `query` -> `answer` is right (the order of the two does not matter).
    pub fn is_correct(&self, query: usize, answer: usize) -> bool {
        let (late, early) = (query.max(answer), query.min(answer));
        self.matches.get(late).is_some_and(|m| m.binary_search(&early).is_ok())
    }

    /// First and last query of each revisit: queries with a loop, at most `max_hole` queries without one in between.
    pub fn revisits(&self, max_hole: usize) -> Vec<(usize, usize)> {
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for i in (0..self.matches.len()).filter(|&i| !self.matches[i].is_empty()) {
            match runs.last_mut() {
                Some((_, last)) if i - *last <= max_hole + 1 => *last = i,
                _ => runs.push((i, i)),
            }
        }
        runs
    }
}

/// Holes up to this many frames do not split a revisit.
const MAX_HOLE: usize = 10;

/// Scores `detections` (pairs query, answer) against the truth.
///
/// # Errors
/// A frame number beyond the truth.
pub fn score_loops(detections: &[(usize, usize)], truth: &LoopTruth) -> Result<LoopScore> {
    let n = truth.n_frames();
    if let Some((query, answer)) = detections.iter().find(|(q, a)| *q.max(a) >= n) {
        bail!("detection {query} -> {answer} names a frame beyond the {n} frames of the ground truth");
    }
    let mut found: Vec<usize> =
        detections.iter().filter(|(q, a)| truth.is_correct(*q, *a)).map(|(q, a)| *q.max(a)).collect();
    let n_correct = found.len();
    found.sort_unstable();
    found.dedup();
    let revisits = truth.revisits(MAX_HOLE);
    let n_revisited = revisits.iter().filter(|(a, b)| found.iter().any(|q| (a..=b).contains(&q))).count();
    let ratio = |part: usize, whole: usize| (whole > 0).then(|| part as f64 / whole as f64);
    Ok(LoopScore {
        precision: ratio(n_correct, detections.len()),
        recall: ratio(found.len(), truth.n_queries()),
        revisit_recall: ratio(n_revisited, revisits.len()),
        n_detections: detections.len(),
        n_correct,
        n_queries: truth.n_queries(),
        n_revisits: revisits.len(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{SO3, Vec3};

    #[test]
    fn a_matrix_and_the_poses_behind_it_agree() {
        // A lap of six places, driven twice.
        let place = |i: usize| {
            let angle = std::f64::consts::TAU * (i % 6) as f64 / 6.0;
            SE3::new(SO3::identity(), Vec3::new(10.0 * angle.cos(), 0.0, 10.0 * angle.sin()))
        };
        let poses: Vec<SE3> = (0..12).map(place).collect();
        let same = SamePlace { radius_m: 1.0, max_angle_deg: 30.0, min_gap: 3 };
        let text: Vec<String> = (0..12)
            .map(|i| (0..12).map(|j| if i % 6 == j % 6 { "1" } else { "0" }).collect::<Vec<_>>().join(" "))
            .collect();
        let truth = LoopTruth::from_poses(&poses, &same);
        assert_eq!(truth, LoopTruth::from_matrix_text(&text.join("\n")).unwrap());
        assert_eq!((truth.n_queries(), truth.revisits(0)), (6, vec![(6, 11)]));
    }

    #[test]
    fn opposite_directions_count_only_when_allowed() {
        let turned = SE3::new(SO3::exp(&Vec3::new(0.0, std::f64::consts::PI, 0.0)), Vec3::zeros());
        let poses = [SE3::identity(), turned];
        let same = SamePlace { radius_m: 1.0, max_angle_deg: 90.0, min_gap: 1 };
        assert_eq!(LoopTruth::from_poses(&poses, &same).n_queries(), 0);
        let any = SamePlace { max_angle_deg: 180.0, ..same };
        assert_eq!(LoopTruth::from_poses(&poses, &any).n_queries(), 1);
    }

    #[test]
    fn precision_and_recall() {
        let truth = LoopTruth::from_matrix_text("0 0 0 0\n0 0 0 0\n1 0 0 0\n1 1 0 0").unwrap();
        let score = score_loops(&[(2, 0), (3, 2), (0, 2)], &truth).unwrap();
        assert_eq!((score.n_correct, score.n_queries, score.n_revisits), (2, 2, 1));
        assert_eq!(score.precision, Some(2.0 / 3.0));
        assert_eq!((score.recall, score.revisit_recall), (Some(0.5), Some(1.0)));
        let nothing = score_loops(&[], &truth).unwrap();
        assert_eq!((nothing.precision, nothing.recall), (None, Some(0.0)));
    }

    #[test]
    fn messages() {
        let message = |text: &str| LoopTruth::from_matrix_text(text).unwrap_err().to_string();
        assert_eq!(message("# nothing"), "the matrix is empty");
        assert_eq!(message("0 0\n0"), "row 2 of the matrix has 1 entries, expected 2 (as many as rows)");
        assert_eq!(message("0,2\n0,0"), "row 1 of the matrix: found '2', expected 0 or 1");
        let truth = LoopTruth::from_matrix_text("0 0\n0 0").unwrap();
        let message = score_loops(&[(1, 2)], &truth).unwrap_err().to_string();
        assert_eq!(message, "detection 1 -> 2 names a frame beyond the 2 frames of the ground truth");
    }
}
