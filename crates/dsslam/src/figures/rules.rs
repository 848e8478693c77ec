//! Rules that doubt calibration, times, ground truth and start map.

use features::Rig;
use geometry::{CameraModel, Sensor, Vec2};
use io::RawCamera;

use super::facts::{Facts, Times};
use super::lines::{field_of_view_deg, short};
use super::{Doubt, doubt};

/// Field of view across the longer side, degrees: beyond a long lens, and beyond what a pinhole model holds for.
const FIELD_OF_VIEW_DEG: [f64; 2] = [20.0, 140.0];
/// Focal lengths fx / fy: pixels are square to a few percent, and images that were stretched are not.
const PIXEL_SHAPE: [f64; 2] = [0.8, 1.25];
/// Distance of the principal point from the center, as a share of the side; KITTI-360's is 0.14.
const OFF_CENTER: f64 = 0.2;
/// Principal point times two over the image's size, alike in x and y to `ALIKE`, differing from 1 by this much: the intrinsics are those
/// of another size.
const OTHER_SIZE: f64 = 0.1;
const ALIKE: f64 = 0.03;
/// How far the middle of an edge may be moved by the lens, as a share of the width.
const LENS_SHIFT: f64 = 0.25;
/// Baselines of cameras on one carrier, meters.
const BASELINE_M: [f64; 2] = [0.001, 3.0];
/// Time between frames, seconds: more than a person would call a video, and faster than any camera here.
const STEP_S: [f64; 2] = [0.001, 5.0];
/// How far the camera of a map may be from that of the run: what is left of a calibration written with few digits.
const OTHER_CAMERA: f64 = 0.01;

/// All doubts of these rules.
pub(super) fn doubts(facts: &Facts) -> Vec<Doubt> {
    let mut found = Vec::new();
    let n = facts.cameras.len();
    for (i, camera) in facts.cameras.iter().enumerate() {
        let name = if n == 1 { "the camera" } else { ["the left camera", "the right camera"][i.min(1)] };
        found.extend(of_camera(camera, name));
    }
    found.extend(baseline(facts));
    if let Some(times) = &facts.times {
        found.extend(of_times(times));
        found.extend(truth(facts.with_truth, times.n));
    }
    found.extend(facts.map_rig.as_ref().and_then(|map| other_camera(map, &facts.rig, facts.sensor)));
    found
}

fn of_camera(camera: &RawCamera, name: &str) -> Vec<Doubt> {
    let (pinhole, size) = (camera.model.pinhole(), camera.size);
    let mut found = Vec::new();
    let fov = field_of_view_deg(camera).into_iter().fold(0.0, f64::max);
    let [least, most] = FIELD_OF_VIEW_DEG;
    if !matches!(camera.model, CameraModel::KannalaBrandt(_)) && !(least..=most).contains(&fov) {
        let text = format!(
            "{name} sees {fov:.1} deg, usual are {least} to {most}: focal length {:.1} px for {size} pixels",
            pinhole.fx
        );
        found.extend(doubt("field_of_view", text));
    }
    let shape = pinhole.fx / pinhole.fy;
    if !(PIXEL_SHAPE[0]..=PIXEL_SHAPE[1]).contains(&shape) {
        let text = format!(
            "focal lengths of {name} are {:.1} and {:.1} px, usual are equal ones",
            pinhole.fx, pinhole.fy
        );
        found.extend(doubt("pixel_shape", text));
    }
    found.extend(principal_point(camera, name));
    found.extend(lens_of(camera, name));
    found
}

fn principal_point(camera: &RawCamera, name: &str) -> Option<Doubt> {
    let (pinhole, size) = (camera.model.pinhole(), camera.size);
    let (width, height) = (size.width as f64, size.height as f64);
    let (x, y) = (pinhole.cx / width, pinhole.cy / height);
    let place = format!(
        "principal point ({:.1}, {:.1}) of {name}, whose images have {size} pixels",
        pinhole.cx, pinhole.cy
    );
    let factor = x + y;
    if (x - y).abs() < ALIKE * factor && (factor - 1.0).abs() > OTHER_SIZE {
        let text = format!(
            "{place}, is the center of about {:.0}x{:.0} pixels: the intrinsics are those of another image size",
            2.0 * pinhole.cx,
            2.0 * pinhole.cy
        );
        return doubt("other_size", text);
    }
    if !(0.0..=1.0).contains(&x) || !(0.0..=1.0).contains(&y) {
        return doubt("principal_point", format!("{place}, lies outside of them"));
    }
    let far = (x - 0.5).abs().max((y - 0.5).abs()) > OFF_CENTER;
    if far { doubt("principal_point", format!("{place}, lies far from their center")) } else { None }
}

/// The lens must be invertible on the middle of each edge, and move it moderately.
fn lens_of(camera: &RawCamera, name: &str) -> Option<Doubt> {
    let CameraModel::Pinhole { camera: pinhole, distortion: lens } = &camera.model else { return None };
    let (width, height) = (camera.size.width as f64, camera.size.height as f64);
    let middles = [(0.0, 0.5), (1.0, 0.5), (0.5, 0.0), (0.5, 1.0)];
    let (mut shift_px, mut miss_px) = (0.0_f64, 0.0_f64);
    for (x, y) in middles {
        let pixel = Vec2::new(x * width, y * height);
        let distorted = pinhole.unproject(&pixel).xy();
        let ideal = lens.undistort(&distorted);
        shift_px = shift_px.max((pinhole.project(&ideal.push(1.0)) - pixel).norm());
        miss_px = miss_px.max((lens.distort(&ideal) - distorted).norm() * pinhole.fx);
    }
    let (k1, k2) = (lens.k1, lens.k2);
    if miss_px > 1.0 {
        let text = format!(
            "the distortion of {name} (k1 {k1}, k2 {k2}, ...) cannot be inverted at the image's edge: wrong order or model?"
        );
        return doubt("lens", text);
    }
    if shift_px > LENS_SHIFT * width {
        let text = format!(
            "the distortion of {name} (k1 {k1}, k2 {k2}, ...) moves the image's edge by {shift_px:.0} px: wrong order or model?"
        );
        return doubt("lens", text);
    }
    None
}

fn baseline(facts: &Facts) -> Option<Doubt> {
    let (baseline, [least, most]) = (facts.rig.stereo.baseline_m, BASELINE_M);
    if facts.sensor == Sensor::Mono || (least..=most).contains(&baseline) {
        return None;
    }
    let unit = if baseline > most { "millimeters or pixels" } else { "kilometers" };
    let shown = short(baseline);
    doubt("baseline", format!("the baseline is {shown} m, usual are {least} to {most}: is it in {unit}?"))
}

fn of_times(times: &Times) -> Vec<Doubt> {
    let mut found = Vec::new();
    if times.are_invented && times.n > 1 {
        let text = "no file gives the times of the images: they are invented from the frame rate (camera.fps, or fps of the calibration)";
        found.extend(doubt("invented_times", text.to_owned()));
    }
    let Some(step) = times.step_s else { return found };
    let [least, most] = STEP_S;
    let unit = match step {
        _ if step > 5e6 => "they look like nanoseconds",
        _ if step > 5e3 => "they look like microseconds",
        _ if step > most => "they look like milliseconds",
        _ if step < least => "is the unit right?",
        _ => return found,
    };
    let text = format!(
        "frames are {} s apart, usual are {least} to {most}; expected are seconds: {unit}",
        short(step)
    );
    found.extend(doubt("times", text));
    found
}

fn truth(with_truth: Option<usize>, n: usize) -> Option<Doubt> {
    let found = with_truth?;
    if n == 0 || 2 * found >= n {
        return None;
    }
    let text = format!(
        "the ground truth has a pose at the time of {found} of {n} frames only: other clock, other unit, other sequence?"
    );
    doubt("ground_truth", text)
}

fn other_camera(map: &Rig, run: &Rig, sensor: Sensor) -> Option<Doubt> {
    let [map_camera, run_camera] = [map, run].map(|rig| rig.stereo.camera);
    let is_off = |a: f64, b: f64, unit: f64| (a - b).abs() > OTHER_CAMERA * unit;
    let has_baseline = sensor == Sensor::Stereo;
    let (width, height) = (run.width as f64, run.height as f64);
    let differs = (map.width, map.height) != (run.width, run.height)
        || is_off(map_camera.fx, run_camera.fx, run_camera.fx)
        || is_off(map_camera.fy, run_camera.fy, run_camera.fy)
        || is_off(map_camera.cx, run_camera.cx, width)
        || is_off(map_camera.cy, run_camera.cy, height)
        || has_baseline && is_off(map.stereo.baseline_m, run.stereo.baseline_m, run.stereo.baseline_m);
    let words = |rig: &Rig| {
        let camera = &rig.stereo.camera;
        let baseline = if has_baseline {
            format!(", baseline {} m", short(rig.stereo.baseline_m))
        } else {
            String::new()
        };
        format!(
            "{}x{} pixels, focal length {:.1} x {:.1} px, principal point ({:.1}, {:.1}){baseline}",
            rig.width, rig.height, camera.fx, camera.fy, camera.cx, camera.cy
        )
    };
    if differs {
        let text = format!(
            "the start map was made with another camera ({}) than this run has ({})",
            words(map),
            words(run)
        );
        return doubt("other_camera", text);
    }
    None
}
