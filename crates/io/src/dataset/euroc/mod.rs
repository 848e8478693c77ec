//! EuRoC (ASL) folders: `mav0/cam0` and `mav0/cam1` with `data.csv`, `data/` and `sensor.yaml`; `state_groundtruth_estimate0`.

mod calibration;
mod images;

use std::path::{Path, PathBuf};

use super::given::Given;
use super::layout::SequenceKind;
use super::{
    DatasetError, FrameSource, OpenOptions, Sensor, Sequence, Times, choose_sensor, folder_name, monocular,
    truth,
};
use crate::trajectory::TrajectoryFormat;
use images::{Image, ImageList};

/// The folder with the cameras' folders: `dir/mav0` or `dir` itself; `None` when this is not a EuRoC sequence.
pub(super) fn find_root(dir: &Path) -> Option<PathBuf> {
    let has_camera = |root: &PathBuf| {
        let camera = root.join("cam0");
        camera.join("data.csv").is_file() || camera.join("data").is_dir()
    };
    [dir.join("mav0"), dir.to_path_buf()].into_iter().find(has_camera)
}

/// Opens the EuRoC sequence `dir` whose cameras are in `root`.
pub(super) fn open(
    dir: &Path,
    root: &Path,
    options: &OpenOptions,
    given: &Given,
) -> Result<Sequence, DatasetError> {
    let mut warnings = Vec::new();
    let right = root.join("cam1");
    let no_right = (!right.is_dir()).then(|| format!("found no folder {}", right.display()));
    let no_depth = Some("EuRoC folders contain no depth images".to_owned());
    let sensor = choose_sensor(dir, options.sensor, no_right, no_depth)?;
    warnings.extend(monocular(&right, options.sensor, sensor, "no such folder"));
    let left = ImageList::read(&root.join("cam0"), &mut warnings)?;
    let of_images = left.images.iter().find_map(|image| crate::images::image_size(&image.path).ok());
    let (sensor, cameras) =
        calibration::read(dir, root, (options.sensor, sensor), given, of_images, &mut warnings)?;
    let frames: Vec<FrameSource> = match sensor {
        Sensor::Stereo => {
            let right = ImageList::read(&right, &mut warnings)?;
            let pairs = images::pair(&left, &right, &mut warnings)?;
            right.warn_of_missing(&mut warnings)?;
            pairs.iter().enumerate().map(|(i, (left, right))| frame(i, left, Some(right))).collect()
        }
        _ => left.images.iter().enumerate().map(|(i, left)| frame(i, left, None)).collect(),
    };
    left.warn_of_missing(&mut warnings)?;
    let usual = [root.join("state_groundtruth_estimate0/data.csv"), root.join("mocap0/data.csv")];
    let ground_truth = truth::read(options, &usual, TrajectoryFormat::Euroc, &frames, &mut warnings)?;
    Ok(Sequence {
        frames,
        ground_truth,
        times: if left.is_of_names { Times::Names } else { Times::Given },
        warnings,
        ..Sequence::new(sequence_name(dir), SequenceKind::Euroc, sensor).seen_by(cameras)
    })
}

fn frame(index: usize, left: &Image, right: Option<&Image>) -> FrameSource {
    FrameSource {
        right: right.map(|image| image.path.clone()),
        ..FrameSource::of(index, left.nanoseconds, left.path.clone())
    }
}

/// The name of the folder around `mav0`.
fn sequence_name(dir: &Path) -> String {
    let name = folder_name(dir);
    let parent = dir.canonicalize().ok().and_then(|path| path.parent().map(folder_name));
    parent.filter(|_| name == "mav0").unwrap_or(name)
}
