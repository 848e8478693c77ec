//! From the configuration and the dataset to what a run needs.

use std::path::Path;
use std::sync::Arc;

use features::{DepthConfig, Rig};
use geometry::{GrayImage, Sensor, StereoRig};
use io::{FrameSource, ImageSize, Sequence};
use runtime::Setup;
use slam::{CameraParams, Params};

use crate::{Config, Error};

/// Size of a sequence's images, after rectification where there is one, compared with what the configuration says. The size
/// that the dataset's own calibration gives is taken when at least one image has it.
///
/// # Errors
/// No image has a readable header, or its size is not the configured or calibrated one.
pub(crate) fn image_size(sequence: &Sequence, config: &Config) -> Result<ImageSize, Error> {
    let (position, size) = match calibrated(sequence)? {
        Some(found) => found,
        None => sequence.image_size().map_err(Error::NoImage)?,
    };
    check_size(size, &sequence.frames[position].left, config)?;
    Ok(size)
}

/// Compares the size of the images, one of which is `name`, with what the configuration says.
///
/// # Errors
/// Both sizes.
pub(crate) fn check_size(size: ImageSize, name: &Path, config: &Config) -> Result<(), Error> {
    if let (Some(width), Some(height)) = (config.camera.width, config.camera.height) {
        let because = "camera.width and camera.height of the configuration";
        io::check_size(name, size, ImageSize { width, height }, because)?;
    }
    Ok(())
}

/// The image size of the dataset's calibration with the position of the first frame that has it; `None` where the dataset
/// gives no size.
fn calibrated(sequence: &Sequence) -> Result<Option<(usize, ImageSize)>, Error> {
    let Some(raw) = &sequence.raw_calibration else { return Ok(None) };
    let Some(expected) = raw.cameras.first().map(|camera| camera.size) else { return Ok(None) };
    let has_it = |frame: &FrameSource| frame.image_size().is_ok_and(|size| size == expected);
    if let Some(position) = sequence.frames.iter().position(has_it) {
        return Ok(Some((position, expected)));
    }
    let (position, size) = sequence.image_size().map_err(Error::NoImage)?;
    let because = format!("resolution in {}", raw.source);
    io::check_size(&sequence.frames[position].left, size, expected, &because)?;
    Ok(Some((position, size)))
}

/// The camera in force for raw images of `size` of `dataset`, which are reduced by `input.scale`.
///
/// # Errors
/// A missing camera.
pub(crate) fn rig(config: &Config, sensor: Sensor, size: ImageSize, dataset: &Path) -> Result<Rig, Error> {
    let camera = config.camera_in_force(dataset, sensor)?;
    let reduced = size.scaled(config.input.scale);
    let stereo = StereoRig { camera: camera.rig.camera.resized(size.factors_to(reduced)), ..camera.rig };
    Ok(Rig { stereo, distortion: camera.distortion, width: reduced.width, height: reduced.height })
}

/// The setup of a run with this camera.
pub(crate) fn from_config(config: &Config, sensor: Sensor, rig: Rig) -> Setup {
    let close_depth_m = config.stereo.close_depth_baselines * rig.stereo.baseline_m;
    let params = Params {
        tracking: config.tracking.clone(),
        mapping: config.mapping.clone(),
        loops: config.loops.clone(),
        weights: config.weights,
        seed: config.seed,
        ..Params::of(CameraParams::new(sensor, close_depth_m, config.camera.fps))
    };
    Setup {
        extractor: config.features.with_sensor(sensor),
        stereo: config.stereo.clone(),
        depth: DepthConfig { units_per_meter: config.camera.depth_units_per_metre, ..DepthConfig::default() },
        lags: config.runtime,
        ..Setup::new(sensor, Arc::new(rig), params)
    }
}

/// The mask of the configuration, compared with the size of the raw images.
///
/// # Errors
/// A file that is not an image, or has another size.
pub(crate) fn wanted_mask(config: &Config, size: ImageSize) -> Result<Option<GrayImage>, Error> {
    let Some(path) = &config.input.mask else { return Ok(None) };
    let place = || format!("input.mask ({})", config.provenance("input.mask"));
    let mask = io::load_gray(path).map_err(|problem| Error::Mask { place: place(), problem })?;
    let found = mask.size();
    if found != size {
        return Err(Error::MaskSize { place: place(), path: path.clone(), found, expected: size });
    }
    Ok(Some(mask))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: ImageSize = ImageSize { width: 640, height: 480 };

    fn setup(extra: &[&str], sensor: Sensor) -> Setup {
        let camera =
            ["camera.fx=500", "camera.fy=500", "camera.cx=320", "camera.cy=240", "camera.baseline_m=0.5"];
        let overrides: Vec<String> = camera.iter().chain(extra).map(|s| (*s).to_owned()).collect();
        let config = Config::load(None, &overrides).unwrap();
        let rig = rig(&config, sensor, SIZE, Path::new("x")).unwrap();
        from_config(&config, sensor, rig)
    }

    #[test]
    fn overrides_reach_the_setup() {
        let extra = [
            "features.keep=777",
            "tracking.min_inliers=31",
            "mapping.neighbours=12",
            "seed=9",
            "camera.fps=25",
        ];
        let setup = setup(&extra, Sensor::Stereo);
        assert_eq!(setup.extractor.keep, 777);
        assert_eq!(setup.slam.tracking.min_inliers, 31);
        assert_eq!(setup.slam.camera.max_keyframe_gap, 25);
        assert_eq!(setup.slam.mapping.neighbours, Some(12));
        assert_eq!(setup.slam.seed, 9);
        assert_eq!(setup.slam.camera.close_depth_m, 20.0, "40 baselines");
    }

    #[test]
    fn a_single_camera_keeps_features_of_its_own_number() {
        let kept = |extra: &[&str], sensor| setup(extra, sensor).extractor.keep;
        let both = ["features.keep=500", "features.keep_mono=1500"];
        assert_eq!([Sensor::Mono, Sensor::Stereo].map(|sensor| kept(&both, sensor)), [1500, 500]);
        assert_eq!(kept(&both[..1], Sensor::Mono), 500, "absent: as many as of the others");
    }

    #[test]
    fn without_a_camera_there_is_no_run() {
        let none = Config::load(None, &[]).unwrap();
        let error = rig(&none, Sensor::Rgbd, SIZE, Path::new("desk")).unwrap_err().to_string();
        assert!(error.starts_with("desk: the dataset has no calibration file"), "{error}");
    }
}
