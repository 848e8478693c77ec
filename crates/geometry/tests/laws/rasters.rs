//! Images as plain data.

use dsslam_geometry::{GrayImage, Raster};

#[test]
fn places_are_row_after_row() {
    let raster = Raster::from_fn(3, 2, |x, y| 10 * y + x);
    assert_eq!(raster.data, [0, 1, 2, 10, 11, 12]);
    assert_eq!(raster.row(1), [10, 11, 12]);
    assert_eq!(raster.at(2, 1), 12);
    assert_eq!((raster.get(2, 1), raster.get(3, 0), raster.get(0, 2)), (Some(12), None, None));
}

#[test]
fn rows_can_be_written() {
    let mut image = GrayImage::new(2, 2, 7);
    image.row_mut(0).fill(1);
    assert_eq!(image, GrayImage::from_vec(2, 2, vec![1, 1, 7, 7]).unwrap());
}

#[test]
fn data_of_the_wrong_length_are_refused() {
    assert!(GrayImage::from_vec(2, 2, vec![0; 3]).is_none());
    assert!(GrayImage::from_vec(usize::MAX, 2, vec![]).is_none());
    assert!(GrayImage::from_vec(0, 5, vec![]).is_some());
}
