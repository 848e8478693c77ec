//! Color to gray with the weights and the rounding of OpenCV (ITU-R BT.601, 15-bit fixed point).

/// 0.299 in units of 2^-15.
const RED: u32 = 9798;
/// 0.587 in units of 2^-15.
const GREEN: u32 = 19235;
/// 0.114 in units of 2^-15; the three add up to one exactly, so that gray stays gray.
const BLUE: u32 = 3735;
const SHIFT: u32 = 15;

/// Brightness of one pixel.
pub fn brightness(red: u8, green: u8, blue: u8) -> u8 {
    let sum = u32::from(red) * RED + u32::from(green) * GREEN + u32::from(blue) * BLUE;
    ((sum + (1 << (SHIFT - 1))) >> SHIFT) as u8
}

/// Gray pixels out of interleaved ones of `channels` bytes, red first; what follows the third channel is left out.
pub(super) fn gray_from_color(pixels: &[u8], channels: usize) -> Vec<u8> {
    pixels.chunks_exact(channels).map(|pixel| brightness(pixel[0], pixel[1], pixel[2])).collect()
}

/// The first byte of each pixel: gray out of gray with alpha.
pub(super) fn first_channel(pixels: &[u8], channels: usize) -> Vec<u8> {
    pixels.iter().step_by(channels).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        assert_eq!(brightness(255, 0, 0), 76);
        assert_eq!(brightness(0, 255, 0), 150);
        assert_eq!(brightness(0, 0, 255), 29);
    }

    #[test]
    fn gray_stays_gray() {
        for value in 0..=255 {
            assert_eq!(brightness(value, value, value), value);
        }
    }

    #[test]
    fn within_one_half_and_rounding_of_the_real_weights() {
        for index in 0..4096_u32 {
            let (red, green, blue) = ((index * 37) as u8, (index * 101) as u8, (index * 211) as u8);
            let exact = 0.299 * f64::from(red) + 0.587 * f64::from(green) + 0.114 * f64::from(blue);
            assert!((f64::from(brightness(red, green, blue)) - exact).abs() <= 0.51);
        }
    }

    #[test]
    fn channels_are_skipped() {
        assert_eq!(gray_from_color(&[255, 0, 0, 9, 0, 0, 255, 9], 4), [76, 29]);
        assert_eq!(first_channel(&[1, 2, 3, 4], 2), [1, 3]);
    }
}
