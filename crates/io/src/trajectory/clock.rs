//! The stamps of frames as they were read: 19 digits of nanoseconds are more than a double holds.

use std::fmt;

use super::super::dataset::FrameSource;
use super::super::dataset::stamps::{nanoseconds, seconds};

/// The times of a sequence's frames, so that poses are written with the very stamps that were read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clock {
    /// Seconds and nanoseconds, by rising seconds.
    times: Vec<(f64, i64)>,
}

/// A time that is written as seconds with nine decimals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp(pub(crate) i64);

impl Clock {
    /// The clock of these frames.
    pub fn of(frames: &[FrameSource]) -> Self {
        Self::of_stamps(frames.iter().map(|frame| frame.timestamp_ns))
    }

    /// The clock of these stamps, nanoseconds.
    pub fn of_stamps(stamps: impl Iterator<Item = i64>) -> Self {
        Self::default().with(stamps)
    }

    /// The clock that knows these stamps too, nanoseconds.
    #[must_use]
    pub fn with(mut self, stamps: impl Iterator<Item = i64>) -> Self {
        self.times.extend(stamps.map(|ns| (seconds(ns), ns)));
        self.times.sort_by(|a, b| a.0.total_cmp(&b.0));
        self
    }

    /// The nanoseconds of those of these times, seconds, that a double does not tell; in order, each once. They make a clock for the
    /// same times where only doubles are kept.
    pub fn beyond_doubles(&self, times_s: impl Iterator<Item = f64>) -> Vec<i64> {
        let stamps = times_s.map(|time| (self.nanoseconds(time), nanoseconds(time)));
        let mut beyond: Vec<i64> = stamps.filter(|(ns, nearest)| ns != nearest).map(|(ns, _)| ns).collect();
        beyond.sort_unstable();
        beyond.dedup();
        beyond
    }

    /// The nanoseconds of a frame's time in seconds; of any other time the nearest ones.
    pub fn nanoseconds(&self, timestamp_s: f64) -> i64 {
        let found = self.times.binary_search_by(|(seconds, _)| seconds.total_cmp(&timestamp_s));
        found.map_or_else(|_| nanoseconds(timestamp_s), |at| self.times[at].1)
    }

    /// The time as text.
    pub fn stamp(&self, timestamp_s: f64) -> Stamp {
        Stamp(self.nanoseconds(timestamp_s))
    }
}

impl fmt::Display for Stamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SECOND: u64 = 1_000_000_000;
        let (sign, ns) = (if self.0 < 0 { "-" } else { "" }, self.0.unsigned_abs());
        write!(f, "{sign}{}.{:09}", ns / SECOND, ns % SECOND)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_out_are_stamps_in() {
        let stamps = [1_403_636_579_763_555_584, 1_403_636_579_763_556_583, 1_305_031_452_791_720_000];
        let frames = stamps.map(|ns| FrameSource::of(0, ns, "a.png".into()));
        let clock = Clock::of(&frames);
        for frame in &frames {
            assert_eq!(clock.nanoseconds(frame.timestamp_s()), frame.timestamp_ns);
        }
        assert_eq!(clock.stamp(frames[0].timestamp_s()).to_string(), "1403636579.763555584");
        assert_eq!(
            [clock.stamp(0.25).to_string(), clock.stamp(-1.5).to_string()],
            ["0.250000000", "-1.500000000"]
        );
    }

    /// A map keeps seconds as doubles; the digits that they lose lie beside them.
    #[test]
    fn what_doubles_lose_is_kept_beside_them() {
        let stamps = [1_403_636_579_763_555_584, 103_622_400, 1_305_031_452_791_720_000];
        let seconds: Vec<f64> = stamps.iter().map(|&ns| super::seconds(ns)).collect();
        let clock = Clock::of_stamps(stamps.into_iter());
        let beyond = clock.beyond_doubles(seconds.iter().chain(&seconds[..1]).copied());
        assert_eq!(beyond, [stamps[2], stamps[0]], "a double tells the small one, and each is kept once");
        let other = Clock::of_stamps([5].into_iter()).with(beyond.into_iter());
        let read: Vec<i64> = seconds.iter().map(|&time| other.nanoseconds(time)).collect();
        assert_eq!(read, stamps);
    }
}
