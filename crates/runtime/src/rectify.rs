//! Raw images become those of the rectified cameras, on the thread that decodes, through tables made once before the run.

use features::{RemapTable, remap};
use geometry::GrayImage;
use io::{FrameSource, ImageSize, LoadedFrame, Sequence};

/// The tables of a sequence's cameras.
#[derive(Clone, Debug)]
pub(crate) struct Rectification {
    /// Left, right.
    tables: Vec<RemapTable>,
    /// Size that the raw images of all cameras must have.
    size: ImageSize,
    /// Where the size was read.
    source: String,
}

impl Rectification {
    /// The tables of the sequence; `None` where its images are used as they are.
    pub(crate) fn of(sequence: &Sequence) -> Option<Self> {
        let calibration = sequence.calibration.as_ref()?;
        let size = sequence.rectification.first()?.size;
        let table = |view: &io::RectifiedView| {
            let (from, to) = ((view.size.width, view.size.height), (size.width, size.height));
            RemapTable::rectifying(&view.model, &view.rectified_from_cam, &calibration.rig.camera, from, to)
        };
        let tables = sequence.rectification.iter().map(table).collect();
        Some(Self { tables, size, source: calibration.source.clone() })
    }

    /// The frame with rectified images, left and right at the same time.
    ///
    /// # Errors
    /// Found and expected size of an image that does not have the size of its camera.
    pub(crate) fn apply(&self, frame: LoadedFrame, files: &FrameSource) -> Result<LoadedFrame, String> {
        frame
            .check_size(files, self.size, &format!("resolution in {}", self.source))
            .map_err(|error| error.to_string())?;
        let redrawn = |image: &GrayImage, camera: usize| {
            let missing = || format!("found no rectification of camera {camera}");
            let table = self.tables.get(camera).ok_or_else(missing)?;
            remap(image, table).ok_or_else(|| {
                let (found, expected) = ((image.width, image.height), table.source_size());
                format!("camera {camera}: found an image of {found:?} pixels, expected {expected:?}")
            })
        };
        let (left, right) = rayon::join(
            || redrawn(&frame.left, 0),
            || frame.right.as_ref().map(|right| redrawn(right, 1)).transpose(),
        );
        Ok(LoadedFrame { left: left?, right: right?, depth: frame.depth })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{CameraModel, Distortion, Pinhole, SE3, SO3, StereoRig, Vec3};
    use io::{Calibration, RectifiedView, Sensor, SequenceKind};

    const SIZE: ImageSize = ImageSize { width: 40, height: 30 };
    const CAMERA: Pinhole = Pinhole { fx: 30.0, fy: 30.0, cx: 20.0, cy: 15.0 };

    /// Two raw cameras; the right one is turned about its axis by `turn` radians.
    fn sequence(turn: f64) -> Sequence {
        let view = |angle: f64| RectifiedView {
            model: CameraModel::Pinhole { camera: CAMERA, distortion: Distortion::default() },
            rectified_from_cam: SO3::exp(&Vec3::new(0.0, 0.0, angle)),
            size: SIZE,
        };
        let rig = StereoRig { camera: CAMERA, baseline_m: 0.1 };
        let source = "cam0/sensor.yaml".to_owned();
        Sequence {
            name: "two".to_owned(),
            kind: SequenceKind::Euroc,
            sensor: Sensor::Stereo,
            frames: vec![files()],
            calibration: Some(Calibration { rig, distortion: Distortion::default(), source }),
            raw_calibration: None,
            rectification: vec![view(0.0), view(turn)],
            ground_truth: None,
            body_from_left: SE3::identity(),
            frame_rate_hz: None,
            warnings: Vec::new(),
        }
    }

    fn files() -> FrameSource {
        FrameSource {
            index: 0,
            timestamp_s: 0.0,
            left: "a.png".into(),
            right: Some("b.png".into()),
            depth: None,
            packing: io::Packing::Whole,
        }
    }

    fn noise(size: ImageSize) -> GrayImage {
        GrayImage::from_fn(size.width, size.height, |x, y| geometry::mix_seed(7, x as u64, y as u64) as u8)
    }

    #[test]
    fn each_image_goes_through_the_table_of_its_camera() {
        let rectification = Rectification::of(&sequence(std::f64::consts::PI)).unwrap();
        let raw = noise(SIZE);
        let frame = LoadedFrame { left: raw.clone(), right: Some(raw.clone()), depth: None };
        let LoadedFrame { left, right, depth } = rectification.apply(frame, &files()).unwrap();
        assert_eq!(left, raw, "the left camera is not turned");
        assert!(depth.is_none());
        let right = right.unwrap();
        for (x, y) in [(1, 1), (20, 15), (33, 8), (39, 29)] {
            assert_eq!(right.at(x, y), raw.at(40 - x, 30 - y), "turned by half about the principal point");
        }
    }

    #[test]
    fn one_camera_has_no_right_image() {
        let mut one = sequence(0.0);
        one.rectification.truncate(1);
        let rectification = Rectification::of(&one).unwrap();
        let frame = |right: Option<GrayImage>| LoadedFrame { left: noise(SIZE), right, depth: None };
        assert!(rectification.apply(frame(None), &files()).unwrap().right.is_none());
        let error = rectification.apply(frame(Some(noise(SIZE))), &files()).unwrap_err();
        assert_eq!(error, "found no rectification of camera 1");
    }

    #[test]
    fn an_image_of_another_size_is_named_with_both_sizes() {
        let rectification = Rectification::of(&sequence(0.0)).unwrap();
        let small = noise(ImageSize { width: 39, height: 30 });
        let frame = |left: &GrayImage, right: &GrayImage| LoadedFrame {
            left: left.clone(),
            right: Some(right.clone()),
            depth: None,
        };
        let error = rectification.apply(frame(&small, &small), &files()).unwrap_err();
        assert_eq!(error, "a.png: found 39x30 pixels, expected 40x30 (resolution in cam0/sensor.yaml)");
        let error = rectification.apply(frame(&noise(SIZE), &small), &files()).unwrap_err();
        assert_eq!(error, "camera 1: found an image of (39, 30) pixels, expected (40, 30)");
    }

    #[test]
    fn images_that_are_used_as_they_are_have_no_tables() {
        let mut plain = sequence(0.0);
        plain.rectification.clear();
        assert!(Rectification::of(&plain).is_none());
    }
}
