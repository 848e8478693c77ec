//! VSLAM-LAB's sequences: `rgb.csv` with times in nanoseconds and paths of one or two cameras and of depth, `calibration.yaml`,
//! `groundtruth.csv`.

use std::path::{Path, PathBuf};

use super::cameras::Cameras;
use super::given::Given;
use super::layout::SequenceKind;
use super::stamps::Order;
use super::{DatasetError, FrameSource, OpenOptions, Sensor, Sequence, choose_sensor, folder_name, truth};
use crate::file::{FileError, TextFile, counted, shown};
use crate::images::image_size;
use crate::trajectory::TrajectoryFormat;

/// The columns of `rgb.csv` that are read: the time of the left camera, and paths.
struct Columns {
    time: usize,
    left: usize,
    right: Option<usize>,
    depth: Option<usize>,
}

/// Opens a sequence of VSLAM-LAB.
pub(super) fn open(dir: &Path, options: &OpenOptions, given: &Given) -> Result<Sequence, DatasetError> {
    let mut warnings = Vec::new();
    let frames = read_list(dir)?;
    let has = |get: fn(&FrameSource) -> bool| frames.iter().all(get);
    let lacks = |column: &str| Some(format!("rgb.csv has no {column}"));
    let no_right = lacks("path_rgb_1").filter(|_| !has(|frame| frame.right.is_some()));
    let no_depth = lacks("path_depth_0").filter(|_| !has(|frame| frame.depth.is_some()));
    let sensor = choose_sensor(dir, options.sensor, no_right, no_depth)?;
    let of_images = frames.iter().find_map(|frame| image_size(&frame.left).ok());
    let replaced = given.replace((options.sensor, sensor), None, of_images, dir, &mut warnings)?;
    let (sensor, cameras) = replaced.unwrap_or((sensor, Cameras::default()));
    let frames: Vec<FrameSource> = frames
        .into_iter()
        .map(|frame| FrameSource {
            right: frame.right.filter(|_| sensor == Sensor::Stereo),
            depth: frame.depth.filter(|_| sensor == Sensor::Rgbd),
            ..frame
        })
        .collect();
    let usual = [dir.join("groundtruth.csv"), dir.join("groundtruth.txt")];
    let format = if usual[0].is_file() { TrajectoryFormat::Euroc } else { TrajectoryFormat::Tum };
    let ground_truth = truth::read(options, &usual, format, &frames, &mut warnings)?;
    Ok(Sequence {
        frames,
        ground_truth,
        warnings,
        ..Sequence::new(folder_name(dir), SequenceKind::VslamLab, sensor).seen_by(cameras)
    })
}

/// The frames of `rgb.csv`.
fn read_list(dir: &Path) -> Result<Vec<FrameSource>, FileError> {
    const EXPECTED: &str = "a header with ts_rgb_0 (ns) and path_rgb_0, and a row per frame";
    let file = TextFile::read(&dir.join("rgb.csv"), EXPECTED)?;
    let mut lines = file.data_lines();
    let header = lines.next().ok_or_else(|| file.empty(EXPECTED))?;
    let columns = Columns::of(header.text).ok_or_else(|| header.error(shown(header.text), EXPECTED))?;
    let mut frames: Vec<FrameSource> = Vec::new();
    let mut order = Order::default();
    for line in lines {
        let fields: Vec<&str> = line.text.split(',').map(str::trim).collect();
        let field = |at: usize| {
            fields.get(at).copied().filter(|field| !field.is_empty()).ok_or_else(|| {
                let expected = "as many as the header has";
                line.error(counted(fields.len(), "field"), expected)
            })
        };
        let path = |at: usize| Ok::<PathBuf, FileError>(dir.join(field(at)?));
        let stamp = field(columns.time)?;
        let ns = stamp.parse().map_err(|_| line.error(shown(stamp), "whole nanoseconds"))?;
        order.next(&line, ns)?;
        frames.push(FrameSource {
            right: columns.right.map(path).transpose()?,
            depth: columns.depth.map(path).transpose()?,
            ..FrameSource::of(frames.len(), ns, path(columns.left)?)
        });
    }
    if frames.is_empty() { Err(file.empty(EXPECTED)) } else { Ok(frames) }
}

impl Columns {
    fn of(header: &str) -> Option<Self> {
        let names: Vec<&str> = header.split(',').map(str::trim).collect();
        let at = |name: &str| names.iter().position(|other| other.split(' ').next() == Some(name));
        Some(Self {
            time: at("ts_rgb_0").or_else(|| at("ts_rgb0"))?,
            left: at("path_rgb_0").or_else(|| at("path_rgb0"))?,
            right: at("path_rgb_1").or_else(|| at("path_rgb1")),
            depth: at("path_depth_0").or_else(|| at("path_depth0")),
        })
    }
}
