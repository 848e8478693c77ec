//! COLMAP models read by a small reader that follows COLMAP's own description, its half pixel included.

use std::collections::BTreeMap;

use dsslam_export::{Scene, Tint, colmap_binary, colmap_text};
use geometry::{SE3, SO3, Vec3};

use super::world::*;

/// A model as COLMAP sees it.
#[derive(Debug, Default, PartialEq)]
struct Model {
    /// Width, height, fx, fy, cx, cy.
    cameras: BTreeMap<u32, Vec<f64>>,
    images: BTreeMap<u32, Image>,
    points: BTreeMap<u64, Point>,
}

#[derive(Debug, PartialEq)]
struct Image {
    /// Quaternion w x y z, translation.
    pose: Vec<f64>,
    camera: u32,
    name: String,
    features: Vec<(f64, f64, Option<u64>)>,
}

#[derive(Debug, PartialEq)]
struct Point {
    position: Vec<f64>,
    color: Vec<u8>,
    error: f64,
    track: Vec<(u32, u32)>,
}

struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (head, rest) = self.0.split_first_chunk::<N>().unwrap();
        self.0 = rest;
        *head
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    fn reals(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| f64::from_le_bytes(self.take())).collect()
    }

    fn name(&mut self) -> String {
        let letters = std::iter::from_fn(|| Some(self.take::<1>()[0]).filter(|&byte| byte != 0));
        String::from_utf8(letters.collect()).unwrap()
    }
}

fn read_binary(files: &dsslam_export::ColmapFiles) -> Model {
    let mut model = Model::default();
    let mut bytes = Bytes(&files.cameras);
    for _ in 0..bytes.u64() {
        let (id, kind) = (bytes.u32(), bytes.u32());
        assert_eq!(kind, 1, "PINHOLE");
        let size = [bytes.u64() as f64, bytes.u64() as f64];
        model.cameras.insert(id, [&size[..], &bytes.reals(4)].concat());
    }
    assert!(bytes.0.is_empty());
    bytes = Bytes(&files.images);
    for _ in 0..bytes.u64() {
        let (id, pose, camera, name) = (bytes.u32(), bytes.reals(7), bytes.u32(), bytes.name());
        let n = bytes.u64();
        let mut feature = || (bytes.reals(2), bytes.u64());
        let features = (0..n).map(|_| feature()).map(|(p, id)| (p[0], p[1], (id != u64::MAX).then_some(id)));
        let features = features.collect();
        model.images.insert(id, Image { pose, camera, name, features });
    }
    assert!(bytes.0.is_empty());
    bytes = Bytes(&files.points);
    for _ in 0..bytes.u64() {
        let (id, position, color) = (bytes.u64(), bytes.reals(3), bytes.take::<3>().to_vec());
        let (error, n) = (bytes.reals(1)[0], bytes.u64());
        let track = (0..n).map(|_| (bytes.u32(), bytes.u32())).collect();
        model.points.insert(id, Point { position, color, error, track });
    }
    assert!(bytes.0.is_empty());
    model
}

/// Lines that are not comments, as words.
fn lines(text: &[u8]) -> Vec<Vec<&str>> {
    let text = std::str::from_utf8(text).unwrap();
    text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(' ').collect()).collect()
}

fn numbers(words: &[&str]) -> Vec<f64> {
    words.iter().map(|word| word.parse().unwrap()).collect()
}

fn read_text(files: &dsslam_export::ColmapFiles) -> Model {
    let mut model = Model::default();
    for line in lines(&files.cameras) {
        assert_eq!(line[1], "PINHOLE");
        model.cameras.insert(line[0].parse().unwrap(), numbers(&line[2..]));
    }
    for pair in lines(&files.images).chunks_exact(2) {
        let (head, features) = (&pair[0], &pair[1]);
        let feature = |f: &[&str]| (f[0].parse().unwrap(), f[1].parse().unwrap(), f[2].parse().ok());
        let image = Image {
            pose: numbers(&head[1..8]),
            camera: head[8].parse().unwrap(),
            name: head[9].to_owned(),
            features: features.chunks_exact(3).map(feature).collect(),
        };
        model.images.insert(head[0].parse().unwrap(), image);
    }
    for line in lines(&files.points) {
        let track = line[8..].chunks_exact(2).map(|t| (t[0].parse().unwrap(), t[1].parse().unwrap()));
        let point = Point {
            position: numbers(&line[1..4]),
            color: line[4..7].iter().map(|word| word.parse().unwrap()).collect(),
            error: line[7].parse().unwrap(),
            track: track.collect(),
        };
        model.points.insert(line[0].parse().unwrap(), point);
    }
    model
}

/// The distance between a feature and the projection of its point, as COLMAP computes it.
fn distance(model: &Model, image: &Image, feature: usize) -> f64 {
    let (x, y, id) = image.features[feature];
    let [w, i, j, k] = image.pose[..4] else { panic!("four numbers") };
    // Hamilton's quaternion, real part first: q v q*.
    let rotate = |v: Vec3| {
        let u = Vec3::new(i, j, k);
        v + 2.0 * u.cross(&(u.cross(&v) + w * v))
    };
    let point = rotate(Vec3::from_row_slice(&model.points[&id.unwrap()].position));
    let point = point + Vec3::from_row_slice(&image.pose[4..]);
    let camera = &model.cameras[&image.camera];
    let projected = (camera[2] * point.x / point.z + camera[4], camera[3] * point.y / point.z + camera[5]);
    (projected.0 - x).hypot(projected.1 - y)
}

#[test]
fn text_and_binary_are_the_same_model_with_our_error_of_reprojection() {
    let scene = Scene::of(&street(), 0).unwrap();
    let colors = Tint::Observations.colors(&scene);
    let model = read_binary(&colmap_binary(&scene, &colors));
    assert_eq!(model, read_text(&colmap_text(&scene, &colors)));
    let (mut sum, mut n) = (0.0, 0);
    for (id, point) in &model.points {
        let seen = |&(image, feature): &(u32, u32)| {
            let image = &model.images[&image];
            assert_eq!(image.features[feature as usize].2, Some(*id));
            distance(&model, image, feature as usize)
        };
        let distances: Vec<f64> = point.track.iter().map(seen).collect();
        let mean = distances.iter().sum::<f64>() / distances.len() as f64;
        assert!((mean - point.error).abs() < 1e-9);
        (sum, n) = (sum + distances.iter().sum::<f64>(), n + distances.len());
    }
    let ours = scene.reprojection();
    assert_eq!(n, ours.n_observations);
    assert!((sum / n as f64 - ours.mean_px).abs() < 1e-9 && ours.mean_px > 0.1);
}

#[test]
fn pixels_count_from_the_corner_and_ids_from_one() {
    let scene = Scene::of(&street(), 0).unwrap();
    let model = read_binary(&colmap_binary(&scene, &Tint::Age.colors(&scene)));
    let expected = [80.0, 60.0, CAMERA.fx, CAMERA.fy, CAMERA.cx + 0.5, CAMERA.cy + 0.5];
    assert_eq!(model.cameras[&1], expected);
    assert_eq!(model.images.keys().copied().collect::<Vec<_>>(), [1, 2, 3]);
    let (first, third) = (&model.images[&1], &model.images[&3]);
    assert_eq!((first.name.as_str(), third.name.as_str()), ("000000.png", "000008.png"));
    assert_eq!(first.features[N_POINTS as usize], (1.5, 2.5, None), "our pixel (1, 2), and no point");
    assert_eq!(first.pose, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let q = rotation_of(&third.pose);
    let pose = SE3::new(q, Vec3::from_row_slice(&third.pose[4..]));
    assert!((pose * cam_from_world(2).inverse()).log().norm() < 1e-12);
    assert_eq!(model.points.keys().copied().collect::<Vec<_>>(), (1..=8).collect::<Vec<u64>>());
}

/// The rotation of a unit quaternion w x y z: its angle is twice that of its vector.
fn rotation_of(wxyz: &[f64]) -> SO3 {
    let vector = Vec3::from_row_slice(&wxyz[1..4]);
    let angle = 2.0 * vector.norm().atan2(wxyz[0]);
    SO3::exp(&(vector.normalize() * angle))
}
