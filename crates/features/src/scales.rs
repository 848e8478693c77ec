//! Scale of the pyramid levels and how the wanted features are shared among them.

/// Scale and measurement noise of each pyramid level; a feature of octave `l` has sigma = `factor^l` pixels of level 0.
#[derive(Clone, Debug, PartialEq)]
pub struct ScaleLevels {
    /// Ratio between successive levels, above 1.
    pub factor: f32,
    /// `factor^l`: pixels of level 0 per pixel of level `l`.
    pub scales: Vec<f32>,
    /// Variance of a position measured on level `l`, squared pixels of level 0.
    pub sigma_sq: Vec<f32>,
    /// Its inverse.
    pub inv_sigma_sq: Vec<f32>,
}

impl ScaleLevels {
    /// `levels` levels, each `factor` times coarser than the one before.
    pub fn new(levels: usize, factor: f32) -> Self {
        let power = |l: usize| f64::from(factor).powi(l as i32);
        Self {
            factor,
            scales: (0..levels).map(|l| power(l) as f32).collect(),
            sigma_sq: (0..levels).map(|l| power(2 * l) as f32).collect(),
            inv_sigma_sq: (0..levels).map(|l| (1.0 / power(2 * l)) as f32).collect(),
        }
    }

    /// Number of levels.
    pub fn len(&self) -> usize {
        self.scales.len()
    }

    /// Whether there is no level at all.
    pub fn is_empty(&self) -> bool {
        self.scales.is_empty()
    }

    /// Size of level `l` of an image of this size: each side divided by the scale, rounded, at least 1.
    pub fn level_size(&self, l: usize, width: usize, height: usize) -> (usize, usize) {
        let side = |n: usize| ((n as f64 / f64::from(self.scales[l])).round() as usize).max(1);
        (side(width), side(height))
    }
}

/// Features wanted per level: a geometric series, so that each level has the same density per area of its own pixels;
/// the last level takes the rest (ORB-SLAM2: 2000 in 8 levels of 1.2 give 434, 362, 302, 251, 209, 175, 145, 122).
pub fn level_quotas(keep: usize, levels: usize, factor: f32) -> Vec<usize> {
    let Some(last) = levels.checked_sub(1) else { return Vec::new() };
    let ratio = 1.0 / f64::from(factor);
    let mut wanted = keep as f64 * (1.0 - ratio) / (1.0 - ratio.powi(levels as i32));
    let mut left = keep;
    let mut quotas = Vec::with_capacity(levels);
    for _ in 0..last {
        let quota = (wanted.round() as usize).min(left);
        quotas.push(quota);
        left -= quota;
        wanted *= ratio;
    }
    quotas.push(left);
    quotas
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotas_are_those_of_the_reference() {
        assert_eq!(level_quotas(2000, 8, 1.2), [434, 362, 302, 251, 209, 175, 145, 122]);
    }

    #[test]
    fn quotas_sum_to_the_whole() {
        for keep in [0, 1, 7, 500, 1000, 1200, 4001] {
            for levels in 1..=12 {
                assert_eq!(level_quotas(keep, levels, 1.2).iter().sum::<usize>(), keep);
            }
        }
        assert!(level_quotas(100, 0, 1.2).is_empty());
    }

    #[test]
    fn sigma_is_the_scale() {
        let levels = ScaleLevels::new(8, 1.2);
        assert_eq!(levels.len(), 8);
        for l in 0..8 {
            assert!((levels.scales[l] - 1.2f32.powi(l as i32)).abs() < 1e-5);
            assert!((levels.sigma_sq[l] * levels.inv_sigma_sq[l] - 1.0).abs() < 1e-6);
        }
        assert_eq!(levels.level_size(1, 1241, 376), (1034, 313));
    }
}
