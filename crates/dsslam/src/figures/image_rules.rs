//! Rules that doubt what a few frames show: dark or blank images, depth, rows, disparities, the moment of the right image.

use geometry::Sensor;

use super::facts::Facts;
use super::lines::{short, spread_m};
use super::sight::{Look, Pairing};
use super::{Doubt, doubt};

/// Brightness below which an image is dark; streets at night have 20 and more.
const DARK: f64 = 10.0;
/// Corners below which an image is blank; a wall with a picture on it has more.
const MIN_CORNERS: usize = 60;
/// Median depth of a depth camera, meters: they see from 0.3 to 10 m, and rooms lie in between.
const RGBD_DEPTH_M: [f64; 2] = [0.25, 6.0];
/// 95 % of what a depth camera sees lie beyond the first, 5 % before the second, meters.
const RGBD_ENDS_M: [f64; 2] = [0.4, 3.0];
/// Median depth of two cameras, meters.
const STEREO_DEPTH_M: [f64; 2] = [0.1, 200.0];
const NO_DEPTH: &str = "the depth images hold no depth (0, or beyond the 32 m that are read where they are floats in meters: are they in \
                        millimeters?)";
/// Matches that tell something of a pair of images.
const MIN_MATCHES: usize = 60;
/// Share of matches that must lie on their row, and of those that make a common offset; rectified images have 0.9 and more.
const ON_ROW: f64 = 0.6;
/// Share of matches on their rows that makes two views of the halves of an image.
const ALIKE: f64 = 0.7;
/// How many times more matches a neighboring right image must have on the rows.
const BETTER: f64 = 1.3;
/// How many times more disparities must be negative than positive.
const SWAPPED: usize = 3;

/// All doubts of these rules.
pub(super) fn doubts(facts: &Facts) -> Vec<Doubt> {
    let sights = &facts.sights;
    let left: Vec<Look> = sights.iter().map(|sight| sight.left).collect();
    let right: Vec<Look> = sights.iter().filter_map(|sight| sight.right).collect();
    let left_name = if facts.sensor == Sensor::Stereo { "left" } else { "camera's" };
    let mut found: Vec<Doubt> = blank(left_name, &left).into_iter().chain(blank("right", &right)).collect();
    let is_blank = !found.is_empty();
    found.extend(depth(facts));
    found.extend(side_by_side(&sights.iter().filter_map(|sight| sight.halves.as_ref()).collect::<Vec<_>>()));
    let pairings: Vec<&Pairing> = sights.iter().filter_map(|sight| sight.pairing.as_ref()).collect();
    // What cannot be seen cannot be on the wrong row either.
    if !is_blank {
        found.extend(pairing(&pairings));
    }
    found
}

/// More than half of the frames looked at are dark or without corners.
fn blank(name: &str, looks: &[Look]) -> Option<Doubt> {
    let bad: Vec<&Look> =
        looks.iter().filter(|look| look.brightness < DARK || look.corners < MIN_CORNERS).collect();
    let worst = bad.iter().min_by_key(|look| look.corners)?;
    if 2 * bad.len() <= looks.len() {
        return None;
    }
    let what = if worst.brightness < DARK { "dark" } else { "blank" };
    let text = format!(
        "the {name} image is {what}: it has {} corners and a brightness of {:.0} of 255, {} of {} frames looked at are like that",
        worst.corners,
        worst.brightness,
        bad.len(),
        looks.len()
    );
    doubt("dark_or_blank", text)
}

fn depth(facts: &Facts) -> Option<Doubt> {
    let [least, most] = match facts.sensor {
        Sensor::Stereo => STEREO_DEPTH_M,
        Sensor::Rgbd => RGBD_DEPTH_M,
        Sensor::Mono => return None,
    };
    let is_rgbd = facts.sensor == Sensor::Rgbd;
    let n_depths: usize = facts.sights.iter().map(|sight| sight.depths_m.len()).sum();
    let Some([near, median, far]) = spread_m(&facts.sights).filter(|_| is_rgbd || n_depths >= MIN_MATCHES)
    else {
        let nothing = is_rgbd && !facts.sights.is_empty();
        return if nothing { doubt("depth", NO_DEPTH.to_owned()) } else { None };
    };
    let is_room = !is_rgbd || far >= RGBD_ENDS_M[0] && near <= RGBD_ENDS_M[1];
    if (least..=most).contains(&median) && is_room {
        return None;
    }
    let shown = short(median);
    let text = if is_rgbd {
        let units = facts.units_per_meter;
        format!(
            "the median depth seen is {shown} m with {units} units per meter, and 5 to 95 % lie between {} and {} m, which no depth \
             camera sees in a room: is camera.depth_units_per_metre right? Common are 1000 (millimeters) and 5000 (TUM, ICL-NUIM)",
            short(near),
            short(far)
        )
    } else {
        let baseline = short(facts.rig.stereo.baseline_m);
        format!(
            "the median depth seen is {shown} m with a baseline of {baseline} m, usual are {least} to {most} m: is the baseline right?"
        )
    };
    doubt("depth", text)
}

/// Both halves of the images of one camera show the same on the same rows.
fn side_by_side(halves: &[&Pairing]) -> Option<Doubt> {
    let (matches, on_row): (usize, usize) =
        (halves.iter().map(|p| p.matches).sum(), halves.iter().map(|p| p.on_row).sum());
    if matches < MIN_MATCHES || (on_row as f64) < ALIKE * matches as f64 {
        return None;
    }
    let text = format!(
        "the images hold two views side by side: {on_row} of {matches} corners of the left half are found again on their row in the right \
         half; the calibration of both cameras, for images of half the width, makes a stereo run of them"
    );
    doubt("side_by_side", text)
}

fn pairing(all: &[&Pairing]) -> Option<Doubt> {
    let sum = |of: fn(&Pairing) -> usize| all.iter().map(|pairing| of(pairing)).sum::<usize>();
    let (matches, on_row) = (sum(|p| p.matches), sum(|p| p.on_row));
    if all.is_empty() {
        return None;
    }
    if matches < MIN_MATCHES {
        let n = all.len();
        let text =
            format!("left and right images have little in common: {matches} matches in {n} frames looked at");
        return doubt("rows", text);
    }
    let share = on_row as f64 / matches as f64;
    if let Some(text) = late(all) {
        return doubt("right_late", text);
    }
    if share < ON_ROW {
        return doubt("rows", rows(all, share, matches, sum(|p| p.near_median)));
    }
    let (positive, negative) = (sum(|p| p.positive), sum(|p| p.negative));
    if negative > SWAPPED * positive {
        let text = format!(
            "{negative} of {} disparities are negative: the left and the right images are exchanged, or the baseline has the wrong sign",
            negative + positive
        );
        return doubt("swapped", text);
    }
    None
}

/// Most frames that tell agree better with a neighboring right image, always the same one.
fn late(all: &[&Pairing]) -> Option<String> {
    let told: Vec<(usize, [usize; 2])> = all.iter().filter_map(|p| Some((p.on_row, p.neighbors?))).collect();
    let own: usize = told.iter().map(|(own, _)| own).sum();
    let [before, after] =
        [0, 1].map(|side: usize| told.iter().map(|(_, beside)| beside[side]).sum::<usize>());
    let (side, beside) = if before > after { (0, before) } else { (1, after) };
    let is_better = |(own, all): &&(usize, [usize; 2])| all[side] as f64 > BETTER * *own as f64 + 20.0;
    if 2 * told.iter().filter(is_better).count() <= told.len() {
        return None;
    }
    let which = ["before", "after"][side];
    let lag = ["early", "late"][side];
    Some(format!(
        "the right images fit the left ones better one frame {which}: {beside} matches on their rows there, {own} here; the right camera is {lag}"
    ))
}

fn rows(all: &[&Pairing], share: f64, matches: usize, near_median: usize) -> String {
    let percent = 100.0 * share;
    let offsets: Vec<f64> = all.iter().map(|p| p.median_rows_px).collect();
    let mean = offsets.iter().sum::<f64>() / offsets.len() as f64;
    if near_median as f64 > ON_ROW * matches as f64 {
        return format!(
            "{percent:.0} % of {matches} matches lie on the same row of both images: the right one is {mean:+.1} px off; the calibration \
             is not that of these images, or left and right are exchanged"
        );
    }
    format!(
        "{percent:.0} % of {matches} matches lie on the same row of both images: they are not rectified, not of one moment, or the rotation \
         between the cameras is wrong (transposed?)"
    )
}
