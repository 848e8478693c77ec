//! The numbers of a run as a person reads them at its end.

use std::fmt::Write;
use std::path::Path;

use crate::summary::{Summary, WithoutPose};

/// Groups of frames without a pose that are printed; `summary.json` lists all frames.
const SHOWN_GROUPS: usize = 8;

/// The text that ends a run: what happened, errors, times, where the files are.
pub(crate) fn text(summary: &Summary, folder: &Path) -> String {
    let mut text = String::new();
    counts(&mut text, summary);
    submaps(&mut text, summary);
    errors(&mut text, summary);
    times(&mut text, summary);
    row(&mut text, "results", &folder.display().to_string());
    let picture = folder.join("trajectory.png");
    if picture.exists() {
        row(&mut text, "picture", &picture.display().to_string());
    }
    text
}

/// One row with a name; writing into a string cannot fail.
fn row(text: &mut String, name: &str, value: &str) {
    let _ = writeln!(text, "{name:<12}{value}");
}

fn counts(text: &mut String, s: &Summary) {
    let mut frames = format!("{} of {} with a pose", s.tracked, s.frames);
    let _ = write!(frames, ", {} lost, {} dropped", s.lost, s.dropped);
    if s.not_ready > 0 {
        let _ = write!(frames, ", {} before the map's start", s.not_ready);
    }
    if s.interrupted {
        frames.push_str(" (interrupted)");
    }
    row(text, "sequence", &format!("{} ({})", s.sequence, s.sensor));
    row(text, "frames", &frames);
    let groups = group(&s.without_pose);
    for group in groups.iter().take(SHOWN_GROUPS) {
        row(text, "", group);
    }
    if groups.len() > SHOWN_GROUPS {
        row(text, "", &format!("and {} more, see summary.json", groups.len() - SHOWN_GROUPS));
    }
    row(text, "map", &format!("{} keyframes, {} points", s.keyframes, s.points));
    row(text, "places", &places(s));
    if let Some(q) = s.quality {
        let (median, least, below) = (q.median, q.least, 100.0 * q.below_half);
        let value = format!("median {median:.2}, least {least:.2}, {below:.1} % of the poses below 0.5");
        row(text, "quality", &value);
    }
}

/// Loops, sub-maps and relocalizations.
fn places(s: &Summary) -> String {
    let mut places = format!("{} loops closed, {} rejected", s.loops, s.loops_rejected);
    if s.loops_taken_back > 0 {
        let _ = write!(places, ", {} taken back", s.loops_taken_back);
    }
    if s.relocalizations > 0 {
        let _ = write!(places, ", {} relocalizations", s.relocalizations);
    }
    if s.submaps > 1 || s.submaps_joined > 0 {
        let _ = write!(places, ", {} sub-maps ({} joined before)", s.submaps, s.submaps_joined);
    }
    places
}

/// One line for each of several sub-maps.
fn submaps(text: &mut String, s: &Summary) {
    for (i, submap) in s.per_submap.iter().enumerate() {
        let error = match (submap.ate_rmse_m, submap.path_m, &submap.evaluation_problem) {
            (Some(ate), Some(path), _) => format!(", ATE {ate:.4} m rmse, path {path:.1} m"),
            (_, _, Some(problem)) => format!(", error not computed: {problem}"),
            _ => String::new(),
        };
        let ends = [submap.first_frame, submap.last_frame].map(Option::unwrap_or_default);
        let line = format!(
            "{}: {} poses from frame {} to {}{error}",
            submap.submap, submap.tracked, ends[0], ends[1]
        );
        row(text, if i == 0 { "sub-maps" } else { "" }, &line);
    }
}

fn errors(text: &mut String, s: &Summary) {
    if let Some(problem) = &s.evaluation_problem {
        row(text, "error", &format!("not computed: {problem}"));
    }
    let (Some(ate), Some(alignment), Some(path)) = (s.ate_rmse_m, &s.alignment, s.path_m) else { return };
    let of = s
        .per_submap
        .first()
        .map_or(String::new(), |largest| format!(", of sub-map {} alone", largest.submap));
    row(text, "ATE", &format!("{ate:.4} m rmse ({alignment} alignment), path {path:.1} m{of}"));
    if let Some(scale) = s.scale_against_truth {
        row(text, "scale", &format!("estimated lengths are {scale:.4} times the true ones"));
    }
    if let Some(end) = s.end_error_percent {
        row(text, "drift", &format!("{end:.3} % of the path length at the end"));
    }
    match (s.t_rel_percent, s.r_rel_deg_per_100m) {
        (Some(t), Some(r)) => {
            let filled = match s.t_rel_filled_frames {
                None | Some(0) => String::new(),
                Some(n) => format!(" ({n} frames without a pose, filled with the last motion)"),
            };
            row(text, "t_rel r_rel", &format!("{t:.3} %  {r:.3} deg/100 m{filled}"));
        }
        _ => row(text, "t_rel r_rel", "not defined: no segment is long enough"),
    }
}

fn times(text: &mut String, s: &Summary) {
    let rate = s.frames as f64 / s.wall_s.max(1e-9);
    let cpu = s.cpu_s.map_or(String::new(), |cpu| format!(", {cpu:.1} s CPU time"));
    let memory = s.peak_rss_mb.map_or(String::new(), |mb| format!(", peak memory {mb:.0} MB"));
    row(text, "time", &format!("{:.1} s ({rate:.1} frames/s){cpu}{memory}", s.wall_s));
    if !s.stages.is_empty() {
        row(text, "stages", &format!("{:<20}{:>9}{:>9}{:>9}   {}", "ms", "median", "p95", "max", "calls"));
    }
    for (name, stage) in &s.stages {
        let (median, p95, max) = (stage.median, stage.p95, stage.max);
        row(text, "", &format!("{name:<20}{median:>9.2}{p95:>9.2}{max:>9.2}   {}", stage.calls));
    }
}

/// Neighboring frames of one state as one line: `frames 20 to 35 lost: <reason of the first>`.
fn group(frames: &[WithoutPose]) -> Vec<String> {
    let follows = |a: &WithoutPose, b: &WithoutPose| a.frame + 1 == b.frame && a.state == b.state;
    let line = |run: &[WithoutPose]| {
        let first = run.first()?;
        let state = first.state.replace('_', " ");
        Some(match run.len() {
            1 => format!("frame {} {state}: {}", first.frame, first.reason),
            n => {
                format!("frames {} to {} {state}: {}", first.frame, first.frame + n as u32 - 1, first.reason)
            }
        })
    };
    frames.chunk_by(follows).filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(frame: u32, state: &'static str) -> WithoutPose {
        WithoutPose { frame, state, reason: format!("reason {frame}") }
    }

    #[test]
    fn neighbors_of_one_state_are_one_line() {
        let frames = [frame(0, "not_ready"), frame(1, "not_ready"), frame(2, "dropped"), frame(9, "lost")];
        let expected =
            ["frames 0 to 1 not ready: reason 0", "frame 2 dropped: reason 2", "frame 9 lost: reason 9"];
        assert_eq!(group(&frames), expected);
    }
}
