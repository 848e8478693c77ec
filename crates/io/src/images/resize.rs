//! Reduction of images: `input.scale`.

use geometry::{DepthImage, GrayImage, Raster};
use image::imageops::{FilterType, resize};
use image::{ImageBuffer, Luma};

use super::ImageSize;

/// A gray image reduced to a size, with the corners kept in place: each pixel is a weighted mean over the area that it covers and half
/// of that of its neighbors, so that nothing is seen that is finer than the new pixels.
pub fn reduce_gray(image: &GrayImage, size: ImageSize) -> GrayImage {
    let (width, height) = (image.width as u32, image.height as u32);
    let unchanged = image.width == size.width && image.height == size.height;
    let Some(buffer) = ImageBuffer::<Luma<u8>, _>::from_raw(width, height, image.data.as_slice()) else {
        return image.clone();
    };
    if unchanged {
        return image.clone();
    }
    let reduced = resize(&buffer, size.width as u32, size.height as u32, FilterType::Triangle);
    Raster { width: size.width, height: size.height, data: reduced.into_raw() }
}

/// A depth image reduced to a size by taking the pixel in the middle of each new one: depths of different things are never mixed.
pub fn reduce_depth(image: &DepthImage, size: ImageSize) -> DepthImage {
    let middle = |i: usize, new: usize, old: usize| (2 * i + 1) * old / (2 * new.max(1));
    Raster::from_fn(size.width, size.height, |x, y| {
        image.at(middle(x, size.width, image.width), middle(y, size.height, image.height))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF: ImageSize = ImageSize { width: 32, height: 24 };

    #[test]
    fn sizes_are_rounded_and_factors_exact() {
        let size = ImageSize { width: 751, height: 480 };
        assert_eq!(size.scaled(0.5), ImageSize { width: 376, height: 240 });
        assert_eq!(size.factors_to(size.scaled(0.5)), [376.0 / 751.0, 0.5]);
        assert_eq!(ImageSize { width: 3, height: 900 }.scaled(0.1), ImageSize { width: 1, height: 90 });
    }

    #[test]
    fn a_slope_stays_a_slope_at_the_scaled_places() {
        let image = GrayImage::from_fn(64, 48, |x, y| (2 * x + y + 10) as u8);
        let reduced = reduce_gray(&image, HALF);
        for (x, y) in [(3, 3), (16, 12), (28, 20)] {
            // The middle of a new pixel is (2 x + 0.5, 2 y + 0.5) of the old ones.
            let expected = 2.0 * (2.0 * x as f64 + 0.5) + 2.0 * y as f64 + 0.5 + 10.0;
            assert!((f64::from(reduced.at(x, y)) - expected).abs() <= 1.0, "{x} {y}");
        }
    }

    #[test]
    fn what_is_finer_than_a_pixel_becomes_its_mean() {
        let board = GrayImage::from_fn(64, 48, |x, y| if (x + y) % 2 == 0 { 200 } else { 0 });
        let reduced = reduce_gray(&board, HALF);
        let inside = |i: &usize| (1..31).contains(&(i % 32)) && (1..23).contains(&(i / 32));
        let values: Vec<u8> = (0..32 * 24).filter(inside).map(|i| reduced.data[i]).collect();
        assert!(values.iter().all(|v| (99..=101).contains(v)), "{values:?}");
        assert!(reduced.data.iter().all(|v| (90..=110).contains(v)), "at the edge the cells are cut");
        assert_eq!(reduce_gray(&board, ImageSize { width: 64, height: 48 }), board);
    }

    #[test]
    fn depths_are_taken_and_not_mixed() {
        let depth = DepthImage::from_fn(64, 48, |x, _| if x < 30 { 1000 } else { 9000 });
        let reduced = reduce_depth(&depth, HALF);
        assert_eq!((reduced.width, reduced.height), (32, 24));
        assert!(reduced.data.iter().all(|d| [1000, 9000].contains(d)));
        assert_eq!([reduced.at(14, 0), reduced.at(15, 0)], [1000, 9000]);
    }
}
