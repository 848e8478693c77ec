//! From the images of a dataset to those that features are taken from, on the thread that decodes: reduced, then rectified through
//! tables that are made once before the run.

use std::path::Path;

use features::{ExtractorConfig, FeatureMask, RemapTable, remap};
use geometry::{DepthImage, GrayImage};
use io::{ImageError, ImageSize, LoadedFrame, RectifiedView, Sequence, Variant, reduce_depth, reduce_gray};

use crate::record::Unusable;

/// What is done to the images of a sequence.
#[derive(Clone, Debug, Default)]
pub struct Preparation {
    /// Size that the raw images must have, with where it was read; `None`: any.
    expected: Option<(ImageSize, String)>,
    /// Factor by which they are reduced; `None`: not at all.
    scale: Option<f64>,
    /// Left, right; empty: images are used as they are.
    tables: Vec<RemapTable>,
    /// What is changed at last.
    variant: Variant,
}

impl Preparation {
    /// The preparation of a sequence's images, which are reduced by `scale` (at most 1) before they are rectified.
    pub fn new(sequence: &Sequence, scale: f64) -> Self {
        let scale = Some(scale).filter(|&scale| scale < 1.0);
        let (Some(calibration), Some(first)) = (&sequence.calibration, sequence.rectification.first()) else {
            return Self { scale, ..Self::default() };
        };
        let reduced = |size: ImageSize| scale.map_or(size, |scale| size.scaled(scale));
        let target = reduced(first.size);
        let camera = calibration.rig.camera.resized(first.size.factors_to(target));
        let table = |view: &RectifiedView| {
            let size = reduced(view.size);
            let model = view.model.resized(view.size.factors_to(size));
            let (from, to) = ((size.width, size.height), (target.width, target.height));
            RemapTable::rectifying(&model, &view.rectified_from_cam, &camera, from, to)
        };
        let tables = sequence.rectification.iter().map(table).collect();
        let expected = Some((first.size, calibration.source.clone()));
        Self { expected, scale, tables, variant: Variant::default() }
    }

    /// The same, followed by what this variant does to images.
    pub fn varied(self, variant: Variant) -> Self {
        Self { variant, ..self }
    }

    /// Whether left and right are exchanged.
    pub fn is_mirrored(&self) -> bool {
        self.variant.mirrored
    }

    /// Where features may be taken: not in the border that rectification cannot fill, and not where `wanted`, an image of the size of
    /// the left raw one, is 0.
    pub fn mask(&self, config: &ExtractorConfig, wanted: Option<&GrayImage>) -> Option<FeatureMask> {
        // Mirrored, the last camera is the left one.
        let camera = if self.is_mirrored() { self.tables.len().saturating_sub(1) } else { 0 };
        let turned = |mask: GrayImage| if self.is_mirrored() { mask.mirrored() } else { mask };
        let filled = self.tables.get(camera).map(|table| turned(table.mask(0)));
        let wanted = wanted.and_then(|mask| {
            let binary =
                GrayImage::from_fn(mask.width, mask.height, |x, y| if mask.at(x, y) == 0 { 0 } else { 255 });
            let prepared = turned(self.prepared(binary, camera).ok()?);
            let clear = |x: usize, y: usize| if prepared.at(x, y) < 128 { 0 } else { 255 };
            Some(GrayImage::from_fn(prepared.width, prepared.height, clear))
        });
        FeatureMask::new(config, filled.as_ref(), wanted.as_ref())
    }

    /// The frame with prepared images, left and right at the same time; `name` is what its left image is called.
    ///
    /// # Errors
    /// Found and expected size of an image that does not have the size of its camera.
    pub fn apply(&self, frame: LoadedFrame, name: &Path) -> Result<LoadedFrame, Unusable> {
        if let Some((expected, source)) = self.expected.as_ref().filter(|(size, _)| *size != frame.size()) {
            let (path, found) = (name.to_path_buf(), frame.size());
            let because = format!("resolution in {source}");
            return Err(ImageError::WrongSize { path, found, expected: *expected, because }.into());
        }
        let LoadedFrame { left, right, depth } = frame;
        let (left, right) =
            rayon::join(|| self.prepared(left, 0), || right.map(|right| self.prepared(right, 1)).transpose());
        let depth = depth.map(|depth| self.reduced_depth(depth));
        Ok(self.variant.apply(LoadedFrame { left: left?, right: right?, depth }, name))
    }

    /// The image of one camera, reduced and rectified.
    fn prepared(&self, image: GrayImage, camera: usize) -> Result<GrayImage, Unusable> {
        let image = match self.scale {
            None => image,
            Some(scale) => reduce_gray(&image, image.size().scaled(scale)),
        };
        if self.tables.is_empty() {
            return Ok(image);
        }
        let name = if camera == 0 { "left" } else { "right" };
        let table = self.tables.get(camera).ok_or(Unusable::Unrectified(name))?;
        remap(&image, table).ok_or_else(|| {
            let (width, height) = table.source_size();
            Unusable::Size { image: name, found: image.size(), expected: ImageSize { width, height } }
        })
    }

    fn reduced_depth(&self, depth: DepthImage) -> DepthImage {
        match self.scale {
            None => depth,
            Some(scale) => reduce_depth(&depth, depth.size().scaled(scale)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{CameraModel, Distortion, Pinhole, SO3, StereoRig, Vec3};
    use std::path::PathBuf;

    use io::{Calibration, FrameSource, Sensor, SequenceKind};

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
            frames: vec![files()],
            calibration: Some(Calibration { rig, distortion: Distortion::default(), source }),
            rectification: vec![view(0.0), view(turn)],
            ..Sequence::new("two", SequenceKind::Euroc, Sensor::Stereo)
        }
    }

    /// The left camera is turned too.
    fn sequence_with_left(turn: f64) -> Sequence {
        let mut sequence = sequence(turn);
        sequence.rectification[0] = sequence.rectification[1].clone();
        sequence
    }

    fn name() -> PathBuf {
        "a.png".into()
    }

    fn files() -> FrameSource {
        FrameSource {
            index: 0,
            timestamp_ns: 0,
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
        let preparation = Preparation::new(&sequence(std::f64::consts::PI), 1.0);
        let raw = noise(SIZE);
        let frame = LoadedFrame { left: raw.clone(), right: Some(raw.clone()), depth: None };
        let LoadedFrame { left, right, depth } = preparation.apply(frame, &name()).unwrap();
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
        let preparation = Preparation::new(&one, 1.0);
        let frame = |right: Option<GrayImage>| LoadedFrame { left: noise(SIZE), right, depth: None };
        assert!(preparation.apply(frame(None), &name()).unwrap().right.is_none());
        let error = preparation.apply(frame(Some(noise(SIZE))), &name()).unwrap_err();
        assert_eq!(error.to_string(), "found no rectification of the right image");
    }

    #[test]
    fn an_image_of_another_size_is_named_with_both_sizes() {
        let preparation = Preparation::new(&sequence(0.0), 1.0);
        let small = noise(ImageSize { width: 39, height: 30 });
        let frame = |left: &GrayImage, right: &GrayImage| LoadedFrame {
            left: left.clone(),
            right: Some(right.clone()),
            depth: None,
        };
        let error = preparation.apply(frame(&small, &small), &name()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "a.png: found 39x30 pixels, expected 40x30 (resolution in cam0/sensor.yaml)"
        );
        let error = preparation.apply(frame(&noise(SIZE), &small), &name()).unwrap_err();
        assert_eq!(error.to_string(), "the right image is 39 x 30 pixels, expected 40 x 30");
    }

    #[test]
    fn images_that_are_used_as_they_are_stay() {
        let mut plain = sequence(0.0);
        plain.rectification.clear();
        let preparation = Preparation::new(&plain, 1.0);
        let raw = noise(ImageSize { width: 7, height: 5 });
        let frame = LoadedFrame { left: raw.clone(), right: None, depth: None };
        assert_eq!(preparation.apply(frame, &name()).unwrap().left, raw);
        assert_eq!(preparation.mask(&ExtractorConfig::default(), None), None);
    }

    #[test]
    fn a_mirrored_pair_shows_the_right_camera_on_the_left_and_so_does_its_mask() {
        let preparation = Preparation::new(&sequence(std::f64::consts::PI), 1.0);
        let frame = || LoadedFrame { left: noise(SIZE), right: Some(noise(SIZE)), depth: None };
        let plain = preparation.apply(frame(), &name()).unwrap();
        let preparation = preparation.varied("mirrored".parse().unwrap());
        let mirrored = preparation.apply(frame(), &name()).unwrap();
        assert_eq!(mirrored.left, plain.right.unwrap().mirrored());
        assert_eq!(mirrored.right.unwrap(), plain.left.mirrored());
        // Only the left fifteen columns are wanted; the corner test keeps four away from the others.
        let left = GrayImage::from_fn(40, 30, |x, _| if x < 15 { 9 } else { 0 });
        let config = ExtractorConfig { levels: 1, ..ExtractorConfig::default() };
        let straight = Preparation::new(&sequence(0.0), 1.0).varied("mirrored".parse().unwrap());
        let mask = straight.mask(&config, Some(&left)).unwrap();
        let row = mask.bytes().next().unwrap()[15 * 40..16 * 40].to_vec();
        assert!((0..40).all(|x| (row[x] != 0) == (x >= 29)), "{row:?}");
    }

    #[test]
    fn reduced_images_are_rectified_as_large_ones_are() {
        let smooth = GrayImage::from_fn(40, 30, |x, y| (x * 3 + y * 4) as u8);
        let frame = || LoadedFrame { left: smooth.clone(), right: Some(smooth.clone()), depth: None };
        let [whole, half] = [1.0, 0.5].map(|scale| Preparation::new(&sequence(0.2), scale));
        let large = whole.apply(frame(), &name()).unwrap().right.unwrap();
        let small = half.apply(frame(), &name()).unwrap().right.unwrap();
        assert_eq!((small.width, small.height), (20, 15));
        let mut n_compared = 0;
        for (x, y) in [(9, 7), (6, 5), (12, 9), (10, 4), (8, 10)] {
            let four =
                [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| f64::from(large.at(2 * x + i, 2 * y + j)));
            assert!((f64::from(small.at(x, y)) - four.iter().sum::<f64>() / 4.0).abs() < 2.5, "{x} {y}");
            n_compared += 1;
        }
        assert_eq!(n_compared, 5);
    }

    #[test]
    fn the_mask_follows_the_image() {
        let config = ExtractorConfig { levels: 1, ..ExtractorConfig::default() };
        // The lower half is not wanted; the camera is turned by half.
        let lower = GrayImage::from_fn(40, 30, |_, y| if y < 15 { 9 } else { 0 });
        let turned = Preparation::new(&sequence_with_left(std::f64::consts::PI), 1.0);
        let mask = turned.mask(&config, Some(&lower)).unwrap();
        let rows: Vec<u8> = mask.bytes().next().unwrap().chunks(40).map(|row| row[20]).collect();
        assert!(rows[..18].iter().all(|&v| v == 0), "what was below is above: {rows:?}");
        assert_ne!(mask, Preparation::new(&sequence(0.0), 1.0).mask(&config, Some(&lower)).unwrap());
    }
}
