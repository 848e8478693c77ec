//! What is exported: one sub-map as plain numbers, free of the types of the program.

use std::collections::BTreeMap;

use features::Rig;
use geometry::{Distortion, Pinhole, SE3, Vec2, Vec3};
use map::{Keyframe, KeyframeId, Map, MapPoint, PointId};

use crate::error::ExportError;

/// Keyframes, cameras and points of one sub-map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// The cameras, each used by a view.
    pub cameras: Vec<Camera>,
    /// The keyframes in order of their ids.
    pub views: Vec<View>,
    /// The points that two views or more see, in order of their ids.
    pub points: Vec<Point>,
    /// Points left out since a single view sees them.
    pub n_single: usize,
    /// Observations left out since the point lies behind the camera.
    pub n_behind: usize,
    /// Sub-maps of the map, this one included.
    pub n_submaps: usize,
}

/// A pinhole camera without distortion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Focal lengths and principal point, pixels; (0, 0) is the center of the upper left pixel.
    pub pinhole: Pinhole,
    /// Image width, pixels.
    pub width: usize,
    /// Image height, pixels.
    pub height: usize,
    /// What the lens does to the images as they were recorded; the features are free of it.
    pub distortion: Distortion,
}

/// A keyframe.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Its id in the map.
    pub keyframe: u32,
    /// Number of its frame in the sequence.
    pub frame: u32,
    /// Seconds.
    pub timestamp_s: f64,
    /// Name of its image's file.
    pub name: String,
    /// Index of its camera.
    pub camera: usize,
    /// Pose of the left camera, meters.
    pub cam_from_world: SE3,
    /// Its features, undistorted pixels.
    pub pixels: Vec<Vec2>,
    /// Index of the point that each feature shows.
    pub points: Vec<Option<usize>>,
}

/// A point.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Its id in the map.
    pub id: u32,
    /// Position in the world, meters.
    pub position: Vec3,
    /// The keyframe that was newest when it was made.
    pub created_by: u32,
    /// Its observations: index of the view and of the view's feature, in order of the views.
    pub track: Vec<(usize, usize)>,
    /// Mean distance between its observations and its projections, pixels.
    pub error_px: f64,
}

impl Scene {
    /// The sub-map of a map that is the `submap`-th by its number of keyframes, the largest first, ties by id.
    ///
    /// # Errors
    /// [`ExportError::NoSuchSubmap`].
    pub fn of(map: &Map, submap: usize) -> Result<Self, ExportError> {
        let submaps = submaps(map);
        let n_submaps = submaps.len();
        let Some(members) = submaps.get(submap) else {
            return Err(ExportError::NoSuchSubmap { wanted: submap, n_submaps });
        };
        let mut scene = Self { n_submaps, ..Self::default() };
        for (keyframe, name) in members.iter().zip(image_names(members)) {
            let camera = scene.camera_of(&keyframe.frame.rig);
            scene.views.push(view(keyframe, camera, name));
        }
        let view_of: BTreeMap<KeyframeId, usize> = members.iter().map(|k| k.id).zip(0..).collect();
        for point in map.points() {
            scene.add_point(point, &view_of);
        }
        Ok(scene)
    }

    /// Where the `view`-th view should see a position of the world, pixels; `None` behind the camera.
    pub fn project(&self, view: usize, position: &Vec3) -> Option<Vec2> {
        let view = &self.views[view];
        let point_cam = view.cam_from_world * position;
        (point_cam.z > 0.0).then(|| self.cameras[view.camera].pinhole.project(&point_cam))
    }

    fn camera_of(&mut self, rig: &Rig) -> usize {
        let camera = Camera {
            pinhole: rig.stereo.camera,
            width: rig.width,
            height: rig.height,
            distortion: rig.distortion,
        };
        self.cameras.iter().position(|known| *known == camera).unwrap_or_else(|| {
            self.cameras.push(camera);
            self.cameras.len() - 1
        })
    }

    fn add_point(&mut self, point: &MapPoint, view_of: &BTreeMap<KeyframeId, usize>) {
        let seen = point.observations().iter();
        let observed: Vec<(usize, usize)> =
            seen.filter_map(|o| Some((*view_of.get(&o.keyframe)?, o.feature as usize))).collect();
        if observed.is_empty() {
            return;
        }
        let distance = |&(view, feature): &(usize, usize)| {
            Some((self.project(view, &point.position)? - self.views[view].pixels[feature]).norm())
        };
        let (track, distances): (Vec<_>, Vec<f64>) =
            observed.iter().filter_map(|o| Some((*o, distance(o)?))).unzip();
        self.n_behind += observed.len() - track.len();
        if track.len() < 2 {
            self.n_single += 1;
            return;
        }
        for &(view, feature) in &track {
            self.views[view].points[feature] = Some(self.points.len());
        }
        let PointId(id) = point.id;
        let error_px = distances.iter().sum::<f64>() / distances.len() as f64;
        let (position, created_by) = (point.position, point.created_by.0);
        self.points.push(Point { id, position, created_by, track, error_px });
    }
}

/// The keyframes of each sub-map, the largest first, ties by the id of the root.
fn submaps(map: &Map) -> Vec<Vec<&Keyframe>> {
    let mut by_root: BTreeMap<KeyframeId, Vec<&Keyframe>> = BTreeMap::new();
    for keyframe in map.keyframes() {
        if let Some(root) = map.submap_of(keyframe.id) {
            by_root.entry(root).or_default().push(keyframe);
        }
    }
    let mut submaps: Vec<_> = by_root.into_values().collect();
    submaps.sort_by_key(|members| std::cmp::Reverse(members.len()));
    submaps
}

fn view(keyframe: &Keyframe, camera: usize, name: String) -> View {
    let frame = &keyframe.frame;
    View {
        keyframe: keyframe.id.0,
        frame: frame.index,
        timestamp_s: frame.timestamp_s,
        name,
        camera,
        cam_from_world: keyframe.cam_from_world,
        pixels: (0..frame.len()).map(|i| frame.pixel(i)).collect(),
        points: vec![None; frame.len()],
    }
}

/// How images are called: by the number of the frame, and by keyframe where several sequences gave frames of one number.
fn image_names(members: &[&Keyframe]) -> Vec<String> {
    let mut frames: Vec<u32> = members.iter().map(|k| k.frame.index).collect();
    frames.sort_unstable();
    let by_keyframe = frames.windows(2).any(|pair| pair[0] == pair[1]);
    let name = |keyframe: &&Keyframe| match by_keyframe {
        true => format!("keyframe_{:06}.png", keyframe.id.0),
        false => format!("{:06}.png", keyframe.frame.index),
    };
    members.iter().map(name).collect()
}
