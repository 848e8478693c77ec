//! Frames as columns of bytes and back, with their cameras and pyramid levels stored once.

use std::borrow::Cow;
use std::sync::Arc;

use features::{Descriptor, Features, Frame, Keypoint, Rig, ScaleLevels};
use geometry::{Distortion, Pinhole, StereoRig};

use super::content::{FrameRecord, ScalesRecord};

/// Cameras and pyramid levels that frames refer to by index.
#[derive(Default)]
pub(super) struct Shared {
    pub(super) rigs: Vec<Arc<Rig>>,
    pub(super) scales: Vec<Arc<ScaleLevels>>,
}

impl Shared {
    /// Takes a frame apart.
    pub(super) fn record<'a>(&mut self, frame: &Frame) -> FrameRecord<'a> {
        let keypoint = |value: fn(&Keypoint) -> f32| column(frame.keypoints.iter().map(value));
        let fresh = Frame::new(
            frame.index,
            frame.timestamp_s,
            frame.rig.clone(),
            frame.scales.clone(),
            Features { keypoints: frame.keypoints.clone(), descriptors: frame.descriptors.clone() },
            frame.right_u.clone(),
        );
        let follows = fresh.depth.iter().map(|d| d.to_bits()).eq(frame.depth.iter().map(|d| d.to_bits()));
        FrameRecord {
            index: frame.index,
            timestamp_s: frame.timestamp_s,
            rig: index_in(&mut self.rigs, &frame.rig),
            scales: index_in(&mut self.scales, &frame.scales),
            x: keypoint(|k| k.x),
            y: keypoint(|k| k.y),
            angle_deg: keypoint(|k| k.angle_deg),
            response: keypoint(|k| k.response),
            octave: frame.keypoints.iter().map(|k| k.octave).collect(),
            descriptors: frame.descriptors.iter().flat_map(Descriptor::to_bytes).collect(),
            right_u: column(frame.right_u.iter().copied()),
            depth: (!follows).then(|| column(frame.depth.iter().copied())),
            activation: column(frame.activation.iter().copied()),
            lasting: column(frame.lasting.iter().copied()),
        }
    }

    /// Puts a frame together, or says what is wrong with its parts.
    pub(super) fn frame(&self, record: &FrameRecord<'_>) -> Result<Frame, String> {
        let rig = self.rigs.get(record.rig as usize).ok_or("a camera that does not exist")?.clone();
        let scales =
            self.scales.get(record.scales as usize).ok_or("pyramid levels that do not exist")?.clone();
        let n = record.octave.len();
        let (x, y) = (numbers(&record.x, n)?, numbers(&record.y, n)?);
        let (angle_deg, response) = (numbers(&record.angle_deg, n)?, numbers(&record.response, n)?);
        let (right_u, activation) = (numbers(&record.right_u, n)?, numbers(&record.activation, n)?);
        if record.descriptors.len() != 32 * n {
            return Err(format!("{} bytes of descriptors for {n} features", record.descriptors.len()));
        }
        if let Some(&octave) = record.octave.iter().find(|&&o| usize::from(o) >= scales.len()) {
            return Err(format!("a feature of octave {octave}, there are {} levels", scales.len()));
        }
        if !x.iter().chain(&y).all(|x| x.is_finite()) {
            return Err("a feature whose place is not finite".to_owned());
        }
        let keypoint = |i: usize| Keypoint {
            x: x[i],
            y: y[i],
            octave: record.octave[i],
            angle_deg: angle_deg[i],
            response: response[i],
        };
        let (descriptors, _) = record.descriptors.as_chunks::<32>();
        let features = Features {
            keypoints: (0..n).map(keypoint).collect(),
            descriptors: descriptors.iter().map(Descriptor::from_bytes).collect(),
        };
        let mut frame = Frame::new(record.index, record.timestamp_s, rig, scales, features, right_u);
        if let Some(depth) = &record.depth {
            frame.depth = numbers(depth, n)?;
        }
        (frame.activation, frame.lasting) = (activation, numbers(&record.lasting, n)?);
        Ok(frame)
    }
}

/// The index of a shared value, added if it is new.
fn index_in<T: PartialEq>(known: &mut Vec<Arc<T>>, value: &Arc<T>) -> u32 {
    let at = known.iter().position(|k| Arc::ptr_eq(k, value) || k == value).unwrap_or_else(|| {
        known.push(value.clone());
        known.len() - 1
    });
    u32::try_from(at).expect("fewer than 2^32 cameras")
}

/// The bytes of numbers, all first bytes first.
fn column<'a>(values: impl ExactSizeIterator<Item = f32>) -> Cow<'a, [u8]> {
    let n = values.len();
    let mut bytes = vec![0; 4 * n];
    for (i, value) in values.enumerate() {
        value.to_le_bytes().into_iter().enumerate().for_each(|(place, byte)| bytes[place * n + i] = byte);
    }
    bytes.into()
}

fn numbers(column: &[u8], n: usize) -> Result<Vec<f32>, String> {
    if column.len() != 4 * n {
        return Err(format!("a column of {} bytes for {n} features", column.len()));
    }
    Ok((0..n).map(|i| f32::from_le_bytes(std::array::from_fn(|place| column[place * n + i]))).collect())
}

/// A camera whose numbers are finite.
pub(super) fn finite(rig: &Rig) -> Result<Arc<Rig>, String> {
    let StereoRig { camera: Pinhole { fx, fy, cx, cy }, baseline_m } = rig.stereo;
    let Distortion { k1, k2, p1, p2, k3 } = rig.distortion;
    let numbers = [fx, fy, cx, cy, baseline_m, k1, k2, p1, p2, k3];
    let is_finite = numbers.iter().all(|x| x.is_finite());
    is_finite.then(|| Arc::new(rig.clone())).ok_or("a number of a camera is not finite".to_owned())
}

impl ScalesRecord {
    pub(super) fn of(scales: &ScaleLevels) -> Self {
        let level = |l: usize| [scales.scales[l], scales.sigma_sq[l], scales.inv_sigma_sq[l]];
        ScalesRecord { factor: scales.factor, levels: (0..scales.len()).map(level).collect() }
    }

    pub(super) fn scales(&self) -> Result<Arc<ScaleLevels>, String> {
        let is_good = |x: &f32| x.is_finite() && *x > 0.0;
        if self.levels.is_empty() || !self.levels.as_flattened().iter().all(is_good) {
            return Err("pyramid levels without a positive scale".to_owned());
        }
        let quantity = |q: usize| self.levels.iter().map(|level| level[q]).collect();
        Ok(Arc::new(ScaleLevels {
            factor: self.factor,
            scales: quantity(0),
            sigma_sq: quantity(1),
            inv_sigma_sq: quantity(2),
        }))
    }
}
