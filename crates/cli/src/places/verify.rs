//! Whether two images show one scene: matches, a fundamental matrix by RANSAC, the mean epipolar error of its inliers
//! (the DSFeat paper's equations 5 and 6).

use geometry::{FundamentalEstimator, Mat3, RansacOptions, Vec2, mix_seed, ransac};

use super::sight::Sight;

/// Largest distance of an inlier, pixels: a standard deviation of one pixel, 95 %, one degree of freedom.
const THRESHOLD_PX: f64 = 1.96;
/// Fewer inliers than this say nothing: a fundamental matrix fits eight matches exactly.
const MIN_INLIERS: usize = 12;
/// A feature of one image and one of another.
type Match = (usize, usize);
/// Purpose of the random numbers.
const SEED_PURPOSE: u64 = 77;

/// What the geometry of two images says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Evidence {
    /// Mean distance of the inliers from their epipolar lines, both images, pixels.
    pub(super) mean_error_px: f64,
    pub(super) n_matches: usize,
    pub(super) n_inliers: usize,
}

/// The candidate with most inliers, of equals the first, with its evidence; the first candidate where none has enough; `None`
/// without candidates.
pub(super) fn best(
    sight: &Sight,
    candidates: &[usize],
    earlier: &[Sight],
    seed: u64,
) -> Option<(usize, Option<Evidence>)> {
    let mut matched: Vec<(usize, Vec<Match>)> =
        candidates.iter().map(|&frame| sight.matches(&earlier[frame])).enumerate().collect();
    // Inliers are matches: the search ends with the first candidate that has fewer of these than another has inliers.
    matched.sort_by_key(|(rank, matches)| (std::cmp::Reverse(matches.len()), *rank));
    let mut best: Option<(usize, Evidence)> = None;
    for (rank, matches) in matched {
        if matches.len() < best.map_or(MIN_INLIERS, |(_, evidence)| evidence.n_inliers) {
            break;
        }
        let Some(found) = evidence(sight, &earlier[candidates[rank]], &matches, seed) else { continue };
        let order = |rank, evidence: &Evidence| (evidence.n_inliers, std::cmp::Reverse(rank));
        if best.is_none_or(|(first, best)| order(rank, &found) > order(first, &best)) {
            best = Some((rank, found));
        }
    }
    let (rank, found) = best.map_or((0, None), |(rank, evidence)| (rank, Some(evidence)));
    Some((*candidates.get(rank)?, found))
}

/// The evidence that `a` and `b` show one scene; `None` with too few inliers.
fn evidence(a: &Sight, b: &Sight, matches: &[Match], seed: u64) -> Option<Evidence> {
    let pixels_a: Vec<Vec2> = matches.iter().map(|m| a.pixels[m.0]).collect();
    let pixels_b: Vec<Vec2> = matches.iter().map(|m| b.pixels[m.1]).collect();
    let weights: Vec<f64> = matches.iter().map(|m| a.trust[m.0] * b.trust[m.1]).collect();
    let estimator = FundamentalEstimator::new(&pixels_a, &pixels_b, THRESHOLD_PX * THRESHOLD_PX);
    let options = RansacOptions {
        sample_size: FundamentalEstimator::SAMPLE_SIZE,
        max_iterations: 1000,
        confidence: 0.99,
        seed: mix_seed(0, seed, SEED_PURPOSE),
    };
    let found = ransac(&estimator, Some(&weights), &options)?;
    if found.inliers.len() < MIN_INLIERS {
        return None;
    }
    let sum: f64 = found.inliers.iter().map(|&i| epipolar_px(&found.model, &pixels_a[i], &pixels_b[i])).sum();
    let mean_error_px = sum / found.inliers.len() as f64;
    let evidence = Evidence { mean_error_px, n_matches: matches.len(), n_inliers: found.inliers.len() };
    mean_error_px.is_finite().then_some(evidence)
}

/// Mean of the distances of both pixels from the epipolar line of the other.
fn epipolar_px(fundamental: &Mat3, pixel_a: &Vec2, pixel_b: &Vec2) -> f64 {
    let (a, b) = (pixel_a.push(1.0), pixel_b.push(1.0));
    let (line_b, line_a) = (fundamental * a, fundamental.tr_mul(&b));
    let algebraic = b.dot(&line_b).abs();
    0.5 * (algebraic / line_b.xy().norm() + algebraic / line_a.xy().norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_from_an_epipolar_line_is_in_pixels() {
        // A camera that moves sideways: corresponding pixels lie on the same row.
        let sideways = Mat3::new(0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0);
        let distance =
            |row_a, row_b| epipolar_px(&sideways, &Vec2::new(10.0, row_a), &Vec2::new(50.0, row_b));
        assert!(distance(30.0, 30.0).abs() < 1e-12);
        assert!((distance(30.0, 33.5) - 3.5).abs() < 1e-12);
    }
}
