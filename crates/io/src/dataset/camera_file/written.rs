//! A calibration in our own format, whatever it was read from.

use std::fmt::Write;

use geometry::{CameraModel, Distortion, KannalaBrandt, Rational};

use super::CameraFile;
use crate::document::listed;

impl CameraFile {
    /// The calibration as YAML that [`super::read_calibration`] reads again; the notes stand in comments.
    pub fn to_yaml(&self) -> String {
        let mut text = format!("# {}, read as {}\n", self.path.display(), self.format);
        // Writing to a string cannot fail.
        for note in &self.notes {
            let _ = writeln!(text, "# {}", note.replace(['\n', '\r'], " "));
        }
        for (key, value) in [
            ("fps", self.frame_rate_hz),
            ("depth_units_per_metre", self.depth_units_per_metre),
            ("baseline_m", self.baseline_m),
        ] {
            let _ = value.map(|value| writeln!(text, "{key}: {value}"));
        }
        text.push_str("cameras:\n");
        for camera in &self.cameras {
            let (model, coefficients) = lens(&camera.model);
            let pinhole = camera.model.pinhole();
            let _ = writeln!(text, "  - model: {model}");
            if let Some(size) = camera.size {
                let _ = writeln!(text, "    resolution: [{}, {}]", size.width, size.height);
            }
            let numbers = [pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy];
            let _ = writeln!(text, "    intrinsics: {}", listed(&numbers));
            if !coefficients.is_empty() {
                let _ = writeln!(text, "    distortion: {}", listed(&coefficients));
            }
        }
        if let [left, right] = &self.cameras[..] {
            let right_from_left = right.body_from_cam.inverse() * left.body_from_cam;
            text.push_str("right_from_left:  # x_right = R x_left + t, meters\n");
            for row in right_from_left.rows_3x4().chunks(4) {
                let _ = writeln!(text, "  - {}", listed(row));
            }
        }
        text
    }
}

/// The lens in our words.
fn lens(model: &CameraModel) -> (&'static str, Vec<f64>) {
    match *model {
        CameraModel::Pinhole { distortion, .. } if distortion.is_zero() => ("none", Vec::new()),
        CameraModel::Pinhole { distortion: Distortion { k1, k2, p1, p2, k3 }, .. } => {
            ("pinhole-radtan", vec![k1, k2, p1, p2, k3])
        }
        CameraModel::KannalaBrandt(KannalaBrandt { k1, k2, k3, k4, .. }) => {
            ("kannala-brandt", vec![k1, k2, k3, k4])
        }
        CameraModel::Rational(Rational {
            upper: Distortion { k1, k2, p1, p2, k3 },
            lower: [k4, k5, k6],
            ..
        }) => ("rational_polynomial", vec![k1, k2, p1, p2, k3, k4, k5, k6]),
    }
}
