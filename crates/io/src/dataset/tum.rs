//! TUM RGB-D folders and those that resemble them: lists of color and of depth images with their times (`rgb.txt` and `depth.txt`;
//! OpenLORIS: `color.txt` and `aligned_depth.txt`), or one list of both (`associations.txt`, as ORB-SLAM2 wants it).

use std::path::{Path, PathBuf};

use super::associate::associate;
use super::given::Given;
use super::layout::SequenceKind;
use super::stamps::{Order, of_field, of_name, seconds};
use super::{
    DatasetError, FrameSource, OpenOptions, Sensor, Sequence, choose_sensor, folder_name, monocular, truth,
};
use crate::file::{FileError, Line, TextFile, counted};
use crate::images::image_size;
use crate::trajectory::TrajectoryFormat;

const EXPECTED: &str = "a time in seconds and a file name per line";

/// Names of the two lists, with what one meter is in the depth images where the dataset says so.
const PAIRS: [([&str; 2], Option<f64>); 2] =
    [(["rgb.txt", "depth.txt"], None), (["color.txt", "aligned_depth.txt"], Some(1000.0))];
/// Names of a list of both.
const BOTH: [&str; 5] =
    ["associations.txt", "associate.txt", "association.txt", "associated.txt", "rgbd_assoc.txt"];

/// The lists of a folder.
pub(super) struct Lists {
    color: PathBuf,
    depth: PathBuf,
    depth_units_per_metre: Option<f64>,
}

/// One entry of a list: an image, and in a list of both its depth image.
struct Entry {
    ns: i64,
    path: PathBuf,
    depth: Option<PathBuf>,
}

impl Lists {
    /// The lists of a folder, if it has some.
    pub(super) fn find(dir: &Path) -> Option<Self> {
        let two = PAIRS.iter().find(|([color, depth], _)| {
            // Files of these names beside other things say little.
            dir.join(color).exists() && (*color == "rgb.txt" || dir.join(depth).exists())
        });
        if let Some(([color, depth], units)) = two {
            let (color, depth) = (dir.join(color), dir.join(depth));
            return Some(Self { color, depth, depth_units_per_metre: *units });
        }
        let both = BOTH.iter().map(|name| dir.join(name)).find(|path| path.is_file())?;
        Some(Self { color: both.clone(), depth: both, depth_units_per_metre: None })
    }
}

/// Opens a TUM RGB-D sequence.
pub(super) fn open(
    dir: &Path,
    lists: &Lists,
    options: &OpenOptions,
    given: &Given,
) -> Result<Sequence, DatasetError> {
    let mut warnings = Vec::new();
    let color = read_list(dir, &lists.color, &mut warnings)?;
    let has_both = color.iter().any(|entry| entry.depth.is_some());
    let no_right = Some("TUM RGB-D folders contain no right images".to_owned());
    // Depth images that are asked for and missing are told by the list.
    let is_poor = options.sensor.is_none() && !has_both && !lists.depth.is_file();
    let no_depth = is_poor.then(String::new);
    let mut sensor = choose_sensor(dir, options.sensor, no_right, no_depth)?;
    warnings.extend(monocular(&lists.depth, options.sensor, sensor, "no such file"));
    let of_images = color.iter().find_map(|entry| image_size(&entry.path).ok());
    let replaced = given.replace((options.sensor, sensor), None, of_images, dir, &mut warnings)?;
    let cameras = replaced.map(|(possible, cameras)| {
        sensor = possible;
        cameras
    });
    let frames: Vec<FrameSource> = match sensor {
        Sensor::Rgbd if has_both => color.into_iter().enumerate().map(|(i, entry)| frame(i, entry)).collect(),
        Sensor::Rgbd => {
            let depth = read_list(dir, &lists.depth, &mut warnings)?;
            pair_frames(dir, lists, color, depth, options.association_tolerance_s, &mut warnings)?
        }
        _ => {
            let alone = |(i, entry)| frame(i, Entry { depth: None, ..entry });
            color.into_iter().enumerate().map(alone).collect()
        }
    };
    let usual = [dir.join("groundtruth.txt")];
    let ground_truth = truth::read(options, &usual, TrajectoryFormat::Tum, &frames, &mut warnings)?;
    let cameras = cameras.unwrap_or_default();
    Ok(Sequence {
        frames,
        ground_truth,
        body_from_left: geometry::SE3::identity(),
        depth_units_per_metre: lists.depth_units_per_metre,
        warnings,
        ..Sequence::new(folder_name(dir), SequenceKind::TumRgbd, sensor).seen_by(cameras)
    })
}

fn frame(index: usize, entry: Entry) -> FrameSource {
    FrameSource { depth: entry.depth, ..FrameSource::of(index, entry.ns, entry.path) }
}

/// Reads a list of images: times that do not go back, and paths relative to the folder.
fn read_list(dir: &Path, path: &Path, warnings: &mut Vec<String>) -> Result<Vec<Entry>, FileError> {
    let file = TextFile::read(path, EXPECTED)?;
    let mut entries: Vec<Entry> = Vec::new();
    let mut order = Order::default();
    for line in file.data_lines() {
        let entry = read_entry(&line)?;
        order.next(&line, entry.ns)?;
        entries.push(entry);
    }
    let Some(first) = entries.first() else { return Err(file.empty(EXPECTED)) };
    let place = Place::of(dir, &first.path);
    if place != Place::Folder && dir.join(&first.path) != place.resolve(dir, &first.path) {
        warnings.push(format!(
            "{}: the images are not where it says; they are read from {} and so on",
            path.display(),
            place.resolve(dir, &first.path).display()
        ));
    }
    for entry in &mut entries {
        entry.path = place.resolve(dir, &entry.path);
        entry.depth = entry.depth.take().map(|depth| place.resolve(dir, &depth));
    }
    Ok(entries)
}

/// A time and a name, which may have blanks; or two times with two names, of color and of depth.
fn read_entry(line: &Line<'_>) -> Result<Entry, FileError> {
    let comma = line.text.split_whitespace().next().is_some_and(|first| first.contains(','));
    let text = if comma { line.text.replace(',', " ") } else { line.text.to_owned() };
    let fields: Vec<&str> = text.split_whitespace().collect();
    match fields[..] {
        [time, first, other, second] if other.parse::<f64>().is_ok() => {
            let is_depth = first.to_ascii_lowercase().contains("depth");
            let [(time, color), (_, depth)] =
                if is_depth { [(other, second), (time, first)] } else { [(time, first), (other, second)] };
            Ok(Entry { ns: of_field(line, time)?, path: color.into(), depth: Some(depth.into()) })
        }
        [time, _, ..] => {
            let ns = of_field(line, time)?;
            let name = text.trim_start().strip_prefix(time).unwrap_or_default().trim();
            Ok(Entry { ns, path: name.into(), depth: None })
        }
        // A name that is a time.
        [name] => {
            let stem = Path::new(name).file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
            let ns = of_name(stem).ok_or_else(|| line.error("1 field", EXPECTED))?;
            Ok(Entry { ns, path: name.into(), depth: None })
        }
        _ => Err(line.error(counted(fields.len(), "field"), EXPECTED)),
    }
}

/// Where the paths of a list lead to.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    /// Relative to the folder, as they should be.
    Folder,
    /// Relative to the folder around it.
    Parent,
    /// Of another machine: their last folder and their name are right.
    LastTwo,
    /// Their name is right, and the file is beside the list.
    Name,
}

impl Place {
    /// The first place where an image is found.
    fn of(dir: &Path, path: &Path) -> Self {
        let mut all = [Self::Folder, Self::Parent, Self::LastTwo, Self::Name].into_iter();
        all.find(|place| place.resolve(dir, path).is_file()).unwrap_or(Self::Folder)
    }

    fn resolve(self, dir: &Path, path: &Path) -> PathBuf {
        let name = path.file_name().unwrap_or_default();
        let folder = path.parent().and_then(Path::file_name).unwrap_or_default();
        match self {
            Self::Folder => dir.join(path),
            Self::Parent => dir.join("..").join(path),
            Self::LastTwo => dir.join(folder).join(name),
            Self::Name => dir.join(name),
        }
    }
}

/// Frames out of the color images that have a depth image near in time.
fn pair_frames(
    dir: &Path,
    lists: &Lists,
    color: Vec<Entry>,
    depth: Vec<Entry>,
    tolerance_s: f64,
    warnings: &mut Vec<String>,
) -> Result<Vec<FrameSource>, DatasetError> {
    let times = |entries: &[Entry]| entries.iter().map(|entry| seconds(entry.ns)).collect::<Vec<_>>();
    let partners = associate(&times(&color), &times(&depth), tolerance_s);
    let n_single = partners.iter().filter(|partner| partner.is_none()).count();
    let tolerance_ms = tolerance_s * 1e3;
    if n_single == color.len() {
        let reason = format!("no color image has a depth image within {tolerance_ms} ms");
        return Err(DatasetError::unavailable(dir, Sensor::Rgbd, reason));
    }
    if n_single > 0 {
        warnings.push(format!(
            "{}: {n_single} of {} have no depth image within {tolerance_ms} ms and are skipped",
            lists.color.display(),
            counted(color.len(), "color image"),
        ));
    }
    let pairs = color.into_iter().zip(partners).filter_map(|(entry, partner)| Some((entry, partner?)));
    Ok(pairs
        .enumerate()
        .map(|(i, (entry, partner))| frame(i, Entry { depth: Some(depth[partner].path.clone()), ..entry }))
        .collect())
}
