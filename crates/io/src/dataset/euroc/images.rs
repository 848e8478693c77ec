//! The image lists of EuRoC cameras (`data.csv`: nanoseconds, file name) and their pairs by time.

use std::path::{Path, PathBuf};

use super::super::DatasetError;
use super::super::associate::associate;
use super::super::image_folder::names;
use super::super::stamps::{Order, of_names};
use crate::file::{FileError, TextFile, counted, shown};

const EXPECTED: &str = "nanoseconds and a file name, separated by a comma";

/// Largest time between the two images of a pair, seconds (exclusive): the cameras of a rig are triggered together, at most at
/// some hundred hertz.
const PAIR_TOLERANCE_S: f64 = 1e-3;

/// One row of a list.
pub(super) struct Image {
    pub(super) nanoseconds: i64,
    line: usize,
    pub(super) path: PathBuf,
}

/// The images of one camera, at least one, by increasing time.
pub(super) struct ImageList {
    file: PathBuf,
    pub(super) images: Vec<Image>,
    /// Whether there is no list, but names that are times.
    pub(super) is_of_names: bool,
}

impl ImageList {
    /// Reads `data.csv` of a camera's folder; without it the names of the images in `data` are their times.
    pub(super) fn read(camera: &Path, warnings: &mut Vec<String>) -> Result<Self, FileError> {
        let path = camera.join("data.csv");
        if !path.exists()
            && let Some(images) = Self::of_names(camera)?
        {
            warnings.push(format!(
                "{}: no such file, so the names of the images are taken as their times in nanoseconds",
                path.display()
            ));
            return Ok(images);
        }
        let file = TextFile::read(&path, "the image list of a camera (EuRoC)")?;
        let mut images: Vec<Image> = Vec::new();
        let mut order = Order::default();
        for (i, line) in file.data_lines().enumerate() {
            let is_separator = |c: char| if line.text.contains(',') { c == ',' } else { c.is_whitespace() };
            let fields: Vec<&str> = line.text.split(is_separator).map(str::trim).collect();
            let [stamp, name] = fields[..] else {
                return Err(line.error(counted(fields.len(), "field"), EXPECTED));
            };
            let nanoseconds = match stamp.parse() {
                Ok(nanoseconds) => nanoseconds,
                // A header without `#`.
                Err(_) if i == 0 && stamp.contains("time") => continue,
                Err(_) => return Err(line.error(shown(stamp), "whole nanoseconds")),
            };
            // Some lists name the folder as well.
            let Some(name) = Path::new(name).file_name() else {
                return Err(line.error("no file name", EXPECTED));
            };
            order.next(&line, nanoseconds)?;
            images.push(Image { nanoseconds, line: line.number, path: camera.join("data").join(name) });
        }
        if images.is_empty() {
            return Err(file.empty(EXPECTED));
        }
        Ok(Self { file: path, images, is_of_names: false })
    }

    /// The images whose names are times, if all names are.
    fn of_names(camera: &Path) -> Result<Option<Self>, FileError> {
        let folder = camera.join("data");
        let paths = names::list(&folder)?;
        let stems: Vec<String> = paths.iter().map(|path| names::stem(path)).collect();
        let Some(times) = of_names(stems.iter().map(String::as_str)) else { return Ok(None) };
        let row = |(line, (nanoseconds, path))| Image { nanoseconds, line, path };
        let images = (1..).zip(times.into_iter().zip(paths)).map(row).collect();
        Ok(Some(Self { file: folder, images, is_of_names: true }))
    }

    /// Tells of images that the list names but the folder lacks; their frames stay and count as dropped when they are loaded.
    ///
    /// # Errors
    /// [`FileError::Line`] for the first row when no image is there at all.
    pub(super) fn warn_of_missing(&self, warnings: &mut Vec<String>) -> Result<(), FileError> {
        let missing: Vec<&Image> = self.images.iter().filter(|image| !image.path.is_file()).collect();
        let Some(first) = missing.first() else { return Ok(()) };
        let found = format!("the name of a missing file ({})", first.path.display());
        if missing.len() == self.images.len() {
            let expected = "the name of an image in the folder data";
            return Err(FileError::Line {
                path: self.file.clone(),
                line: first.line,
                found,
                expected: expected.to_string(),
            });
        }
        warnings.push(format!(
            "{}:{}: found {found}; {} of {} are missing, and their frames will be dropped",
            self.file.display(),
            first.line,
            missing.len(),
            counted(self.images.len(), "image"),
        ));
        Ok(())
    }

    /// Times in seconds after the epoch `start`, which keeps their digits.
    fn seconds_after(&self, start: i64) -> Vec<f64> {
        self.images.iter().map(|image| image.nanoseconds.saturating_sub(start) as f64 * 1e-9).collect()
    }

    /// The file with its first and last time, for messages.
    fn describe(&self) -> String {
        let (first, last) = (&self.images[0], &self.images[self.images.len() - 1]);
        format!("{} has times {} to {}", self.file.display(), first.nanoseconds, last.nanoseconds)
    }
}

/// The left images that have a right one at the same time, with it.
///
/// # Errors
/// [`DatasetError::Unexpected`] when there is none.
pub(super) fn pair<'a>(
    left: &'a ImageList,
    right: &'a ImageList,
    warnings: &mut Vec<String>,
) -> Result<Vec<(&'a Image, &'a Image)>, DatasetError> {
    let start = left.images[0].nanoseconds;
    let (left_s, right_s) = (left.seconds_after(start), right.seconds_after(start));
    let partners = associate(&left_s, &right_s, PAIR_TOLERANCE_S);
    let pairs: Vec<_> = left
        .images
        .iter()
        .zip(&partners)
        .filter_map(|(image, partner)| Some((image, &right.images[(*partner)?])))
        .collect();
    if pairs.is_empty() {
        let nearest_ms = nearest_s(&left_s, &right_s) * 1e3;
        let found = format!(
            "no time of an image of cam0: {}, {}, the nearest two are {nearest_ms:.3} ms apart",
            left.describe(),
            right.describe()
        );
        let expected = format!("one within {} ms", PAIR_TOLERANCE_S * 1e3);
        return Err(DatasetError::unexpected(&right.file, found, expected));
    }
    for (list, other) in [(left, "cam1"), (right, "cam0")] {
        let n_single = list.images.len() - pairs.len();
        if n_single > 0 {
            warnings.push(format!(
                "{}: {n_single} of {} have no image of {other} within {} ms and are skipped",
                list.file.display(),
                counted(list.images.len(), "image"),
                PAIR_TOLERANCE_S * 1e3,
            ));
        }
    }
    Ok(pairs)
}

/// The smallest time between an image of one list and one of the other.
fn nearest_s(first: &[f64], second: &[f64]) -> f64 {
    let nearest = |time: &f64| {
        let after = second.partition_point(|other| other < time);
        let around = second[after.saturating_sub(1)..second.len().min(after + 1)].iter();
        around.map(|other| (other - time).abs()).fold(f64::INFINITY, f64::min)
    };
    first.iter().map(nearest).fold(f64::INFINITY, f64::min)
}
