//! Colors: a palette for kinds, a gradient for amounts.

/// Red, green, blue.
pub type Color = [u8; 3];

/// Black.
pub const BLACK: Color = [0, 0, 0];
/// White.
pub const WHITE: Color = [255, 255, 255];

/// Distinguishable with every common color-vision deficiency on a gray image (after Okabe and Ito 2008), in order of use.
pub const PALETTE: [Color; 8] = [
    [86, 180, 233],
    [230, 159, 0],
    [0, 200, 145],
    [240, 228, 66],
    [213, 94, 0],
    [204, 121, 167],
    [0, 114, 178],
    [255, 255, 255],
];

/// Ten colors of matplotlib's `viridis` at equal distances.
const VIRIDIS: [Color; 10] = [
    [68, 1, 84],
    [72, 40, 120],
    [62, 73, 137],
    [49, 104, 142],
    [38, 130, 142],
    [31, 158, 137],
    [53, 183, 121],
    [110, 206, 88],
    [181, 222, 43],
    [253, 231, 37],
];

/// The color of an amount: `viridis`, dark violet at 0 over green to bright yellow at 1; what lies outside has the end's color, and
/// NaN that of 0.
pub fn gradient(amount: f64) -> Color {
    along(&VIRIDIS, amount)
}

/// A bright color for an amount, for thin lines over gray images: red at 0 over yellow and green to blue at 1.
pub fn spread(amount: f64) -> Color {
    const STOPS: [Color; 5] = [[255, 60, 40], [255, 190, 0], [120, 230, 40], [0, 205, 215], [90, 120, 255]];
    along(&STOPS, amount)
}

/// The color at an amount between stops at equal distances.
fn along(stops: &[Color], amount: f64) -> Color {
    let place = if amount.is_nan() { 0.0 } else { amount.clamp(0.0, 1.0) } * (stops.len() - 1) as f64;
    let below = (place as usize).min(stops.len() - 2);
    mix(stops[below], stops[below + 1], place - below as f64)
}

/// `share` of `over` on `under`.
pub(crate) fn mix(under: Color, over: Color, share: f64) -> Color {
    std::array::from_fn(|c| {
        (f64::from(under[c]) + share * (f64::from(over[c]) - f64::from(under[c]))).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_grows_brighter_and_keeps_to_its_ends() {
        let brightness = |c: Color| c.iter().map(|&v| u32::from(v)).sum::<u32>();
        let steps: Vec<u32> = (0..=20).map(|i| brightness(gradient(f64::from(i) / 20.0))).collect();
        assert!(steps.is_sorted(), "{steps:?}");
        assert_eq!((gradient(-1.0), gradient(2.0)), (VIRIDIS[0], VIRIDIS[9]));
        assert_eq!(gradient(f64::NAN), VIRIDIS[0]);
        assert_eq!(gradient(1.0 / 9.0), VIRIDIS[1]);
        assert_eq!((spread(0.0), spread(1.0)), ([255, 60, 40], [90, 120, 255]));
    }
}
