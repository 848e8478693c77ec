//! Precision-recall curve and its area for place recognition (as the DSFeat paper's second table).

use anyhow::{Result, ensure};
use serde::{Deserialize, Serialize};

/// One answer of a place-recognition system.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detection {
    /// Confidence, smaller is better: the mean reprojection error of the RANSAC inliers, pixels.
    pub score: f64,
    /// Whether query and answer show the same place.
    pub is_correct: bool,
}

/// The curve at one threshold: detections with a score up to it are accepted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PrecisionRecall {
    /// Largest accepted score.
    pub threshold: f64,
    /// Correct accepted detections over accepted detections.
    pub precision: f64,
    /// Correct accepted detections over loop events.
    pub recall: f64,
}

/// Precision and recall for every threshold, and the area under the curve.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PrecisionRecallCurve {
    /// One point per distinct score, thresholds ascending.
    pub points: Vec<PrecisionRecall>,
    /// Area under precision over recall: trapezoids between the points, the first point's precision held back to
    /// recall 0. What lies beyond the largest recall counts as zero.
    pub auc: f64,
    /// Largest recall at which no accepted detection is wrong; 0 when the best score already is.
    pub recall_at_full_precision: f64,
    /// Number of detections.
    pub n_detections: usize,
    /// Number of loop events, detected or not.
    pub n_events: usize,
}

/// Sweeps the threshold over the scores of `detections`; `n_events` queries have a place to be recognized.
///
/// Detections of equal score are accepted together, so that the order of the list does not matter.
///
/// # Errors
/// No detections, no events, more correct detections than events, or a score that is not finite.
pub fn precision_recall(detections: &[Detection], n_events: usize) -> Result<PrecisionRecallCurve> {
    ensure!(!detections.is_empty(), "no detections: a precision-recall curve needs at least one");
    ensure!(n_events > 0, "no loop events: recall is not defined");
    let n_correct = detections.iter().filter(|d| d.is_correct).count();
    ensure!(n_correct <= n_events, "{n_correct} correct detections, but only {n_events} loop events");
    if let Some(bad) = detections.iter().find(|d| !d.score.is_finite()) {
        anyhow::bail!("a detection has the score {}, expected a finite number", bad.score);
    }
    let mut sorted = detections.to_vec();
    sorted.sort_by(|a, b| a.score.total_cmp(&b.score));
    let mut points = Vec::new();
    let (mut n_accepted, mut n_right) = (0.0, 0.0);
    for group in sorted.chunk_by(|a, b| a.score == b.score) {
        n_accepted += group.len() as f64;
        n_right += group.iter().filter(|d| d.is_correct).count() as f64;
        points.push(PrecisionRecall {
            threshold: group[0].score,
            precision: n_right / n_accepted,
            recall: n_right / n_events as f64,
        });
    }
    let full = points.iter().filter(|p| p.precision == 1.0).map(|p| p.recall);
    Ok(PrecisionRecallCurve {
        auc: area(&points),
        recall_at_full_precision: full.fold(0.0, f64::max),
        points,
        n_detections: detections.len(),
        n_events,
    })
}

fn area(points: &[PrecisionRecall]) -> f64 {
    let first = points[0].precision * points[0].recall;
    let rest =
        points.windows(2).map(|p| 0.5 * (p[0].precision + p[1].precision) * (p[1].recall - p[0].recall));
    first + rest.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn detections(list: &[(f64, bool)]) -> Vec<Detection> {
        list.iter().map(|&(score, is_correct)| Detection { score, is_correct }).collect()
    }

    #[test]
    fn a_known_curve() {
        let list = detections(&[(3.0, true), (1.0, true), (2.0, false), (4.0, false)]);
        let curve = precision_recall(&list, 4).unwrap();
        let points: Vec<(f64, f64)> = curve.points.iter().map(|p| (p.precision, p.recall)).collect();
        assert_eq!(points, [(1.0, 0.25), (0.5, 0.25), (2.0 / 3.0, 0.5), (0.5, 0.5)]);
        assert!((curve.auc - (0.25 + 0.25 * (0.5 + 2.0 / 3.0) / 2.0)).abs() < 1e-15);
        assert_eq!(curve.recall_at_full_precision, 0.25);
    }

    #[test]
    fn perfect_and_hopeless() {
        let perfect = precision_recall(&detections(&[(1.0, true), (2.0, true)]), 2).unwrap();
        assert_eq!((perfect.auc, perfect.recall_at_full_precision), (1.0, 1.0));
        let hopeless = precision_recall(&detections(&[(1.0, false)]), 2).unwrap();
        assert_eq!((hopeless.auc, hopeless.recall_at_full_precision), (0.0, 0.0));
    }

    #[test]
    fn equal_scores_do_not_depend_on_their_order() {
        let a = precision_recall(&detections(&[(1.0, true), (1.0, false), (2.0, true)]), 2).unwrap();
        let b = precision_recall(&detections(&[(2.0, true), (1.0, false), (1.0, true)]), 2).unwrap();
        assert_eq!(a, b);
        assert_eq!(a.points.len(), 2);
    }

    #[test]
    fn messages() {
        let message =
            |list: &[(f64, bool)], n| precision_recall(&detections(list), n).unwrap_err().to_string();
        assert_eq!(message(&[], 1), "no detections: a precision-recall curve needs at least one");
        assert_eq!(message(&[(1.0, true)], 0), "no loop events: recall is not defined");
        assert_eq!(message(&[(1.0, true); 2], 1), "2 correct detections, but only 1 loop events");
        assert_eq!(
            message(&[(f64::NAN, true)], 1),
            "a detection has the score NaN, expected a finite number"
        );
    }
}
