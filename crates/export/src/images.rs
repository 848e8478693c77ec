//! The images of the keyframes: found in the sequence, redrawn where the lens or the rig asks for it, and the colors of the points in
//! them.

use std::path::{Path, PathBuf};

use draw::Color;
use features::{RemapTable, remap};
use geometry::{CameraModel, GrayImage, SO3, Vec2};
use io::{FrameSource, ImageError, ImageSize, RectifiedView, Rgb, Sequence, load_rgb, save_png_rgb};
use rayon::prelude::*;

use crate::error::ExportError;
use crate::scene::{Camera, Scene, View};

/// Largest difference between the times of a keyframe and of its frame, seconds: rounding of times since 1970.
const SAME_TIME_S: f64 = 1e-6;

/// The images of a scene's views.
#[derive(Clone, Debug)]
pub struct SceneImages {
    files: Vec<PathBuf>,
    /// For each camera of the scene how images become its; `None`: they are.
    tables: Vec<Option<RemapTable>>,
}

impl SceneImages {
    /// Finds the left image of every view in the sequence (in the folder `dir`) that the map was made from.
    ///
    /// # Errors
    /// [`ExportError::ForeignKeyframe`] for a keyframe of another sequence.
    pub fn find(scene: &Scene, sequence: &Sequence, dir: &Path) -> Result<Self, ExportError> {
        let file = |view: &View| {
            let &View { keyframe, frame, timestamp_s, .. } = view;
            let foreign =
                || ExportError::ForeignKeyframe { sequence: dir.to_path_buf(), keyframe, frame, timestamp_s };
            find_frame(sequence, view).map(|frame| frame.left.clone()).ok_or_else(foreign)
        };
        let files = scene.views.iter().map(file).collect::<Result<_, _>>()?;
        let tables = scene.cameras.iter().map(|camera| table(camera, sequence)).collect();
        Ok(Self { files, tables })
    }

    /// Whether the images are redrawn, so that they are free of distortion and rectified.
    pub fn are_redrawn(&self) -> bool {
        self.tables.iter().any(Option::is_some)
    }

    /// Writes the images into a folder that exists, under the names of the views, and returns the color of each point of the scene:
    /// the mean over its observations. Images that need no change and are PNG are copied byte by byte.
    ///
    /// # Errors
    /// The first image, in order of the views, that cannot be read, has another size than the camera, or cannot be written.
    pub fn write(&self, scene: &Scene, folder: &Path) -> Result<Vec<Color>, ExportError> {
        self.colors(scene, |view, file, image| {
            let target = folder.join(&scene.views[view].name);
            let is_png = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
            if self.tables[scene.views[view].camera].is_none() && is_png {
                let bytes = std::fs::read(file).map_err(|error| ImageError::Unreadable {
                    path: file.to_path_buf(),
                    reason: error.to_string(),
                })?;
                return Ok(io::write_atomic(&target, &bytes)?);
            }
            Ok(save(&target, image)?)
        })
    }

    /// The color of each point of the scene; nothing is written.
    ///
    /// # Errors
    /// The first image, in order of the views, that cannot be read or has another size than the camera.
    pub fn point_colors(&self, scene: &Scene) -> Result<Vec<Color>, ExportError> {
        self.colors(scene, |_, _, _| Ok(()))
    }

    fn colors(
        &self,
        scene: &Scene,
        visit: impl Fn(usize, &Path, &Rgb) -> Result<(), ExportError> + Sync,
    ) -> Result<Vec<Color>, ExportError> {
        let of_view = |(view, file): (usize, &PathBuf)| {
            let image = self.load(file, scene, view)?;
            visit(view, file, &image)?;
            let View { pixels, points, .. } = &scene.views[view];
            let seen = points.iter().zip(pixels).filter_map(|(point, pixel)| Some(((*point)?, pixel)));
            Ok(seen.map(|(point, pixel)| (point, sample(&image, pixel))).collect())
        };
        let seen: Vec<Result<Vec<(usize, Color)>, ExportError>> =
            self.files.par_iter().enumerate().map(of_view).collect();
        let mut sums = vec![[0_u32; 4]; scene.points.len()];
        for of_view in seen {
            for (point, color) in of_view? {
                let [r, g, b] = color.map(u32::from);
                for (sum, value) in sums[point].iter_mut().zip([r, g, b, 1]) {
                    *sum += value;
                }
            }
        }
        let mean = |[r, g, b, n]: [u32; 4]| [r, g, b].map(|sum| ((sum + n / 2) / n.max(1)) as u8);
        Ok(sums.into_iter().map(mean).collect())
    }

    fn load(&self, file: &Path, scene: &Scene, view: usize) -> Result<Rgb, ExportError> {
        let image = load_rgb(file)?;
        let index = scene.views[view].camera;
        let (camera, table) = (&scene.cameras[index], &self.tables[index]);
        let (width, height) = table.as_ref().map_or((camera.width, camera.height), RemapTable::source_size);
        io::check_size(file, image.size(), ImageSize { width, height }, "as the map's camera")?;
        Ok(match table {
            Some(table) => redrawn(&image, table),
            None => image,
        })
    }
}

/// The frame of a keyframe, by time.
fn find_frame<'a>(sequence: &'a Sequence, view: &View) -> Option<&'a FrameSource> {
    let after = sequence.frames.partition_point(|frame| frame.timestamp_s() < view.timestamp_s - SAME_TIME_S);
    sequence.frames.get(after).filter(|frame| (frame.timestamp_s() - view.timestamp_s).abs() <= SAME_TIME_S)
}

/// The table from images of the sequence to those of a camera; `None` where they are the same.
fn table(camera: &Camera, sequence: &Sequence) -> Option<RemapTable> {
    let target = (camera.width, camera.height);
    if let Some(RectifiedView { model, rectified_from_cam, size }) = sequence.rectification.first() {
        let source = (size.width, size.height);
        return Some(RemapTable::rectifying(model, rectified_from_cam, &camera.pinhole, source, target));
    }
    if camera.distortion.is_zero() {
        return None;
    }
    let model = CameraModel::Pinhole { camera: camera.pinhole, distortion: camera.distortion };
    Some(RemapTable::rectifying(&model, &SO3::identity(), &camera.pinhole, target, target))
}

/// Each channel through the table; the table has the size of the image.
fn redrawn(image: &Rgb, table: &RemapTable) -> Rgb {
    let (width, height) = table.target_size();
    let channels: [Option<GrayImage>; 3] = std::array::from_fn(|channel| {
        let data = image.data.iter().map(|pixel| pixel[channel]).collect();
        remap(&GrayImage { width: image.width, height: image.height, data }, table)
    });
    let value = |channel: usize, i: usize| channels[channel].as_ref().map_or(0, |image| image.data[i]);
    let data = (0..width * height).map(|i| std::array::from_fn(|channel| value(channel, i))).collect();
    Rgb { width, height, data }
}

/// Gray images stay gray, which is a third of the size.
fn save(path: &Path, image: &Rgb) -> Result<(), io::FileError> {
    if image.data.iter().all(|[r, g, b]| r == g && g == b) {
        let data = image.data.iter().map(|pixel| pixel[0]).collect();
        io::save_png_gray(path, &GrayImage { width: image.width, height: image.height, data })
    } else {
        save_png_rgb(path, image)
    }
}

/// The color of the nearest pixel; that at the edge for a place outside.
fn sample(image: &Rgb, pixel: &Vec2) -> Color {
    let place = |value: f64, n: usize| (value.round().max(0.0) as usize).min(n.saturating_sub(1));
    image.at(place(pixel.x, image.width), place(pixel.y, image.height))
}
