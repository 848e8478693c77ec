//! Raw cameras with lenses: pinhole pictures of the world, wide enough, redrawn through the lens model.

use crate::camera::{HEIGHT, View, WIDTH};
use crate::mesh::V3;
use geometry::{CameraModel, Distortion, GrayImage, KannalaBrandt, Pinhole, SE3, SO3, Vec2, Vec3};
use rayon::prelude::*;

/// Pixels of the pinhole picture per pixel of the raw image, at its center.
const OVERSAMPLING: f64 = 1.2;
/// Pixels around the part of the picture that is needed.
const MARGIN: f64 = 2.0;

/// Kind of lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lens {
    /// A pinhole with radial and tangential distortion, 79 degrees wide.
    Radtan,
    /// A fisheye (equidistant, Kannala-Brandt), 111 degrees wide.
    Fisheye,
}

/// A raw camera of the rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensCamera {
    /// Projection to raw pixels.
    pub model: CameraModel,
    /// Image width and height, pixels.
    pub size: (usize, usize),
    /// Pose of the camera in the frame of the drive's left camera ([`crate::World::world_from_cam`]), meters.
    pub rig_from_cam: SE3,
}

impl Lens {
    /// All kinds.
    pub const ALL: [Self; 2] = [Self::Radtan, Self::Fisheye];

    /// The left and the right camera, 0.54 m apart: turned against each other and against the rig by about a degree, the right one
    /// some millimeters higher and farther ahead, with slightly different lenses.
    pub fn cameras(self) -> [LensCamera; 2] {
        let degrees = |x: f64, y: f64, z: f64| SO3::exp(&Vec3::new(x, y, z).map(f64::to_radians));
        let places = [
            SE3::new(degrees(0.3, -0.5, 0.4), Vec3::zeros()),
            SE3::new(degrees(-0.4, 0.6, -0.7), Vec3::new(0.54, -0.004, 0.006)),
        ];
        let (size, models) = match self {
            Self::Radtan => ((752, 480), [0, 1].map(radtan)),
            Self::Fisheye => ((640, 480), [0, 1].map(fisheye)),
        };
        [0, 1].map(|i| LensCamera { model: models[i], size, rig_from_cam: places[i] })
    }
}

fn radtan(i: usize) -> CameraModel {
    let camera = [
        Pinhole { fx: 458.2, fy: 457.4, cx: 369.3, cy: 246.1 },
        Pinhole { fx: 456.9, fy: 456.3, cx: 378.7, cy: 237.2 },
    ][i];
    let distortion = [
        Distortion { k1: -0.283, k2: 0.074, p1: 2e-4, p2: -1e-4, k3: 0.0 },
        Distortion { k1: -0.279, k2: 0.071, p1: -1e-4, p2: 3e-4, k3: 0.0 },
    ][i];
    CameraModel::Pinhole { camera, distortion }
}

fn fisheye(i: usize) -> CameraModel {
    let camera = [
        Pinhole { fx: 330.4, fy: 330.1, cx: 318.6, cy: 241.3 },
        Pinhole { fx: 329.5, fy: 329.3, cx: 322.4, cy: 237.9 },
    ][i];
    let [k1, k2, k3, k4] = [[-0.012, 0.008, -0.004, 4e-4], [-0.010, 0.006, -0.003, 3e-4]][i];
    CameraModel::KannalaBrandt(KannalaBrandt { camera, k1, k2, k3, k4 })
}

/// How the image of a raw camera is made of a pinhole picture in tiles.
#[derive(Clone, Debug)]
pub(crate) struct Redrawing {
    /// Turn and center of the camera in the rig.
    rig_from_cam: SE3,
    /// The camera of the whole picture.
    picture: Pinhole,
    /// Columns and rows of tiles, each of the size of a rendered image.
    tiles: (usize, usize),
    width: usize,
    /// For each pixel of the raw image, row by row, the place in the picture.
    places: Vec<[f32; 2]>,
}

impl Redrawing {
    /// The picture that shows all that the camera sees.
    pub(crate) fn new(camera: &LensCamera) -> Self {
        let (width, height) = camera.size;
        let ideal = |i: usize| -> Vec2 {
            let ray = camera.model.unproject(&Vec2::new((i % width) as f64, (i / width) as f64));
            ray.xy() / ray.z
        };
        let rays: Vec<Vec2> = (0..width * height).into_par_iter().map(ideal).collect();
        let (low, high) = rays
            .iter()
            .fold((Vec2::repeat(f64::INFINITY), Vec2::repeat(f64::NEG_INFINITY)), |(low, high), ray| {
                (low.inf(ray), high.sup(ray))
            });
        let focal = OVERSAMPLING * camera.model.pinhole().fx;
        let picture =
            Pinhole { fx: focal, fy: focal, cx: MARGIN - low.x * focal, cy: MARGIN - low.y * focal };
        let extent = (high - low) * focal;
        let needed = |length: f64, tile: usize| ((length + 2.0 * MARGIN) / tile as f64).ceil() as usize;
        let place = |ray: &Vec2| [(ray.x * focal + picture.cx) as f32, (ray.y * focal + picture.cy) as f32];
        Self {
            rig_from_cam: camera.rig_from_cam,
            picture,
            tiles: (needed(extent.x, WIDTH), needed(extent.y, HEIGHT)),
            width,
            places: rays.iter().map(place).collect(),
        }
    }

    /// The raw image; `render` draws the view of one tile, whose number it is given.
    pub(crate) fn image(
        &self,
        world_from_rig: &SE3,
        render: impl Fn(&View, usize) -> GrayImage + Sync,
    ) -> GrayImage {
        let world_from_cam = *world_from_rig * self.rig_from_cam;
        let (columns, rows) = self.tiles;
        let tile = |i: usize| {
            // The tile at column x, row y of the picture is the image of a pinhole whose axis lies outside of it.
            let (x, y) = ((i % columns * WIDTH) as f64, (i / columns * HEIGHT) as f64);
            let view = View {
                rotation: world_from_cam.rotation.matrix().transpose(),
                center: world_from_cam * V3::zeros(),
                camera: Pinhole { cx: self.picture.cx - x, cy: self.picture.cy - y, ..self.picture },
            };
            render(&view, i)
        };
        let tiles: Vec<GrayImage> = (0..columns * rows).into_par_iter().map(tile).collect();
        let picture = GrayImage::from_fn(columns * WIDTH, rows * HEIGHT, |x, y| {
            tiles[y / HEIGHT * columns + x / WIDTH].at(x % WIDTH, y % HEIGHT)
        });
        let data = self.places.par_iter().map(|place| bilinear(&picture, *place)).collect();
        GrayImage { width: self.width, height: self.places.len() / self.width, data }
    }
}

/// The value between four pixels, all of which are inside.
fn bilinear(image: &GrayImage, [x, y]: [f32; 2]) -> u8 {
    let (left, top) = (x as usize, y as usize);
    let (right, lower) = (x - left as f32, y - top as f32);
    let at = |i: usize, j: usize| f32::from(image.at(left + i, top + j));
    let upper_value = at(0, 0) * (1.0 - right) + at(1, 0) * right;
    let lower_value = at(0, 1) * (1.0 - right) + at(1, 1) * right;
    (upper_value * (1.0 - lower) + lower_value * lower + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture whose gray value tells the direction of each pixel.
    fn direction_picture(view: &View) -> GrayImage {
        GrayImage::from_fn(WIDTH, HEIGHT, |x, y| {
            let ray = view.camera.unproject(&Vec2::new(x as f64, y as f64));
            (128.0 + 40.0 * ray.x + 17.0 * ray.y).clamp(0.0, 255.0) as u8
        })
    }

    #[test]
    fn every_pixel_shows_what_its_ray_meets() {
        for lens in Lens::ALL {
            let camera = lens.cameras()[1];
            let redrawing = Redrawing::new(&camera);
            let image = redrawing.image(&SE3::identity(), |view, _| direction_picture(view));
            assert_eq!((image.width, image.height), camera.size);
            for (x, y) in [(0, 0), (camera.size.0 - 1, 0), (320, 240), (17, 460), (600, 479)] {
                let ray = camera.model.unproject(&Vec2::new(x as f64, y as f64));
                let ray = ray.xy() / ray.z;
                let expected = (128.0 + 40.0 * ray.x + 17.0 * ray.y).clamp(0.0, 255.0);
                assert!((f64::from(image.at(x, y)) - expected).abs() < 1.6, "{lens:?} {x} {y}");
            }
        }
    }

    #[test]
    fn the_cameras_need_rectification() {
        for [left, right] in Lens::ALL.map(Lens::cameras) {
            let right_from_left = right.rig_from_cam.inverse() * left.rig_from_cam;
            assert!(right_from_left.rotation.angle().to_degrees() > 1.0);
            let rectified =
                geometry::rectify_stereo(&left.model, &right.model, left.size, &right_from_left).unwrap();
            assert!((rectified.rig.baseline_m - 0.54).abs() < 1e-3, "{rectified:?}");
        }
    }
}
