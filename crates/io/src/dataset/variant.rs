//! Variants of a sequence with the ground truth that belongs to them: the same frames backwards, mirrored, fewer, later, noisier.
//! What holds on one way through a street should hold on all.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use geometry::{DepthImage, GrayImage, Mat3, SE3, SO3, Vec3, mix_seed};

use super::Sequence;
use crate::images::LoadedFrame;
use crate::trajectory::{StampedPose, Trajectory};

/// A change of a sequence; the default changes nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variant {
    /// Frames in the opposite order, at times `t_last - t`.
    pub reversed: bool,
    /// Images flipped left-right; of a stereo pair the flipped right image becomes the left one.
    pub mirrored: bool,
    /// Only each n-th frame.
    pub every: usize,
    /// Frames left out at the start, in the order of the variant.
    pub start: usize,
    /// Factor on all gray values.
    pub gain: f64,
    /// Standard deviation of noise added to all gray values.
    pub noise: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Default for Variant {
    fn default() -> Self {
        Self { reversed: false, mirrored: false, every: 1, start: 0, gain: 1.0, noise: 0.0, seed: 0 }
    }
}

/// A word that names no variant.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "variant: found '{0}', expected words joined by '-': reversed, mirrored, every2, start10, gain1.2, noise5, seed1, or plain"
)]
pub struct VariantError(String);

impl FromStr for Variant {
    type Err = VariantError;

    fn from_str(text: &str) -> Result<Self, VariantError> {
        let mut variant = Variant::default();
        for word in text.split('-') {
            variant.add(word).ok_or_else(|| VariantError(word.to_owned()))?;
        }
        Ok(variant)
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plain = Variant::default();
        let words = [
            self.reversed.then(|| "reversed".to_owned()),
            self.mirrored.then(|| "mirrored".to_owned()),
            (self.every != plain.every).then(|| format!("every{}", self.every)),
            (self.start != plain.start).then(|| format!("start{}", self.start)),
            (self.gain != plain.gain).then(|| format!("gain{}", self.gain)),
            (self.noise != plain.noise).then(|| format!("noise{}", self.noise)),
            (self.seed != plain.seed).then(|| format!("seed{}", self.seed)),
        ];
        let words: Vec<String> = words.into_iter().flatten().collect();
        f.write_str(&if words.is_empty() { "plain".to_owned() } else { words.join("-") })
    }
}

impl Variant {
    /// Adds what a word says; `None` if it says nothing.
    fn add(&mut self, word: &str) -> Option<()> {
        let digits = word.find(|c: char| c.is_ascii_digit()).unwrap_or(word.len());
        let (name, number) = word.split_at(digits);
        let positive = |number: &str| number.parse().ok().filter(|v: &f64| v.is_finite() && *v > 0.0);
        match (name, number) {
            ("plain", "") => {}
            ("reversed", "") => self.reversed = true,
            ("mirrored", "") => self.mirrored = true,
            ("every", _) => self.every = number.parse().ok().filter(|&n| n > 0)?,
            ("start", _) => self.start = number.parse().ok()?,
            ("gain", _) => self.gain = positive(number)?,
            ("noise", _) => self.noise = positive(number)?,
            ("seed", _) => self.seed = number.parse().ok()?,
            _ => return None,
        }
        Some(())
    }

    /// The sequence with frames, times and ground truth of the variant; its calibration stays that of the files. A right camera is
    /// `baseline_m` beside the left one.
    pub fn of(&self, mut sequence: Sequence, baseline_m: f64) -> Sequence {
        let mut frames = sequence.frames;
        if self.reversed {
            let last = frames.last();
            let (last_s, last_ns) = last.map_or((0.0, 0), |last| (last.timestamp_s(), last.timestamp_ns));
            frames.reverse();
            frames.iter_mut().for_each(|frame| frame.timestamp_ns = last_ns - frame.timestamp_ns);
            for pose in sequence.ground_truth.iter_mut().flat_map(|truth| &mut truth.poses) {
                pose.timestamp_s = last_s - pose.timestamp_s;
            }
            sequence.ground_truth.iter_mut().for_each(|truth| truth.poses.reverse());
        }
        frames = frames.into_iter().skip(self.start).step_by(self.every).collect();
        frames.iter_mut().zip(0..).for_each(|(frame, index)| frame.index = index);
        sequence.frames = frames;
        sequence.frame_rate_hz = sequence.frame_rate_hz.map(|rate| rate / self.every as f64);
        if self.mirrored {
            let has_right = sequence.sensor == geometry::Sensor::Stereo;
            let offset = Vec3::new(if has_right { baseline_m } else { 0.0 }, 0.0, 0.0);
            let body_from_new_left = sequence.body_from_left * SE3::new(SO3::identity(), offset);
            sequence.body_from_left = mirrored_pose(&body_from_new_left);
            let mirrored = |pose: StampedPose| StampedPose {
                world_from_cam: mirrored_pose(&pose.world_from_cam),
                ..pose
            };
            let mirror_all =
                |truth: Trajectory| Trajectory { poses: truth.poses.into_iter().map(mirrored).collect() };
            sequence.ground_truth = sequence.ground_truth.map(mirror_all);
        }
        sequence
    }

    /// The images of a frame, already reduced and rectified; the noise of each depends on `name` alone.
    pub fn apply(&self, frame: LoadedFrame, name: &Path) -> LoadedFrame {
        let name = name.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let number = name.bytes().fold(0, |sum, byte| mix_seed(sum, u64::from(byte), 0));
        let LoadedFrame { left, right, depth } = frame;
        let left = self.perturbed(left, number, 0);
        let right = right.map(|image| self.perturbed(image, number, 1));
        if !self.mirrored {
            return LoadedFrame { left, right, depth };
        }
        let depth = depth.map(|depth: DepthImage| depth.mirrored());
        match right {
            Some(right) => LoadedFrame { left: right.mirrored(), right: Some(left.mirrored()), depth },
            None => LoadedFrame { left: left.mirrored(), right: None, depth },
        }
    }

    fn perturbed(&self, mut image: GrayImage, frame: u64, camera: u64) -> GrayImage {
        if self.gain == 1.0 && self.noise == 0.0 {
            return image;
        }
        let seed = mix_seed(self.seed, frame, camera);
        for (value, place) in image.data.iter_mut().zip(0u64..) {
            let changed = self.gain * f64::from(*value) + self.noise * normal(mix_seed(seed, place, 0));
            // A cast saturates.
            *value = (changed + 0.5) as u8;
        }
        image
    }
}

/// The sum of eight uniform bytes, which is nearly normal, with mean 0 and variance 1.
fn normal(random: u64) -> f64 {
    let sum: u32 = random.to_le_bytes().iter().map(|&byte| u32::from(byte)).sum();
    (f64::from(sum) - 1020.0) / (8.0_f64 * 65535.0 / 12.0).sqrt()
}

/// A pose seen in a mirror that swaps left and right.
fn mirrored_pose(pose: &SE3) -> SE3 {
    let mirror = Mat3::from_diagonal(&Vec3::new(-1.0, 1.0, 1.0));
    let rotation = SO3::from_matrix_unchecked(mirror * pose.rotation.matrix() * mirror);
    SE3::new(rotation, mirror * pose.translation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Raster, Sensor, Vec6};

    /// Ten frames and their true poses.
    fn sequence(sensor: Sensor) -> Sequence {
        let one = Sequence::of_image("a.png".as_ref());
        let times = (0..10u32).map(|i| (i, f64::from(i) * 0.5 + 3.0));
        let frames = times.clone().map(|(index, timestamp_s)| super::super::FrameSource {
            index,
            timestamp_ns: (timestamp_s * 1e9) as i64,
            ..one.frames[0].clone()
        });
        let pose = |(i, timestamp_s): (u32, f64)| StampedPose {
            timestamp_s,
            world_from_cam: SE3::exp(&(Vec6::new(0.3, 0.0, 1.0, 0.01, 0.05, -0.02) * f64::from(i))),
        };
        let ground_truth = Some(Trajectory { poses: times.clone().map(pose).collect() });
        Sequence { frames: frames.collect(), ground_truth, sensor, ..one }
    }

    fn variant(text: &str) -> Variant {
        text.parse().unwrap()
    }

    #[test]
    fn words_are_read_and_written() {
        for text in ["plain", "reversed", "reversed-mirrored-every2-start10-gain0.7-noise5-seed3"] {
            assert_eq!(variant(text).to_string(), text);
        }
        for bad in ["", "backwards", "every0", "gain-2", "noise", "reversed2"] {
            assert!(bad.parse::<Variant>().is_err(), "{bad}");
        }
        assert_eq!(
            "reversed-up".parse::<Variant>().unwrap_err().to_string(),
            "variant: found 'up', expected words joined by '-': reversed, mirrored, every2, start10, gain1.2, noise5, \
             seed1, or plain"
        );
    }

    #[test]
    fn frames_run_backwards_with_their_poses() {
        let plain = sequence(Sensor::Mono);
        let back = variant("reversed-start1-every2").of(plain.clone(), 0.0);
        let times: Vec<f64> = back.frames.iter().map(super::super::FrameSource::timestamp_s).collect();
        assert_eq!(times, [0.5, 1.5, 2.5, 3.5, 4.5]);
        assert_eq!(back.frames[2].index, 2);
        let (truth, old) = (back.ground_truth.unwrap(), plain.ground_truth.unwrap());
        assert_eq!(truth.poses[0], StampedPose { timestamp_s: 0.0, ..old.poses[9] });
        assert_eq!(truth.poses[9].world_from_cam, old.poses[0].world_from_cam);
        let twice = variant("reversed").of(variant("reversed").of(sequence(Sensor::Mono), 0.0), 0.0);
        assert_eq!(twice.ground_truth.unwrap().poses[3].world_from_cam, old.poses[3].world_from_cam);
    }

    #[test]
    fn the_mirrored_right_camera_is_the_left_one() {
        let plain = sequence(Sensor::Stereo);
        let mirrored = variant("mirrored").of(plain.clone(), 0.5);
        let (truth, old) = (mirrored.ground_truth.clone().unwrap(), plain.ground_truth.clone().unwrap());
        // A point in the old world, and in the mirror.
        let point = Vec3::new(4.0, -1.0, 9.0);
        let image = Vec3::new(-point.x, point.y, point.z);
        for i in [0, 4, 9] {
            let right = SE3::new(SO3::identity(), Vec3::new(0.5, 0.0, 0.0));
            let seen = (old.poses[i].world_from_cam * right).inverse() * point;
            let new_left = truth.poses[i].world_from_cam * mirrored.body_from_left;
            let seen_now = new_left.inverse() * image;
            assert!((seen_now - Vec3::new(-seen.x, seen.y, seen.z)).norm() < 1e-12, "{seen_now} {seen}");
        }
        let twice = variant("mirrored").of(mirrored, 0.5);
        assert!((twice.body_from_left.matrix() - plain.body_from_left.matrix()).amax() < 1e-12);
    }

    #[test]
    fn images_are_flipped_and_swapped() {
        let image = |first: u8| GrayImage::from_fn(3, 2, |x, y| first + x as u8 + 10 * y as u8);
        let depth = Raster::from_fn(3, 2, |x, _| x as u16);
        let frame = LoadedFrame { left: image(0), right: Some(image(100)), depth: Some(depth) };
        let new = variant("mirrored").apply(frame.clone(), "a.png".as_ref());
        assert_eq!((new.left.at(0, 1), new.right.unwrap().at(2, 0)), (112, 0));
        assert_eq!(new.depth.unwrap().data, [2, 1, 0, 2, 1, 0]);
        let same = variant("plain").apply(frame.clone(), "a.png".as_ref());
        assert_eq!((same.left, same.right), (frame.left, frame.right));
    }

    #[test]
    fn noise_has_its_size_and_depends_on_seed_and_name() {
        let gray = || LoadedFrame { left: GrayImage::new(200, 100, 100), right: None, depth: None };
        let of = |text: &str, name: &str| variant(text).apply(gray(), name.as_ref()).left;
        let noisy = of("gain1.2-noise5", "a.png");
        let mean = noisy.data.iter().map(|&v| f64::from(v)).sum::<f64>() / 20_000.0;
        let variance = noisy.data.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / 20_000.0;
        assert!((mean - 120.0).abs() < 0.2 && (variance.sqrt() - 5.0).abs() < 0.15, "{mean} {variance}");
        assert_eq!(noisy, of("gain1.2-noise5", "b/a.png"));
        assert_ne!(noisy, of("gain1.2-noise5-seed1", "a.png"));
        assert_ne!(noisy, of("gain1.2-noise5", "b.png"));
    }
}
