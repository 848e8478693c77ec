//! Bags as sequences: which topics, the camera that they describe, the frames.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use bag::{Bag, CameraInfo, Choice, Roles, Stamp, Topic, choose};
use io::{
    ImageError, ImageSize, LoadedFrame, OpenOptions, Sensor, Sequence, SequenceKind, StampedPose, Trajectory,
};
use runtime::{FrameFeed, FrameInfo, Preparation, Unusable};

use crate::Error;

/// The images of one frame.
struct BagFrame {
    left: Stamp,
    /// Right image or depth.
    second: Option<Stamp>,
}

/// A bag that has been opened for a run.
pub(crate) struct OpenedBag {
    pub(crate) sequence: Sequence,
    /// Size of the raw images.
    pub(crate) size: ImageSize,
    bag: Bag,
    choice: Choice,
    frames: Vec<BagFrame>,
}

impl OpenedBag {
    /// Opens a bag: topics by `roles` or by their names, poses of the topic that `options.ground_truth` names.
    ///
    /// # Errors
    /// A path that is not a bag, a topic that is not there, a calibration that cannot be used.
    pub(crate) fn new(path: &Path, options: &OpenOptions, roles: Option<&Roles>) -> Result<Self, Error> {
        let truth = options.ground_truth.as_deref();
        let pose_topic =
            truth.filter(|truth| !truth.is_file()).map(|truth| truth.to_string_lossy().into_owned());
        let mut bag = Bag::open(path, pose_topic.as_deref())?;
        let choice = choose(path, bag.topics(), roles)?.as_sensor(options.sensor);
        let sensor = choice.sensor();
        if let Some(wanted) = options.sensor.filter(|wanted| *wanted != sensor) {
            let reason = "the bag has no topic for it (--topics names them)";
            return Err(io::DatasetError::unavailable(path, wanted, reason).into());
        }
        let mut warnings = bag.remarks().to_vec();
        let (frames, told) = frames(&bag, choice, options.association_tolerance_s);
        warnings.push(told);
        let first = frames.first().map(|frame| frame.left);
        let size = size_of(&mut bag, choice.left, first)?;
        let described = match &options.calibration {
            Some(file) => Some(io::open_cameras(file, Some(sensor))?.0),
            None => described(&bag, choice, &mut warnings)?,
        };
        let name =
            path.file_stem().map_or_else(|| "bag".to_owned(), |stem| stem.to_string_lossy().into_owned());
        let sequence = described.unwrap_or_else(|| Sequence::new("", SequenceKind::Bag, sensor));
        let ground_truth = match truth.filter(|truth| truth.is_file()) {
            Some(file) => Some(io::read_trajectory(file, None)?.trajectory),
            None => poses(&bag),
        };
        warnings.extend(sequence.warnings);
        let sequence = Sequence {
            name,
            kind: SequenceKind::Bag,
            frame_rate_hz: None,
            ground_truth,
            warnings,
            ..sequence
        };
        Ok(Self { sequence, size, bag, choice, frames })
    }
}

impl OpenedBag {
    /// Stamps of the frames, nanoseconds.
    pub(crate) fn stamps(&self) -> impl Iterator<Item = i64> {
        self.frames.iter().map(|frame| frame.left.t_ns)
    }
}

/// The frames, and what they were made of in words.
fn frames(bag: &Bag, choice: Choice, tolerance_s: f64) -> (Vec<BagFrame>, String) {
    let name = |topic: usize| bag.topics()[topic].name.as_str();
    let left = bag.stamps(choice.left);
    let Some(second) = choice.right.or(choice.depth) else {
        let frames = left.iter().map(|&left| BagFrame { left, second: None }).collect();
        return (frames, format!("{}: images of {}", bag.path().display(), name(choice.left)));
    };
    let right = bag.stamps(second);
    let times =
        |stamps: &[Stamp]| -> Vec<f64> { stamps.iter().map(|stamp| io::seconds(stamp.t_ns)).collect() };
    let partners = io::associate(&times(left), &times(right), tolerance_s);
    let pairs = left.iter().zip(partners).filter_map(|(left, partner)| Some((*left, right[partner?])));
    let frames: Vec<BagFrame> = pairs.map(|(left, second)| BagFrame { left, second: Some(second) }).collect();
    let apart = |frame: &BagFrame| frame.second.map_or(0, |second| frame.left.t_ns.abs_diff(second.t_ns));
    let distance = match frames.iter().map(apart).max() {
        Some(largest) => format!("at most {:.3} ms apart", largest as f64 * 1e-6),
        None => nearest(left, right),
    };
    let told = format!(
        "{}: {} of {} images of {} have a partner in {}, {distance} (within {} ms)",
        bag.path().display(),
        frames.len(),
        left.len(),
        name(choice.left),
        name(second),
        tolerance_s * 1e3
    );
    (frames, told)
}

/// How far the nearest stamps of two topics without a pair are apart, in words.
fn nearest(left: &[Stamp], right: &[Stamp]) -> String {
    let to = |left: &Stamp| {
        let after = right.partition_point(|stamp| stamp.t_ns < left.t_ns);
        let around = right[after.saturating_sub(1)..].iter().take(2);
        around.map(|stamp| stamp.t_ns.abs_diff(left.t_ns)).min()
    };
    match left.iter().filter_map(to).min() {
        Some(least) => format!("the nearest are {:.3} ms apart", least as f64 * 1e-6),
        None => "which has none".to_owned(),
    }
}

/// Size of a topic's images: that of the first one.
fn size_of(bag: &mut Bag, topic: usize, first: Option<Stamp>) -> Result<ImageSize, Error> {
    if let Some((width, height)) = bag.topics()[topic].size {
        return Ok(ImageSize { width: width as usize, height: height as usize });
    }
    let Some(first) = first else { return Ok(ImageSize { width: 0, height: 0 }) };
    let image = bag.image(topic, first, false)?.into_gray();
    Ok(image.map_or(ImageSize { width: 0, height: 0 }, |image| image.size()))
}

/// The cameras that the bag itself describes, if it does.
fn described(bag: &Bag, choice: Choice, warnings: &mut Vec<String>) -> Result<Option<Sequence>, Error> {
    let sensor = choice.sensor();
    let infos: Vec<(&Topic, &CameraInfo)> = [Some(choice.left), choice.right]
        .into_iter()
        .flatten()
        .filter_map(|topic| Some((&bag.topics()[topic], bag.camera_of(topic)?)))
        .filter(|(_, info)| info.k[0] > 0.0)
        .collect();
    if infos.len() < 1 + usize::from(sensor == Sensor::Stereo) {
        warnings.push(format!(
            "{}: no camera_info beside {}, so the camera must come from --calib or the configuration",
            bag.path().display(),
            bag.topics()[choice.left].name
        ));
        return Ok(None);
    }
    // Calibrations are read in one place, from files.
    let folder =
        tempfile::tempdir().map_err(|reason| Error::unreadable(Path::new("temporary folder"), &reason))?;
    let names = if infos.len() == 2 { &["left.yaml", "right.yaml"][..] } else { &["camera.yaml"][..] };
    for ((topic, info), name) in infos.iter().zip(names) {
        io::write_atomic(&folder.path().join(name), yaml(topic, info).as_bytes())?;
    }
    let (mut sequence, _) = io::open_cameras(&folder.path().join(names[0]), Some(sensor))?;
    if let Some(calibration) = &mut sequence.calibration {
        calibration.source = format!("camera_info beside {} in {}", infos[0].0.name, bag.path().display());
    }
    // They name files that nobody has seen.
    sequence.warnings.clear();
    Ok(Some(sequence))
}

/// A camera as `camera_calibration` writes it; of a rectified image, the rectified camera.
fn yaml(topic: &Topic, info: &CameraInfo) -> String {
    let is_rectified = topic.name.contains("rect");
    let p = &info.p;
    let (k, r) = if is_rectified {
        (
            [p[0], p[1], p[2], p[4], p[5], p[6], p[8], p[9], p[10]],
            [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        )
    } else {
        (info.k, info.r)
    };
    let no_lens = [0.0; 5];
    let d = if is_rectified || info.d.is_empty() { &no_lens[..] } else { &info.d };
    let model = if is_rectified || info.model.is_empty() { "plumb_bob" } else { &info.model };
    let (width, height) = info.size;
    let mut text = format!("image_width: {width}\nimage_height: {height}\ndistortion_model: {model}\n");
    for (name, rows, columns, values) in [
        ("camera_matrix", 3, 3, &k[..]),
        ("distortion_coefficients", 1, d.len(), d),
        ("rectification_matrix", 3, 3, &r[..]),
        ("projection_matrix", 3, 4, &p[..]),
    ] {
        // Writing into a string cannot fail.
        let _ = writeln!(text, "{name}:\n  rows: {rows}\n  cols: {columns}\n  data: {values:?}");
    }
    text
}

/// The poses that were asked for, each time once.
fn poses(bag: &Bag) -> Option<Trajectory> {
    let mut poses: Vec<StampedPose> = bag
        .poses()
        .0
        .iter()
        .map(|pose| StampedPose { timestamp_s: io::seconds(pose.t_ns), world_from_cam: pose.pose })
        .collect();
    poses.sort_by(|a, b| a.timestamp_s.total_cmp(&b.timestamp_s));
    poses.dedup_by_key(|pose| pose.timestamp_s);
    (!poses.is_empty()).then_some(Trajectory { poses })
}

/// The frames of a bag.
pub(crate) struct BagFeed {
    bag: Mutex<Bag>,
    choice: Choice,
    frames: Vec<BagFrame>,
    preparation: Preparation,
    depth_units_per_meter: f64,
}

impl BagFeed {
    /// The frames of an opened bag, or the first `max_frames`.
    pub(crate) fn new(
        opened: OpenedBag,
        preparation: Preparation,
        max_frames: Option<usize>,
        depth_units_per_meter: f64,
    ) -> Self {
        let OpenedBag { bag, choice, mut frames, .. } = opened;
        frames.truncate(max_frames.unwrap_or(usize::MAX));
        Self { bag: Mutex::new(bag), choice, frames, preparation, depth_units_per_meter }
    }

    fn images(&self, bag: &mut Bag, frame: &BagFrame) -> Result<LoadedFrame, Unusable> {
        let path = bag.path().to_path_buf();
        let broken = |error: bag::BagError| {
            Unusable::Image(ImageError::Unreadable { path: path.clone(), reason: error.to_string() })
        };
        let gray = |bag: &mut Bag, topic, stamp| {
            let image = bag.image(topic, stamp, false).map_err(broken)?.into_gray();
            image.ok_or(Unusable::Missing("left"))
        };
        let left = gray(bag, self.choice.left, frame.left)?;
        let (mut right, mut depth) = (None, None);
        match (frame.second, self.choice.right, self.choice.depth) {
            (Some(stamp), Some(topic), _) => right = Some(gray(bag, topic, stamp)?),
            (Some(stamp), None, Some(topic)) => {
                let image = bag.image(topic, stamp, true).map_err(broken)?;
                depth = image.into_depth(self.depth_units_per_meter);
            }
            _ => {}
        }
        Ok(LoadedFrame { left, right, depth })
    }
}

impl FrameFeed for BagFeed {
    fn size_hint(&self) -> Option<usize> {
        Some(self.frames.len())
    }

    fn info(&self, i: usize) -> FrameInfo {
        FrameInfo::new(i, io::seconds(self.frames[i].left.t_ns))
    }

    fn load(&self, i: usize) -> Result<LoadedFrame, Unusable> {
        let mut bag = self.bag.lock().unwrap_or_else(PoisonError::into_inner);
        let frame = self.images(&mut bag, &self.frames[i])?;
        self.preparation.apply(frame, bag.path())
    }
}
