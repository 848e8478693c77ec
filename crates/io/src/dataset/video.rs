//! Videos and cameras as datasets: what is used of their frames. The frames themselves come from a stream.

use std::path::Path;

use super::camera_file::read_calibration;
use super::cameras::Cameras;
use super::image_folder::{Pictures, choose};
use super::layout::SequenceKind;
use super::{DatasetError, OpenOptions, Packing, Sensor, Sequence, folder_name};
use crate::images::{ImageError, ImageSize, half_size};

/// What is known of a video or a camera before its first frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Video {
    /// Cameras and sensor; its list of frames is empty.
    pub sequence: Sequence,
    /// What a frame holds.
    pub packing: Packing,
    /// Size of the image of one camera.
    pub size: ImageSize,
}

/// The cameras of a calibration file as a sequence without frames, with the size of their raw images; `sensor`: `None` for stereo
/// where the file has two cameras, else mono.
///
/// # Errors
/// [`DatasetError`] for a broken calibration file, and for stereo with one camera.
pub fn open_cameras(file: &Path, sensor: Option<Sensor>) -> Result<(Sequence, ImageSize), DatasetError> {
    let calibration = read_calibration(file)?;
    let usual = if calibration.has_pair() { Sensor::Stereo } else { Sensor::Mono };
    let sensor = sensor.unwrap_or(usual);
    if sensor == Sensor::Stereo && !calibration.has_pair() {
        return Err(DatasetError::unavailable(file, sensor, "the calibration file has one camera"));
    }
    // Without a size in the file there is none at all: its cameras say so.
    let size =
        calibration.raw(Sensor::Mono, None)?.first().map_or(ImageSize { width: 0, height: 0 }, |c| c.size);
    let cameras = calibration.cameras(sensor, None)?;
    let sequence = sequence(file, sensor, cameras, calibration.frame_rate_hz);
    Ok((sequence, size))
}

/// A sequence without frames that is called as the file.
fn sequence(path: &Path, sensor: Sensor, cameras: Cameras, frame_rate_hz: Option<f64>) -> Sequence {
    let name = path.file_stem().map_or_else(|| folder_name(path), |stem| stem.to_string_lossy().into_owned());
    Sequence { frame_rate_hz, ..Sequence::new(name, SequenceKind::Video, sensor).seen_by(cameras) }
}

/// A video whose frames have this size, with the calibration file of `options`.
///
/// # Errors
/// [`DatasetError`] for a broken calibration file, one that does not fit the frames, or a sensor that the video does not have.
pub fn open_video(path: &Path, frame: ImageSize, options: &OpenOptions) -> Result<Video, DatasetError> {
    let mut warnings = Vec::new();
    let file = options.calibration.as_deref().map(read_calibration).transpose()?;
    if file.is_none() {
        warnings.push(format!(
            "{}: no calibration file (--calib), so the configuration must give the camera",
            path.display()
        ));
    }
    let pictures = Pictures { place: path, size: Some(frame), in_two_folders: false, has_depth: false };
    let (sensor, packing) = choose(&pictures, file.as_ref(), options.sensor, &mut warnings)?;
    let size = match packing {
        Packing::Whole => frame,
        Packing::LeftHalf | Packing::BothHalves => half_size(path, frame)?,
    };
    let expected = file.as_ref().and_then(|file| Some((file.size()?, file.source())));
    if let Some((expected, source)) = expected.filter(|(expected, _)| *expected != size) {
        let because = match sensor {
            Sensor::Stereo => format!("left and right side by side, each {expected} as in {source}"),
            _ => format!("resolution in {source}"),
        };
        let width = if sensor == Sensor::Stereo { 2 * expected.width } else { expected.width };
        let expected = ImageSize { width, ..expected };
        return Err(
            ImageError::WrongSize { path: path.to_path_buf(), found: frame, expected, because }.into()
        );
    }
    let cameras = file.as_ref().map_or(Ok(Cameras::default()), |file| file.cameras(sensor, Some(size)))?;
    let frame_rate_hz = file.as_ref().and_then(|file| file.frame_rate_hz);
    let sequence = Sequence { warnings, ..sequence(path, sensor, cameras, frame_rate_hz) };
    Ok(Video { sequence, packing, size })
}
