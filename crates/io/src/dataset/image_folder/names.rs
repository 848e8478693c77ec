//! Names of image files: natural order (`2` before `10`), and which left and right names belong together.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use crate::file::{FileError, entries};
use crate::images::IMAGE_ENDINGS;

/// A piece of a name: digits without their leading zeros, or what stands between digits.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Piece<'a> {
    Digits(&'a str),
    Text(&'a str),
}

/// The images of a folder in natural order; none where there is no such folder.
///
/// # Errors
/// [`FileError::Unreadable`].
pub(in super::super) fn list(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    list_ending(folder, &IMAGE_ENDINGS)
}

/// As [`list`], of depth images, which may be NumPy files; OpenEXR is listed so that it can be refused by its name.
///
/// # Errors
/// [`FileError::Unreadable`].
pub(super) fn list_depth(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    list_ending(folder, &[&IMAGE_ENDINGS[..], &["npy", "exr"]].concat())
}

fn list_ending(folder: &Path, endings: &[&str]) -> Result<Vec<PathBuf>, FileError> {
    let mut paths = entries(folder)?;
    paths.retain(|path| has_ending(path, endings));
    paths.sort_by(|a, b| natural_order(&name(a), &name(b)));
    Ok(paths)
}

/// Left and right images that belong together, in the order of the left ones, with the position of the left one. They do when
/// the numbers in their names are equal (`left7`, `right7`), or the names where numbers do not tell them apart.
pub(in super::super) fn pair(left: &[PathBuf], right: &[PathBuf]) -> Vec<(usize, PathBuf, PathBuf)> {
    let by = |key: fn(&str) -> String| Some((keys(left, key)?, keys(right, key)?));
    let Some((left_keys, right_keys)) = by(numbers_of).or_else(|| by(str::to_string)) else {
        return Vec::new();
    };
    let mut partners: Vec<(&String, &PathBuf)> = right_keys.iter().zip(right).collect();
    partners.sort();
    let partner = |key: &String| {
        let at = partners.binary_search_by(|(other, _)| other.cmp(&key)).ok()?;
        Some(partners[at].1.clone())
    };
    let found = left_keys.iter().zip(left).enumerate();
    found.filter_map(|(i, (key, path))| Some((i, path.clone(), partner(key)?))).collect()
}

/// A key per name; `None` when a name has none or two have the same.
fn keys(paths: &[PathBuf], key: fn(&str) -> String) -> Option<Vec<String>> {
    let keys: Vec<String> = paths.iter().map(|path| key(&stem(path))).collect();
    let mut sorted: Vec<&String> = keys.iter().collect();
    sorted.sort();
    let is_unique = sorted.windows(2).all(|two| two[0] != two[1]);
    (is_unique && keys.iter().all(|key| !key.is_empty())).then_some(keys)
}

/// The numbers in a name, such as `3,17` for `run3_left017`.
fn numbers_of(name: &str) -> String {
    let digits = pieces(name).into_iter().filter_map(|piece| match piece {
        Piece::Digits("") => Some("0"),
        Piece::Digits(digits) => Some(digits),
        Piece::Text(_) => None,
    });
    digits.collect::<Vec<_>>().join(",")
}

/// Compares names as people do: runs of digits by their value, everything else by its characters.
fn natural_order(a: &str, b: &str) -> Ordering {
    let by_value = |a: &str, b: &str| a.len().cmp(&b.len()).then_with(|| a.cmp(b));
    for pair in pieces(a).iter().zip(&pieces(b)) {
        let order = match pair {
            (Piece::Digits(a), Piece::Digits(b)) => by_value(a, b),
            (Piece::Text(a), Piece::Text(b)) => a.cmp(b),
            (Piece::Digits(_), Piece::Text(_)) => Ordering::Less,
            (Piece::Text(_), Piece::Digits(_)) => Ordering::Greater,
        };
        if order != Ordering::Equal {
            return order;
        }
    }
    // One is the beginning of the other, or they differ in leading zeros.
    pieces(a).len().cmp(&pieces(b).len()).then_with(|| a.cmp(b))
}

fn pieces(name: &str) -> Vec<Piece<'_>> {
    let mut pieces = Vec::new();
    let mut rest = name;
    while let Some(first) = rest.chars().next() {
        let is_digit = first.is_ascii_digit();
        let end = rest.find(|c: char| c.is_ascii_digit() != is_digit).unwrap_or(rest.len());
        let (piece, after) = rest.split_at(end);
        pieces.push(if is_digit { Piece::Digits(piece.trim_start_matches('0')) } else { Piece::Text(piece) });
        rest = after;
    }
    pieces
}

/// Whether it is a file with one of these endings; what macOS puts beside files (`._0.png`) is not.
fn has_ending(path: &Path, endings: &[&str]) -> bool {
    let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
    let known = extension.as_ref().and_then(|extension| extension.to_str());
    known.is_some_and(|extension| endings.contains(&extension))
        && !name(path).starts_with('.')
        && path.is_file()
}

fn name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

pub(in super::super) fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(names: &[&str]) -> Vec<PathBuf> {
        names.iter().map(PathBuf::from).collect()
    }

    fn pairs(left: &[&str], right: &[&str]) -> Vec<(usize, String, String)> {
        let shown = |path: PathBuf| path.display().to_string();
        pair(&paths(left), &paths(right)).into_iter().map(|(i, a, b)| (i, shown(a), shown(b))).collect()
    }

    #[test]
    fn numbers_sort_by_their_value() {
        let mut names =
            ["b1.png", "a10.png", "a9.png", "a010.png", "a.png", "7.png", "a9b2.png", "a9b11.png"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(
            names,
            ["7.png", "a9.png", "a9b2.png", "a9b11.png", "a010.png", "a10.png", "a.png", "b1.png"]
        );
        let long = "123456789012345678901234567890";
        assert_eq!(natural_order(long, &format!("{long}0")), Ordering::Less);
        assert_eq!(natural_order("x", "x"), Ordering::Equal);
    }

    #[test]
    fn equal_numbers_belong_together_whatever_stands_around_them() {
        let found = pairs(&["left1.jpg", "left2.jpg", "left10.jpg"], &["right10.jpg", "right02.png"]);
        assert_eq!(
            found,
            [
                (1, "left2.jpg".to_string(), "right02.png".to_string()),
                (2, "left10.jpg".to_string(), "right10.jpg".to_string())
            ]
        );
        assert!(pairs(&["l0.png"], &["r1.png"]).is_empty());
        assert_eq!(pairs(&["l0.png"], &["r00.png"]).len(), 1, "zero is a number");
    }

    #[test]
    fn without_telling_numbers_equal_names_belong_together() {
        assert_eq!(pairs(&["a.png", "b.png"], &["b.png", "c.png"]), [(1, "b.png".into(), "b.png".into())]);
        assert_eq!(pairs(&["a1.png", "b1.png"], &["b1.jpg"]), [(1, "b1.png".into(), "b1.jpg".into())]);
    }
}
