//! Images survive writing and reading; color becomes gray as in OpenCV.

use dsslam_io::{ImageSize, Rgb};
use geometry::{DepthImage, GrayImage};

use super::support::Folder;

/// Odd sizes, so that rows are not a multiple of anything.
const WIDTH: usize = 37;
const HEIGHT: usize = 11;

#[test]
fn gray_round_trip() {
    let folder = Folder::new();
    let image = GrayImage::from_fn(WIDTH, HEIGHT, |x, y| (x * 31 + y * 97) as u8);
    dsslam_io::save_png_gray(&folder.file("a.png"), &image).unwrap();
    assert_eq!(dsslam_io::load_gray(&folder.file("a.png")).unwrap(), image);
    assert_eq!(
        dsslam_io::image_size(&folder.file("a.png")).unwrap(),
        ImageSize { width: WIDTH, height: HEIGHT }
    );
    assert_eq!(folder.names(), ["a.png"], "no temporary file is left");
}

#[test]
fn depth_keeps_sixteen_bits() {
    let folder = Folder::new();
    let image = DepthImage::from_fn(WIDTH, HEIGHT, |x, y| (x * 1777 + y * 40_009) as u16);
    dsslam_io::save_png_depth(&folder.file("a.png"), &image).unwrap();
    assert_eq!(dsslam_io::load_depth(&folder.file("a.png")).unwrap(), image);
}

#[test]
fn color_becomes_gray() {
    let folder = Folder::new();
    let colors = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [9, 9, 9], [255, 255, 255], [10, 200, 30]];
    let image = Rgb::from_vec(3, 2, colors.to_vec()).unwrap();
    dsslam_io::save_png_rgb(&folder.file("a.png"), &image).unwrap();
    // 10 * 0.299 + 200 * 0.587 + 30 * 0.114 = 123.81
    assert_eq!(dsslam_io::load_gray(&folder.file("a.png")).unwrap().data, [76, 150, 29, 9, 255, 124]);
}

#[test]
fn the_extension_does_not_matter() {
    let folder = Folder::new();
    let png = folder.gray("a.png", WIDTH, HEIGHT);
    let bytes = std::fs::read(&png).unwrap();
    let renamed = folder.write("b.jpg", bytes);
    assert_eq!(dsslam_io::load_gray(&renamed).unwrap(), dsslam_io::load_gray(&png).unwrap());
}

#[test]
fn jpeg_is_read() {
    let folder = Folder::new();
    let mut bytes = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 100)
        .encode(&[120; WIDTH * HEIGHT], WIDTH as u32, HEIGHT as u32, image::ExtendedColorType::L8)
        .unwrap();
    let path = folder.write("a.jpg", &bytes);
    let read = dsslam_io::load_gray(&path).unwrap();
    assert_eq!((read.width, read.height), (WIDTH, HEIGHT));
    assert!(read.data.iter().all(|value| value.abs_diff(120) <= 1));
    assert_eq!(dsslam_io::image_size(&path).unwrap(), ImageSize { width: WIDTH, height: HEIGHT });
    let cut = folder.write("cut.jpg", &bytes[..20]);
    let message = folder.hide(dsslam_io::load_gray(&cut).unwrap_err());
    assert!(message.starts_with("DIR/cut.jpg: truncated or corrupt JPEG image: "), "{message}");
}
