//! Translation and rotation drift by segment length or by speed, one curve per run.

use anyhow::{Result, ensure};

use super::axes::{Axes, Frame, Margin, colored, header, header_height, range};
use super::canvas::{Canvas, color};
use crate::drift::DriftBin;

/// What the horizontal axis shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriftAxis {
    /// Segment length, meters.
    Length,
    /// Speed, km/h.
    Speed,
}

/// Two panels, translation above rotation; each curve has its name and its values.
///
/// # Errors
/// No segments.
pub fn drift(title: &str, axis: DriftAxis, curves: &[(String, Vec<DriftBin>)]) -> Result<Canvas> {
    let bins = || curves.iter().flat_map(|c| c.1.iter());
    ensure!(bins().next().is_some(), "no segments: no drift to draw");
    let names = || curves.iter().map(|c| c.0.as_str());
    let mut canvas = Canvas::new(800, 640 + header_height(800.0, names()) as u32)?;
    let first = header(&mut canvas, title, &colored(names(), 2.5));
    let x = range(bins().map(|b| b.at), Margin::Both);
    let x_label = match axis {
        DriftAxis::Length => "segment length [m]",
        DriftAxis::Speed => "speed [km/h]",
    };
    let mut panel = |top: f64, label: &str, value: fn(&DriftBin) -> f64| {
        let frame = Frame { left: 90.0, top, width: 685.0, height: 255.0 };
        let axes = Axes { frame, x, y: range(bins().map(value), Margin::FromZero) };
        axes.draw(&mut canvas, x_label, label);
        for (i, (_, curve)) in curves.iter().enumerate() {
            let pixels: Vec<(f64, f64)> = curve.iter().map(|b| axes.at(b.at, value(b))).collect();
            canvas.line(&pixels, color(i), 2.5);
            for &pixel in &pixels {
                canvas.dot(pixel, 4.0, color(i));
            }
        }
    };
    panel(first, "translation error [%]", |b| b.t_rel_percent);
    panel(first + 320.0, "rotation error [deg/100 m]", |b| b.r_rel_deg_per_100m);
    Ok(canvas)
}
