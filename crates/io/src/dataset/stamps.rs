//! Times of frames in whole nanoseconds: read from numbers, dates and file names, and checked.

use std::path::Path;
use std::time::SystemTime;

use super::FrameSource;
use crate::file::{FileError, Line, TextFile, counted, shown};
use crate::trajectory::Stamp;

/// Nanoseconds in a second.
const SECOND: i64 = 1_000_000_000;

/// Nanoseconds as the double nearest to the seconds that they are, so that a time has the bits of the same time in a file.
pub fn seconds(ns: i64) -> f64 {
    // Up to 104 days both numbers are exact, and so is the rounding of their quotient.
    if ns.unsigned_abs() < 1 << 53 {
        return ns as f64 / SECOND as f64;
    }
    Stamp(ns).to_string().parse().unwrap_or(ns as f64 / SECOND as f64)
}

/// The nearest time to this many seconds.
pub(crate) fn nanoseconds(seconds: f64) -> i64 {
    // The whole seconds first, so that the digits behind the point are not rounded with those before it.
    let whole = seconds.floor();
    (whole as i64).saturating_mul(SECOND).saturating_add(((seconds - whole) * SECOND as f64).round() as i64)
}

/// Seconds as text (`1305031452.791720`, `1.5e-1`) in nanoseconds, without the rounding of a double where it is written in full.
pub fn nanoseconds_of(text: &str) -> Option<i64> {
    let number: f64 = text.parse().ok().filter(|number: &f64| number.is_finite() && number.abs() < 9.2e9)?;
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || !digits(whole) || !digits(fraction) || fraction.len() > 9 {
        return Some(nanoseconds(number));
    }
    let fraction: i64 = format!("{fraction:0<9}").parse().ok()?;
    Some(whole.parse::<i64>().ok()? * SECOND + fraction)
}

/// A date with a time of day (`2011-09-26 13:02:25.964389445`), in nanoseconds since 1970.
fn parse_date(text: &str) -> Option<i64> {
    let date = humantime::parse_rfc3339_weak(text).ok()?;
    i64::try_from(date.duration_since(SystemTime::UNIX_EPOCH).ok()?.as_nanos()).ok()
}

/// The time in a file name: whole nanoseconds, microseconds or milliseconds since 1970, or seconds with a point.
pub(super) fn of_name(stem: &str) -> Option<i64> {
    let (whole, fraction) = stem.split_once('.').unwrap_or((stem, ""));
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    if !is_number(whole) {
        return None;
    }
    match (whole.len(), fraction) {
        (18 | 19, "") => whole.parse().ok(),
        (16, "") => whole.parse::<i64>().ok()?.checked_mul(1_000),
        (13, "") => whole.parse::<i64>().ok()?.checked_mul(1_000_000),
        (1..=10, fraction) if is_number(fraction) && fraction.len() >= 3 => nanoseconds_of(stem),
        _ => None,
    }
}

/// Times of all these names, if every one is a time and they increase.
pub(super) fn of_names<'a>(stems: impl Iterator<Item = &'a str>) -> Option<Vec<i64>> {
    let times = stems.map(of_name).collect::<Option<Vec<i64>>>()?;
    (!times.is_empty() && times.windows(2).all(|two| two[0] < two[1])).then_some(times)
}

/// The time in a field of a line, in seconds.
pub(super) fn of_field(line: &Line<'_>, field: &str) -> Result<i64, FileError> {
    line.number(field)?;
    nanoseconds_of(field).ok_or_else(|| {
        let expected = "seconds (nanoseconds have their place in EuRoC's and VSLAM-LAB's lists)";
        line.error(shown(field), expected)
    })
}

/// Times that do not decrease; repeated ones are left to [`drop_repeated`] as long as they are few.
#[derive(Default)]
pub(super) struct Order {
    last: Option<i64>,
    n: usize,
    n_repeated: usize,
}

impl Order {
    /// Takes the next time of a list.
    ///
    /// # Errors
    /// It lies before the last one, or too many are repeated.
    pub(super) fn next(&mut self, line: &Line<'_>, ns: i64) -> Result<(), FileError> {
        /// More than every N-th is more than a hiccup.
        const RARE: usize = 10;
        let last = self.last.replace(ns);
        self.n += 1;
        self.n_repeated += usize::from(last == Some(ns));
        match last.filter(|&last| ns < last || ns == last && self.n_repeated > 1 + self.n / RARE) {
            Some(before) => Err(line.error(
                format!("time {} after {} of the previous entry", shown_seconds(ns), shown_seconds(before)),
                "strictly increasing times",
            )),
            None => Ok(()),
        }
    }
}

/// Seconds with the digits that they need.
fn shown_seconds(ns: i64) -> String {
    Stamp(ns).to_string().trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A line per frame: seconds, or a date with a time of day.
///
/// # Errors
/// [`FileError`] for what is not a time, and times that go back.
pub(super) fn read_list(path: &Path) -> Result<Vec<i64>, FileError> {
    const EXPECTED: &str = "a time in seconds per line";
    let file = TextFile::read(path, EXPECTED)?;
    let mut times = Vec::new();
    let mut order = Order::default();
    for line in file.data_lines() {
        let ns = match parse_date(line.text) {
            Some(ns) => ns,
            None => {
                let [_] = line.numbers::<1>(line.text.split_whitespace(), EXPECTED)?;
                of_field(&line, line.text)?
            }
        };
        order.next(&line, ns)?;
        times.push(ns);
    }
    if times.is_empty() { Err(file.empty(EXPECTED)) } else { Ok(times) }
}

/// Leaves out frames whose time is that of the one before.
pub(super) fn drop_repeated(frames: &mut Vec<FrameSource>, warnings: &mut Vec<String>) {
    let mut last = None;
    let mut dropped = Vec::new();
    frames.retain(|frame| {
        let is_new = last.replace(frame.timestamp_ns) != Some(frame.timestamp_ns);
        if !is_new {
            dropped.push(frame.left.display().to_string());
        }
        is_new
    });
    if let Some(first) = dropped.first() {
        warnings.push(format!(
            "{first}: its time is that of the frame before; {} left out",
            if dropped.len() == 1 {
                "the frame is".to_owned()
            } else {
                format!("{} are", counted(dropped.len(), "such frame"))
            }
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_kept_as_they_are_written() {
        for (text, ns) in [
            ("1305031452.791720", 1_305_031_452_791_720_000),
            ("1403636579.763555584", 1_403_636_579_763_555_584),
            ("0", 0),
            ("5.", 5_000_000_000),
            ("1.036224e-01", 103_622_400),
            ("-0.5", -500_000_000),
        ] {
            assert_eq!(nanoseconds_of(text), Some(ns), "{text}");
        }
        for text in ["", "x", "nan", "1403636579763555584", "1e300"] {
            assert_eq!(nanoseconds_of(text), None, "{text}");
        }
        for text in ["1305031452.791720", "1.234567", "5.186880e+00", "0.1", "1403636579.763555584"] {
            assert_eq!(seconds(nanoseconds_of(text).unwrap()), text.parse::<f64>().unwrap(), "{text}");
        }
        assert_eq!(nanoseconds(-0.25), -250_000_000);
        assert_eq!([-250_000_000, 0, 1_500_000_000].map(shown_seconds), ["-0.25", "0", "1.5"]);
    }

    #[test]
    fn dates_count_from_1970() {
        assert_eq!(parse_date("1970-01-02 00:00:01.000000007"), Some(86_401 * SECOND + 7));
        assert_eq!(parse_date("2011-09-26 13:02:25.964389445"), Some(1_317_042_145_964_389_445));
        assert_eq!(parse_date("2000-02-29T12:00:00Z"), Some(951_825_600 * SECOND));
        for text in [
            "0.5",
            "2011-13-26 13:02:25.9",
            "9223372036854775807-01-01 0:0:0",
            "2011-01-01 9223372036854775807:0:0",
        ] {
            assert_eq!(parse_date(text), None, "{text}");
        }
    }

    #[test]
    fn names_are_times_when_all_of_them_are() {
        assert_eq!(of_name("1403636579763555584"), Some(1_403_636_579_763_555_584));
        assert_eq!(of_name("1305031452.791720"), Some(1_305_031_452_791_720_000));
        assert_eq!(of_name("1305031452791"), Some(1_305_031_452_791_000_000));
        assert_eq!((of_name("9999999999999"), of_name("9999999999999999999")), (None, None), "too late");
        assert_eq!((of_name("000012"), of_name("frame-1"), of_name("2.1")), (None, None, None));
        assert_eq!(of_names(["1403636579763555584", "1403636579763555583"].into_iter()), None, "going back");
    }
}
