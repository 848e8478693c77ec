//! Images beside the model: found, copied or redrawn, and the colors of the points in them.

use std::path::Path;

use dsslam_export::{ExportError, Scene, SceneImages};
use geometry::{CameraModel, Distortion, GrayImage, Raster, Vec2};
use io::{Sensor, Sequence};
use tempfile::TempDir;

use super::world::*;

/// A KITTI folder of one camera with 9 frames; `image(i)` is the i-th.
fn sequence(image: impl Fn(usize) -> GrayImage) -> (TempDir, Sequence) {
    let folder = tempfile::tempdir().unwrap();
    let times: Vec<String> = (0..9).map(|i| format!("{}\n", 0.1 * f64::from(i))).collect();
    std::fs::write(folder.path().join("times.txt"), times.concat()).unwrap();
    std::fs::create_dir(folder.path().join("image_0")).unwrap();
    for i in 0..9 {
        io::save_png_gray(&folder.path().join(format!("image_0/{i:06}.png")), &image(i)).unwrap();
    }
    let sequence = io::open_sequence(folder.path(), Some(Sensor::Mono)).unwrap();
    (folder, sequence)
}

fn of_size(i: usize) -> GrayImage {
    GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| (2 * x + y + 3 * i) as u8)
}

#[test]
fn images_are_copied_and_give_the_colors() {
    let (folder, sequence) = sequence(of_size);
    let scene = Scene::of(&street(), 0).unwrap();
    let images = SceneImages::find(&scene, &sequence, folder.path()).unwrap();
    assert!(!images.are_redrawn());
    let out = tempfile::tempdir().unwrap();
    let colors = images.write(&scene, out.path()).unwrap();
    assert_eq!(colors, images.point_colors(&scene).unwrap());
    for (view, i) in scene.views.iter().zip([0, 4, 8]) {
        let original = std::fs::read(folder.path().join(format!("image_0/{i:06}.png"))).unwrap();
        assert_eq!(std::fs::read(out.path().join(&view.name)).unwrap(), original);
    }
    for (point, color) in scene.points.iter().zip(&colors) {
        let seen = |&(view, feature): &(usize, usize)| {
            let pixel: &Vec2 = &scene.views[view].pixels[feature];
            u32::from(of_size(4 * view).at(pixel.x.round() as usize, pixel.y.round() as usize))
        };
        let sum: u32 = point.track.iter().map(seen).sum();
        assert_eq!(*color, [((sum + 1) / 3) as u8; 3]);
    }
}

#[test]
fn a_lens_is_taken_out_of_the_images() {
    let distortion = Distortion { k1: -0.2, k2: 0.05, p1: 0.001, p2: -0.002, k3: 0.0 };
    let model = CameraModel::Pinhole { camera: CAMERA, distortion };
    // What an ideal camera would show is brightest where the feature is.
    let ideal = |p: &Vec2| (200.0 - 6.0 * (p - Vec2::new(60.0, 15.0)).norm()).max(0.0) as u8;
    let through_lens = |_| {
        let ideal_pixel = |p: Vec2| {
            let ray = model.unproject(&p);
            CAMERA.project(&ray)
        };
        GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| ideal(&ideal_pixel(Vec2::new(x as f64, y as f64))))
    };
    let (folder, sequence) = sequence(through_lens);
    let scene = Scene::of(&street_of(&rig(distortion)), 0).unwrap();
    let images = SceneImages::find(&scene, &sequence, folder.path()).unwrap();
    assert!(images.are_redrawn());
    let out = tempfile::tempdir().unwrap();
    images.write(&scene, out.path()).unwrap();
    let written = io::load_gray(&out.path().join("000004.png")).unwrap();
    let raw = io::load_gray(&folder.path().join("image_0/000004.png")).unwrap();
    let brightest = |image: &Raster<u8>| {
        let at = (0..image.data.len()).max_by_key(|&i| image.data[i]).unwrap();
        Vec2::new((at % image.width) as f64, (at / image.width) as f64)
    };
    assert!((brightest(&raw) - Vec2::new(60.0, 15.0)).norm() > 1.0, "the lens moved it");
    assert!((brightest(&written) - Vec2::new(60.0, 15.0)).norm() <= 1.0);
}

#[test]
fn a_keyframe_of_another_sequence_is_named() {
    let (folder, mut sequence) = sequence(of_size);
    sequence.frames[4].timestamp_ns += 10_000_000;
    let scene = Scene::of(&street(), 0).unwrap();
    let error = SceneImages::find(&scene, &sequence, Path::new("street")).unwrap_err();
    drop(folder);
    assert_eq!(
        error.to_string(),
        "street: found no frame at 0.4 s, the time of keyframe 1 (frame 4): the map was built from another sequence"
    );
}

#[test]
fn images_of_another_size_and_missing_ones_are_named() {
    let scene = Scene::of(&street(), 0).unwrap();
    let out = tempfile::tempdir().unwrap();
    let (folder, wide) =
        sequence(|i| if i == 4 { GrayImage::new(SIZE.0 + 1, SIZE.1, 0) } else { of_size(i) });
    let file = folder.path().join("image_0/000004.png");
    let images = SceneImages::find(&scene, &wide, folder.path()).unwrap();
    let error = images.write(&scene, out.path()).unwrap_err();
    let expected = format!("{}: found 81x60 pixels, expected 80x60 (as the map's camera)", file.display());
    assert_eq!(error.to_string(), expected);
    std::fs::remove_file(&file).unwrap();
    let error = images.write(&scene, out.path()).unwrap_err();
    assert!(matches!(error, ExportError::Image(io::ImageError::Missing { .. })), "{error}");
}
