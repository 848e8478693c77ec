//! Colors.

use draw::gradient;
use events::FeatureState;
use rerun::Color;

/// Colors of sub-maps, the first one's first.
const SUBMAPS: [[u8; 3]; 6] =
    [[90, 160, 255], [190, 130, 255], [120, 220, 120], [230, 110, 200], [240, 220, 90], [120, 220, 220]];
/// The least share of the color map that is drawn on the dark background of space.
const VISIBLE: f64 = 0.25;

pub(crate) const TRAJECTORY: [u8; 3] = [255, 130, 30];
pub(crate) const TRUTH: [u8; 3] = [225, 225, 225];
pub(crate) const COVISIBILITY: [u8; 4] = [110, 160, 110, 90];
pub(crate) const LOOP: [u8; 3] = [255, 60, 60];

/// The color of a share of 0 to 1 of a point in space, which has no image behind it: without the darkest colors.
pub(crate) fn in_space(share: f64) -> [u8; 3] {
    gradient(VISIBLE + (1.0 - VISIBLE) * share)
}

/// The color of a feature by its tracking outcome.
pub(crate) fn of_state(state: FeatureState) -> [u8; 3] {
    match state {
        FeatureState::Tracked => [70, 220, 90],
        FeatureState::New => [80, 140, 255],
        FeatureState::Outlier => [255, 70, 60],
    }
}

/// The color of a sub-map by its root.
pub(crate) fn of_submap(root: u32) -> [u8; 3] {
    // Roots are far apart, the first is 0: neighbors get other colors.
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
    fn points_in_space_are_bright() {
        let brightness = |share: f64| in_space(share).iter().map(|&c| u32::from(c)).sum::<u32>();
        assert!(brightness(0.0) > 2 * gradient(0.0).iter().map(|&c| u32::from(c)).sum::<u32>() * 3 / 4);
        assert_eq!(in_space(1.0), gradient(1.0));
    }

    #[test]
    fn neighboring_sub_maps_differ() {
        assert_ne!(of_submap(0), of_submap(17));
        assert_ne!(of_submap(17), of_submap(18));
    }
}
