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

#[test]
fn every_format_gives_the_same_gray() {
    use image::{DynamicImage, GrayImage, ImageFormat, Luma, Rgb};
    let folder = Folder::new();
    let gray = GrayImage::from_fn(40, 20, |x, y| Luma([(x * 6 + y) as u8]));
    let color = DynamicImage::ImageRgb8(image::RgbImage::from_fn(40, 20, |x, y| Rgb([(x * 6 + y) as u8; 3])));
    let wide = image::ImageBuffer::from_fn(40, 20, |x, y| Luma([((x * 6 + y) as u16) * 257]));
    let twelve = image::ImageBuffer::from_fn(40, 20, |x, y| Luma([((x * 6 + y) as u16) * 16]));
    let expected = gray.as_raw();
    for (name, image, format) in [
        ("a.pgm", DynamicImage::ImageLuma8(gray.clone()), ImageFormat::Pnm),
        ("a.ppm", color.clone(), ImageFormat::Pnm),
        ("a.bmp", color.clone(), ImageFormat::Bmp),
        ("a.tiff", DynamicImage::ImageLuma8(gray.clone()), ImageFormat::Tiff),
        ("a.webp", color, ImageFormat::WebP),
        ("wide.png", DynamicImage::ImageLuma16(wide.clone()), ImageFormat::Png),
        ("wide.tiff", DynamicImage::ImageLuma16(wide), ImageFormat::Tiff),
        ("twelve.png", DynamicImage::ImageLuma16(twelve), ImageFormat::Png),
    ] {
        let path = folder.file(name);
        image.save_with_format(&path, format).unwrap();
        assert_eq!(&dsslam_io::load_gray(&path).unwrap().data, expected, "{name}");
        assert_eq!(dsslam_io::image_size(&path).unwrap().to_string(), "40x20", "{name}");
    }
}

#[test]
fn a_jpeg_that_is_cut_anywhere_is_broken() {
    let folder = Folder::new();
    let path = folder.file("a.jpg");
    let gray = image::GrayImage::from_fn(64, 48, |x, y| image::Luma([(x * 3 + y * 2) as u8]));
    gray.save(&path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    assert!(dsslam_io::load_gray(&path).is_ok());
    for percent in [20, 50, 95, 99] {
        std::fs::write(&path, &whole[..whole.len() * percent / 100]).unwrap();
        let message = folder.hide(dsslam_io::load_gray(&path).unwrap_err());
        assert_eq!(message, "DIR/a.jpg: truncated or corrupt JPEG image: it ends before its end marker");
    }
}

#[test]
fn depth_in_meters_as_tiff_and_16_bits_as_tiff() {
    let folder = Folder::new();
    let path = folder.file("z.tiff");
    let meters: Vec<f32> = (0..800).map(|i| i as f32 * 0.01).collect();
    let mut file = std::fs::File::create(&path).unwrap();
    tiff::encoder::TiffEncoder::new(&mut file)
        .unwrap()
        .write_image::<tiff::encoder::colortype::Gray32Float>(40, 20, &meters)
        .unwrap();
    let depth = dsslam_io::load_depth(&path).unwrap();
    assert_eq!((depth.width, depth.height, depth.data[0], depth.data[150]), (40, 20, 0, 3000));
    let units: image::ImageBuffer<image::Luma<u16>, _> =
        image::ImageBuffer::from_fn(40, 20, |x, _| image::Luma([if x == 3 { 65535 } else { x as u16 }]));
    units.save(&path).unwrap();
    let depth = dsslam_io::load_depth(&path).unwrap();
    assert_eq!((depth.data[2], depth.data[3]), (2, 0), "65535 means unknown depth");
}

#[test]
fn depth_that_cannot_be_used_is_refused_before_the_run() {
    let folder = Folder::tum();
    for name in ["a", "b", "c"] {
        folder.gray(&format!("depth/{name}.png"), 40, 20);
    }
    let error = dsslam_io::open_sequence(folder.path(), None).unwrap_err();
    assert_eq!(
        folder.hide(error),
        "DIR/depth/a.png: found 8-bit gray, expected 16-bit gray (a depth image), or meters as 32-bit floats (TIFF, NumPy)"
    );
    for name in ["a", "b", "c"] {
        dsslam_io::save_png_depth(
            &folder.file(&format!("depth/{name}.png")),
            &geometry::DepthImage::new(20, 10, 9),
        )
        .unwrap();
    }
    let error = dsslam_io::open_sequence(folder.path(), None).unwrap_err();
    assert_eq!(
        folder.hide(error),
        "DIR/depth/a.png: found 20x10 pixels, expected 40x20 (as DIR/rgb/a.png; depth must be registered to the color image)"
    );
}

#[test]
fn a_picture_that_is_stored_sideways_is_named() {
    let folder = Folder::new();
    let path = folder.file("a.jpg");
    image::GrayImage::new(40, 20).save(&path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    // Orientation 6 in the smallest EXIF segment: big endian, one entry.
    let exif = [
        &[0xff, 0xe1, 0, 34][..],
        b"Exif\0\0MM\0*\0\0\0\x08\0\x01",
        &[0x01, 0x12, 0, 3, 0, 0, 0, 1, 0, 6, 0, 0, 0, 0, 0, 0],
    ]
    .concat();
    std::fs::write(&path, [&whole[..2], &exif, &whole[2..]].concat()).unwrap();
    let expected = dsslam_io::ImageSize { width: 20, height: 40 };
    let found = dsslam_io::image_size(&path).unwrap();
    let error = dsslam_io::ImageError::wrong_size(&path, found, expected, "resolution in cam.yaml");
    assert_eq!(
        folder.hide(error),
        "DIR/a.jpg: found 40x20 pixels, expected 20x40 (resolution in cam.yaml; the file has the EXIF note that it is to be shown \
         turned by 90 degrees, which is not done here: turn the images first)"
    );
}
