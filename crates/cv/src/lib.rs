//! OpenCV in one place: the reference that benchmarks and tests compare with, and the program `dsslam-video`.
//!
//! No other crate links OpenCV, and the program does not depend on this one: neither its build nor its start pays for it.

mod calibration;

use geometry::GrayImage;
use opencv::core::{self, KeyPoint, Mat, Ptr, Vector};
use opencv::features2d::{self, ORB};
use opencv::imgproc;
use opencv::prelude::*;

pub use calibration::{Rectification, project, rectify_maps, remap, stereo_rectify};
pub use opencv::Result;

/// OpenCV's ORB with the parameters of the benchmarks: 8 levels of factor 1.2, FAST threshold 20, Harris scores.
pub struct Orb {
    detector: Ptr<ORB>,
}

impl Orb {
    /// A detector that keeps `n_features` per image. OpenCV's own threads are switched off, for the whole process.
    ///
    /// # Errors
    /// What OpenCV refuses.
    pub fn new(n_features: usize) -> Result<Self> {
        core::set_num_threads(1)?;
        let keep = i32::try_from(n_features).unwrap_or(i32::MAX);
        let detector = ORB::create(keep, 1.2, 8, 31, 0, 2, features2d::ORB_ScoreType::HARRIS_SCORE, 31, 20)?;
        Ok(Self { detector })
    }

    /// Detects and describes `image`; returns the number of features. One call of this is the unit U of the benchmarks.
    ///
    /// # Errors
    /// What OpenCV refuses.
    pub fn detect_and_compute(&mut self, image: &GrayImage) -> Result<usize> {
        let mut keypoints = Vector::<KeyPoint>::new();
        let mut descriptors = Mat::default();
        let view = view(image)?;
        self.detector.detect_and_compute(
            &view,
            &core::no_array(),
            &mut keypoints,
            &mut descriptors,
            false,
        )?;
        Ok(keypoints.len())
    }
}

/// Detects and describes `n_features` in `image` with a fresh [`Orb`]; returns the number of features found.
///
/// # Errors
/// What OpenCV refuses.
pub fn orb_detect_and_compute(image: &GrayImage, n_features: usize) -> Result<usize> {
    Orb::new(n_features)?.detect_and_compute(image)
}

/// `image` resized to `width` x `height` pixels with OpenCV's bilinear interpolation.
///
/// # Errors
/// What OpenCV refuses, such as an empty size.
pub fn resize_linear(image: &GrayImage, width: usize, height: usize) -> Result<GrayImage> {
    let size = core::Size::new(i32::try_from(width)?, i32::try_from(height)?);
    let mut resized = Mat::default();
    imgproc::resize(&view(image)?, &mut resized, size, 0.0, 0.0, imgproc::INTER_LINEAR)?;
    copy_out(&resized)
}

/// `image` blurred by OpenCV's 7 x 7 Gaussian of sigma 2, borders reflected without repeating the edge.
///
/// # Errors
/// What OpenCV refuses.
pub fn gaussian_blur_7x7(image: &GrayImage) -> Result<GrayImage> {
    let mut blurred = Mat::default();
    let kernel = core::Size::new(7, 7);
    imgproc::gaussian_blur_def(&view(image)?, &mut blurred, kernel, 2.0)?;
    copy_out(&blurred)
}

/// The corners that OpenCV's FAST-9 with non-maximum suppression finds: (x, y, score), in OpenCV's order.
///
/// # Errors
/// What OpenCV refuses.
pub fn fast9(image: &GrayImage, threshold: u8) -> Result<Vec<(usize, usize, f32)>> {
    let mut keypoints = Vector::<KeyPoint>::new();
    features2d::fast(&view(image)?, &mut keypoints, i32::from(threshold), true)?;
    Ok(keypoints.iter().map(|k| (k.pt().x as usize, k.pt().y as usize, k.response())).collect())
}

/// A matrix header over the image's own bytes.
fn view(image: &GrayImage) -> Result<opencv::boxed_ref::BoxedRef<'_, Mat>> {
    Mat::new_rows_cols_with_data(i32::try_from(image.height)?, i32::try_from(image.width)?, &image.data)
}

/// A copy of a continuous 8-bit matrix.
fn copy_out(mat: &Mat) -> Result<GrayImage> {
    Ok(GrayImage {
        width: mat.cols() as usize,
        height: mat.rows() as usize,
        data: mat.data_bytes()?.to_vec(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares of random-looking brightness: many corners.
    fn chequered(width: usize, height: usize) -> GrayImage {
        let shade = |x: usize, y: usize| ((x / 9 * 37 + y / 9 * 101) % 251) as u8;
        let data = (0..height).flat_map(|y| (0..width).map(move |x| shade(x, y))).collect();
        GrayImage { width, height, data }
    }

    #[test]
    fn orb_finds_corners_and_none_on_a_flat_image() {
        assert!(orb_detect_and_compute(&chequered(320, 240), 500).unwrap() > 100);
        let flat = GrayImage { width: 320, height: 240, data: vec![90; 320 * 240] };
        assert_eq!(orb_detect_and_compute(&flat, 500).unwrap(), 0);
    }

    #[test]
    fn resizing_halves_and_blurring_keeps_a_flat_image() {
        let half = resize_linear(&chequered(320, 240), 160, 120).unwrap();
        assert_eq!((half.width, half.height, half.data.len()), (160, 120, 160 * 120));
        let flat = GrayImage { width: 40, height: 30, data: vec![90; 40 * 30] };
        assert_eq!(gaussian_blur_7x7(&flat).unwrap().data, flat.data);
    }

    #[test]
    fn fast_finds_bright_dots() {
        let dots = [(20, 20), (20, 40), (41, 30)];
        let shade = |x: usize, y: usize| if dots.contains(&(x, y)) { 220 } else { 30 };
        let data = (0..60).flat_map(|y| (0..60).map(move |x| shade(x, y))).collect();
        let mut corners = fast9(&GrayImage { width: 60, height: 60, data }, 20).unwrap();
        corners.sort_by_key(|&(x, y, _)| (x, y));
        assert_eq!(corners.iter().map(|&(x, y, _)| (x, y)).collect::<Vec<_>>(), dots);
        assert!(corners.iter().all(|&(.., score)| score > 20.0), "{corners:?}");
    }
}
