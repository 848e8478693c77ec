//! Time and memory of this process: the only part of the program that looks at a clock.
#![allow(clippy::disallowed_methods, reason = "measures the run; nothing here reaches the algorithms")]

use std::time::{Instant, SystemTime};

/// Kernel ticks per second in `/proc/self/stat`: fixed at 100 for user space on Linux.
const TICKS_PER_SECOND: f64 = 100.0;

/// A stop watch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StopWatch(Instant);

impl StopWatch {
    /// Starts now.
    pub(crate) fn start() -> Self {
        Self(Instant::now())
    }

    /// Seconds since the start.
    pub(crate) fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

/// The present time as `2026-11-25T19-48-03Z`: sorts by time and is a file name everywhere.
pub(crate) fn utc_stamp() -> String {
    humantime::format_rfc3339_seconds(SystemTime::now()).to_string().replace(':', "-")
}

/// Processor time of all threads of this process so far, seconds. `None` where there is no `/proc`.
pub(crate) fn cpu_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    parse_cpu_seconds(&stat)
}

/// User and system time: the 14th and 15th field, counted after the command's name, which may hold blanks.
fn parse_cpu_seconds(stat: &str) -> Option<f64> {
    let fields: Vec<&str> = stat.rsplit_once(") ")?.1.split_whitespace().collect();
    let ticks = |i: usize| fields.get(i)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / TICKS_PER_SECOND)
}

/// The largest resident memory of this process so far, megabytes (10^6 bytes). `None` where there is no `/proc`.
pub(crate) fn peak_rss_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    parse_peak_rss_mb(&status)
}

/// The `VmHWM` line, which counts in units of 1024 bytes.
fn parse_peak_rss_mb(status: &str) -> Option<f64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kibibytes * 1024.0 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processor_time_is_read_past_a_name_with_blanks() {
        let stat = "12 (a ) b) S 1 2 3 0 -1 4194304 100 0 0 0 250 50 0 0 20 0 3 0 100 1 2";
        assert_eq!(parse_cpu_seconds(stat), Some(3.0));
        assert_eq!(parse_cpu_seconds("12 (short) S 1"), None);
    }

    #[test]
    fn peak_memory_is_read_in_megabytes() {
        assert_eq!(parse_peak_rss_mb("VmPeak:\t  9 kB\nVmHWM:\t  2000 kB\n"), Some(2.048));
        assert_eq!(parse_peak_rss_mb("VmPeak:\t  9 kB\n"), None);
    }
}
