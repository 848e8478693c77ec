//! Activation as colors over the image.

use geometry::{GrayImage, Raster};

/// Red, green and blue, 0 to 255.
pub type Rgb = [u8; 3];

/// Colors of activation 0, 1/4, 1/2, 3/4 and 1.
const SCALE: [[f32; 3]; 5] = [
    [40.0, 60.0, 220.0],
    [30.0, 170.0, 220.0],
    [60.0, 200.0, 90.0],
    [240.0, 200.0, 40.0],
    [220.0, 50.0, 30.0],
];
/// Share of the color; the rest is the image.
const OPACITY: f32 = 0.55;

/// The image under the trust in its pixels (column, row): blue for 0 over green to red for 1.
#[must_use]
pub fn heat_map(image: &GrayImage, trust: impl Fn(f32, f32) -> f32) -> Raster<Rgb> {
    let mut picture = Raster::new(image.width, image.height, [0; 3]);
    for y in 0..image.height {
        for (x, pixel) in picture.row_mut(y).iter_mut().enumerate() {
            let gray = f32::from(image.at(x, y));
            let color = color(trust(x as f32, y as f32));
            *pixel = color.map(|c| (c * OPACITY + gray * (1.0 - OPACITY)).round() as u8);
        }
    }
    picture
}

/// The color of a trust from 0 to 1, as legends show it.
#[must_use]
pub fn heat_color(trust: f32) -> Rgb {
    color(trust).map(|c| c.round() as u8)
}

fn color(activation: f32) -> [f32; 3] {
    let position = activation.clamp(0.0, 1.0) * (SCALE.len() - 1) as f32;
    let first = (position as usize).min(SCALE.len() - 2);
    let t = position - first as f32;
    std::array::from_fn(|i| SCALE[first][i] + (SCALE[first + 1][i] - SCALE[first][i]) * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn low_activation_is_blue_and_high_activation_red() {
        let image = GrayImage::new(10, 4, 100);
        let picture = heat_map(&image, |x, _| if x < 5.0 { 0.0 } else { 1.0 });
        assert_eq!((picture.width, picture.height), (10, 4));
        let ([low_red, _, low_blue], [high_red, _, high_blue]) = (picture.at(0, 2), picture.at(9, 2));
        assert!(low_blue > low_red && high_red > high_blue);
        assert_eq!(color(0.5), SCALE[2]);
    }
}
