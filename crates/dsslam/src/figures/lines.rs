//! The figures in words, one line each.

use geometry::{CameraModel, Sensor};
use io::RawCamera;

use super::Figure;
use super::facts::{Facts, Times, camera_of};
use super::sight::Sight;

/// Camera, lens, baseline or depth, images, times, layout, ground truth.
pub(super) fn lines(facts: &Facts) -> Vec<Figure> {
    let line = |name, text| Figure { name, text };
    let mut lines = vec![line("camera", camera(facts)), line("distortion", distortion(facts)), scale(facts)];
    lines.extend((!facts.sights.is_empty()).then(|| line("images", images(&facts.sights))));
    lines.push(line("times", facts.times.as_ref().map_or("of a stream".to_owned(), times)));
    let Facts { layout, sensor, source, .. } = facts;
    lines.push(line("layout", format!("{layout}, sensor {sensor}; calibration from {source}")));
    lines.extend(facts.with_truth.map(|found| {
        let n = facts.times.as_ref().map_or(0, |times| times.n);
        line("ground truth", format!("poses for {found} of {n} frames"))
    }));
    lines
}

fn camera(facts: &Facts) -> String {
    let camera = camera_of(&facts.rig);
    let (pinhole, size, [across, down]) = (camera.model.pinhole(), camera.size, field_of_view_deg(&camera));
    format!(
        "{size} pixels, focal length {:.1} x {:.1} px, field of view {across:.0} x {down:.0} deg, principal point ({:.1}, {:.1})",
        pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy
    )
}

/// Angles that a pinhole camera sees across and down, degrees.
pub(super) fn field_of_view_deg(camera: &RawCamera) -> [f64; 2] {
    let angle = |focal: f64, center: f64, side: usize| {
        ((center / focal).atan() + ((side as f64 - center) / focal).atan()).to_degrees()
    };
    let (pinhole, size) = (camera.model.pinhole(), camera.size);
    [angle(pinhole.fx, pinhole.cx, size.width), angle(pinhole.fy, pinhole.cy, size.height)]
}

fn distortion(facts: &Facts) -> String {
    let model = match facts.cameras.first().map(|camera| camera.model) {
        Some(CameraModel::KannalaBrandt(_)) => "fisheye".to_owned(),
        Some(CameraModel::Rational(_)) => "rational, eight coefficients".to_owned(),
        Some(CameraModel::Pinhole { distortion: d, .. }) if !d.is_zero() => {
            format!("k1 {} k2 {} p1 {} p2 {} k3 {}", d.k1, d.k2, d.p1, d.p2, d.k3)
        }
        _ => "none".to_owned(),
    };
    if facts.is_rectified { format!("{model}; the images are rectified") } else { model }
}

fn scale(facts: &Facts) -> Figure {
    let seen = match spread_m(&facts.sights) {
        Some([near, median, far]) => {
            format!("median depth seen {} m (5 to 95 %: {} to {} m)", short(median), short(near), short(far))
        }
        None => "no depth seen".to_owned(),
    };
    let baseline = short(facts.rig.stereo.baseline_m);
    match facts.sensor {
        Sensor::Stereo => Figure { name: "baseline", text: format!("{baseline} m; {seen}") },
        Sensor::Rgbd => {
            let text =
                format!("{} units per meter; {seen}; virtual baseline {baseline} m", facts.units_per_meter);
            Figure { name: "depth", text }
        }
        Sensor::Mono => Figure { name: "scale", text: "free, as of every single camera".to_owned() },
    }
}

/// Depths that 5, 50 and 95 % of what was seen lie below, meters.
pub(super) fn spread_m(sights: &[Sight]) -> Option<[f64; 3]> {
    let mut depths: Vec<f64> = sights.iter().flat_map(|sight| sight.depths_m.iter().copied()).collect();
    depths.sort_by(f64::total_cmp);
    let last = depths.len().checked_sub(1)?;
    Some([5, 50, 95].map(|percent| depths[last * percent / 100]))
}

/// A length with three digits that count.
pub(super) fn short(value: f64) -> String {
    let decimals = if value == 0.0 { 0.0 } else { (2.0 - value.abs().log10().floor()).clamp(0.0, 6.0) };
    format!("{value:.0$}", decimals as usize)
}

fn images(sights: &[Sight]) -> String {
    let mean = |value: fn(&Sight) -> Option<f64>| {
        let values: Vec<f64> = sights.iter().filter_map(value).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let side = |name: &str, brightness: Option<f64>, corners: Option<f64>| {
        let (brightness, corners) = brightness.zip(corners)?;
        Some(format!("{name} image of brightness {brightness:.0} with {corners:.0} corners"))
    };
    let mut parts = vec![format!("{} frames looked at", sights.len())];
    parts.extend(side("left", mean(|s| Some(s.left.brightness)), mean(|s| Some(s.left.corners as f64))));
    parts.extend(side("right", mean(|s| Some(s.right?.brightness)), mean(|s| Some(s.right?.corners as f64))));
    parts.extend(
        mean(|s| s.pairing.as_ref().map(|pairing| 100.0 * pairing.share()))
            .map(|share| format!("{share:.0} % of their matches on the same row")),
    );
    parts.extend(
        mean(|s| s.with_depth).map(|share| format!("{:.0} % of the pixels with a depth", 100.0 * share)),
    );
    parts.join(", ")
}

fn times(times: &Times) -> String {
    let mut text = format!("{} frames in {} s", times.n, short(times.span_s));
    if let Some(step) = times.step_s.filter(|&step| step > 0.0) {
        text += &format!(", {} frames/s, longest gap {} s", short(1.0 / step), short(times.longest_step_s));
    }
    if times.are_invented { text + "; invented from the frame rate" } else { text }
}
