//! COLMAP's sparse models, text and binary: cameras, images with their features, points with their tracks.
//!
//! Formats: <https://colmap.github.io/format.html>. COLMAP's pixel (0.5, 0.5) is the center of the upper left one, ours is (0, 0), so
//! half a pixel is added to principal points and features. Its ids count from 1: camera index, keyframe id and point id plus one.

mod binary;
mod text;

pub use binary::colmap_binary;
pub use text::colmap_text;

use draw::Color;
use geometry::Vec2;

use crate::scene::{Camera, Point, Scene, View};

/// What separates COLMAP's pixels from ours.
pub(crate) const HALF_PX: f64 = 0.5;
/// The number of the model `PINHOLE`: fx, fy, cx, cy.
const PINHOLE: i32 = 1;

/// The three files of a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColmapFiles {
    /// `cameras.txt` or `cameras.bin`.
    pub cameras: Vec<u8>,
    /// `images.txt` or `images.bin`.
    pub images: Vec<u8>,
    /// `points3D.txt` or `points3D.bin`.
    pub points: Vec<u8>,
}

/// fx, fy, cx, cy.
fn intrinsics(camera: &Camera) -> [f64; 4] {
    let pinhole = &camera.pinhole;
    [pinhole.fx, pinhole.fy, pinhole.cx + HALF_PX, pinhole.cy + HALF_PX]
}

/// Quaternion w x y z and translation of `cam_from_world`.
fn pose(view: &View) -> [f64; 7] {
    let (q, t) = (view.cam_from_world.rotation.to_quaternion(), view.cam_from_world.translation);
    [q.w, q.i, q.j, q.k, t.x, t.y, t.z]
}

/// Cameras and features are far fewer than 2^32.
fn camera_id(index: usize) -> u32 {
    index as u32 + 1
}

fn image_id(view: &View) -> u32 {
    view.keyframe.saturating_add(1)
}

fn point_id(point: &Point) -> u64 {
    u64::from(point.id) + 1
}

/// The features of a view: pixel and, where it shows a point, the point's id.
fn features<'a>(scene: &'a Scene, view: &'a View) -> impl ExactSizeIterator<Item = (Vec2, Option<u64>)> + 'a {
    let pixels = view.pixels.iter().map(|pixel| pixel.add_scalar(HALF_PX));
    let points = view.points.iter().map(|point| point.map(|index| point_id(&scene.points[index])));
    pixels.zip(points)
}

/// The track of a point: image id and index of the feature.
fn track<'a>(scene: &'a Scene, point: &'a Point) -> impl ExactSizeIterator<Item = (u32, u32)> + 'a {
    let element = |&(view, feature): &(usize, usize)| (image_id(&scene.views[view]), feature as u32);
    point.track.iter().map(element)
}

/// The points with their colors.
fn colored<'a>(
    scene: &'a Scene,
    colors: &'a [Color],
) -> impl ExactSizeIterator<Item = (&'a Point, &'a Color)> {
    assert_eq!(scene.points.len(), colors.len(), "a color per point");
    scene.points.iter().zip(colors)
}
