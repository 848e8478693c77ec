//! Broken images: the exact message, none of them a panic.

use std::fs;

use dsslam_io::{ImageError, ImageSize, check_size, load_depth, load_frame, load_gray, open_sequence};
use geometry::DepthImage;

use super::support::Folder;

#[test]
fn missing() {
    let folder = Folder::new();
    let path = folder.file("000000.png");
    assert_eq!(folder.hide(load_gray(&path).unwrap_err()), "DIR/000000.png: no such image");
    assert_eq!(folder.hide(dsslam_io::image_size(&path).unwrap_err()), "DIR/000000.png: no such image");
}

#[test]
fn empty() {
    let folder = Folder::new();
    let path = folder.write("000000.png", "");
    let expected = "DIR/000000.png: empty file (0 bytes), expected an image";
    assert_eq!(folder.hide(load_gray(&path).unwrap_err()), expected);
    assert_eq!(folder.hide(dsslam_io::image_size(&path).unwrap_err()), expected);
}

#[test]
fn text_as_image() {
    let folder = Folder::new();
    let path = folder.write("a.png", "# color images\nrgb\n");
    let expected = "DIR/a.png: not an image: begins with the text \"# color images\\nr\", expected PNG, JPEG, PGM, PPM, BMP, TIFF or WebP";
    assert_eq!(folder.hide(load_gray(&path).unwrap_err()), expected);
    assert_eq!(folder.hide(dsslam_io::image_size(&path).unwrap_err()), expected);
}

/// Depth as Blender writes it, a repository without its large files, a download that failed.
#[test]
fn files_that_are_taken_for_images_are_named() {
    let folder = Folder::new();
    for (bytes, what) in [
        (&b"\x76\x2f\x31\x01\x02\0\0\0"[..], "OpenEXR, which is not read"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:00\n", "a Git LFS pointer (git lfs pull"),
        (b"<!DOCTYPE html><html>404</html>", "a web page"),
        (b"\0\0\0\x18ftypheic\0\0\0\0", "HEIC, AVIF"),
    ] {
        let path = folder.write("a.png", bytes);
        let message = folder.hide(load_gray(&path).unwrap_err());
        assert!(message.starts_with(&format!("DIR/a.png: not an image: begins with {what}")), "{message}");
        assert!(dsslam_io::load_depth(&path).is_err());
    }
}

#[test]
fn other_bytes_as_image() {
    let folder = Folder::new();
    let path = folder.write("a.png", [0x1f, 0x8b, 0x08, 0x00]);
    assert_eq!(
        folder.hide(load_gray(&path).unwrap_err()),
        "DIR/a.png: not an image: begins with the bytes 1f 8b 08 00, expected PNG, JPEG, PGM, PPM, BMP, TIFF or WebP"
    );
}

#[test]
fn folder_as_image() {
    let folder = Folder::new();
    fs::create_dir(folder.file("a.png")).unwrap();
    let error = load_gray(&folder.file("a.png")).unwrap_err();
    assert!(matches!(error, ImageError::Unreadable { .. }), "{error}");
}

#[test]
fn truncated_at_every_length() {
    let folder = Folder::new();
    let whole = fs::read(folder.gray("whole.png", 40, 20)).unwrap();
    let path = folder.file("cut.png");
    // The last chunk, IEND (12 bytes), carries no pixels: without it the image is whole.
    for length in 8..whole.len() - 12 {
        fs::write(&path, &whole[..length]).unwrap();
        let error = load_gray(&path).unwrap_err();
        assert!(matches!(error, ImageError::Corrupt { format: "PNG", .. }), "{length}: {error}");
    }
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    assert_eq!(
        folder.hide(load_gray(&path).unwrap_err()),
        "DIR/cut.png: truncated or corrupt PNG image: unexpected end of file"
    );
}

#[test]
fn damaged_bytes_never_panic() {
    let folder = Folder::new();
    let whole = fs::read(folder.gray("whole.png", 40, 20)).unwrap();
    let path = folder.file("damaged.png");
    let mut n_refused = 0;
    for position in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[position] ^= 0x55;
        fs::write(&path, bytes).unwrap();
        n_refused += usize::from(load_gray(&path).is_err());
    }
    assert!(n_refused > whole.len() / 2, "{n_refused} of {}", whole.len());
}

#[test]
fn an_absurd_header_asks_for_no_memory() {
    let folder = Folder::new();
    let mut bytes = fs::read(folder.gray("whole.png", 40, 20)).unwrap();
    // Width in IHDR: 2^31 - 1; its checksum (bytes 29 to 33) made right again.
    bytes[16..20].copy_from_slice(&0x7fff_ffff_u32.to_be_bytes());
    let checksum = crc32(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
    let path = folder.write("huge.png", bytes);
    assert_eq!(
        folder.hide(load_gray(&path).unwrap_err()),
        "DIR/huge.png: truncated or corrupt PNG image: Image size exceeds limit"
    );
}

/// The checksum of PNG chunks.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(
            crc ^ u32::from(byte),
            |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 },
        )
    })
}

#[test]
fn wrong_kind_of_pixels() {
    let folder = Folder::new();
    let gray = folder.gray("gray.png", 4, 4);
    assert_eq!(
        folder.hide(load_depth(&gray).unwrap_err()),
        "DIR/gray.png: found 8-bit gray, expected 16-bit gray (a depth image), or meters as 32-bit floats (TIFF, NumPy)"
    );
}

#[test]
fn left_and_right_of_different_size() {
    let folder = Folder::kitti(2);
    folder.gray("image_1/000001.png", 40, 18);
    let sequence = open_sequence(folder.path(), None).unwrap();
    assert!(load_frame(&sequence.frames[0]).is_ok());
    let error = load_frame(&sequence.frames[1]).unwrap_err();
    assert_eq!(
        folder.hide(&error),
        "DIR/image_1/000001.png: found 40x18 pixels, expected 40x20 (as DIR/image_0/000001.png)"
    );
    let (small, large) = (ImageSize { width: 40, height: 18 }, ImageSize { width: 40, height: 20 });
    assert!(
        matches!(error, ImageError::WrongSize { found, expected, .. } if found == small && expected == large)
    );
}

#[test]
fn depth_of_another_size() {
    let folder = Folder::tum();
    dsslam_io::save_png_depth(&folder.file("depth/b.png"), &DepthImage::new(20, 10, 1)).unwrap();
    let sequence = open_sequence(folder.path(), None).unwrap();
    assert_eq!(
        folder.hide(load_frame(&sequence.frames[1]).unwrap_err()),
        "DIR/depth/b.png: found 20x10 pixels, expected 40x20 (as DIR/rgb/b.png)"
    );
}

#[test]
fn a_frame_of_another_size_than_the_sequence() {
    let folder = Folder::kitti(1);
    let sequence = open_sequence(folder.path(), None).unwrap();
    let source = &sequence.frames[0];
    let size = load_frame(source).unwrap().size();
    let check = |width| check_size(&source.left, size, ImageSize { width, height: 20 }, "as the first");
    assert_eq!(check(40), Ok(()));
    let error = check(41).unwrap_err();
    assert_eq!(
        folder.hide(error),
        "DIR/image_0/000000.png: found 40x20 pixels, expected 41x20 (as the first)"
    );
}

#[test]
fn unwritable_image() {
    let folder = Folder::new();
    folder.write("file", "x");
    let error = dsslam_io::save_png_depth(&folder.file("file/a.png"), &DepthImage::new(2, 2, 1)).unwrap_err();
    assert_eq!(folder.hide(error), "DIR/file/a.png: cannot be written: Not a directory (os error 20)");
}
