//! Colours.

use events::FeatureState;
use rerun::Color;

/// Points of the colour map viridis (S. van der Walt, N. Smith), evenly spaced.
const VIRIDIS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];
/// Colours of sub-maps, the first one's first.
const SUBMAPS: [[u8; 3]; 6] =
    [[90, 160, 255], [255, 150, 60], [120, 220, 120], [230, 110, 200], [240, 220, 90], [120, 220, 220]];

pub(crate) const TRAJECTORY: [u8; 3] = [80, 160, 255];
pub(crate) const TRUTH: [u8; 3] = [150, 150, 150];
pub(crate) const COVISIBILITY: [u8; 4] = [110, 160, 110, 90];
pub(crate) const LOOP: [u8; 3] = [255, 60, 60];

/// A share of 0 to 1 in the colours of viridis, red green blue.
pub(crate) fn viridis(share: f64) -> [u8; 3] {
    let at = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let i = (at as usize).min(VIRIDIS.len() - 2);
    let part = at - i as f64;
    let mix = |c: usize| f64::from(VIRIDIS[i][c]) * (1.0 - part) + f64::from(VIRIDIS[i + 1][c]) * part;
    [mix(0).round() as u8, mix(1).round() as u8, mix(2).round() as u8]
}

/// The colour of a feature by what tracking made of it.
pub(crate) fn of_state(state: FeatureState) -> [u8; 3] {
    match state {
        FeatureState::Tracked => [70, 220, 90],
        FeatureState::New => [80, 140, 255],
        FeatureState::Outlier => [255, 70, 60],
    }
}

/// The colour of a sub-map by its root.
pub(crate) fn of_submap(root: u32) -> [u8; 3] {
    // Roots are far apart, the first is 0: neighbours get other colours.
    SUBMAPS[if root == 0 { 0 } else { 1 + (root as usize) % (SUBMAPS.len() - 1) }]
}

/// As Rerun wants it.
pub(crate) fn color([red, green, blue]: [u8; 3]) -> Color {
    Color::from_rgb(red, green, blue)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viridis_goes_through_its_points_and_stays_inside() {
        assert_eq!(viridis(0.0), VIRIDIS[0]);
        assert_eq!(viridis(0.5), VIRIDIS[4]);
        assert_eq!(viridis(7.0), VIRIDIS[8]);
        assert_eq!(viridis(f64::NAN), VIRIDIS[0]);
        assert_eq!(viridis(1.0 / 16.0), [70, 23, 103]);
    }
}
