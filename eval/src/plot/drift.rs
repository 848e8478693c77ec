//! Translation and rotation drift by segment length or by speed, one curve per run.

use anyhow::{Result, ensure};

use super::axes::{Axes, Frame, Margin, colored, header, header_height, range};
use super::canvas::{Canvas, Figure, color};
use crate::drift::DriftBin;

/// What the horizontal axis shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriftAxis {
    /// Segment length, meters.
    Length,
    /// Speed, km/h.
    Speed,
}

/// Two panels, translation above rotation.
#[derive(Clone, Debug)]
pub struct DriftFigure {
    /// Title above the panels.
    pub title: String,
    /// Horizontal axis.
    pub axis: DriftAxis,
    /// Name and values of each curve.
    pub curves: Vec<(String, Vec<DriftBin>)>,
}

impl Figure for DriftFigure {
    fn size(&self) -> (u32, u32) {
        (800, 640 + header_height(800.0, self.names()) as u32)
    }

    fn draw(&self, canvas: &mut Canvas) -> Result<()> {
        let bins = || self.curves.iter().flat_map(|c| c.1.iter());
        ensure!(bins().next().is_some(), "no segments: no drift to draw");
        let first = header(canvas, 800.0, &self.title, &colored(self.names(), 2.5));
        let x = range(bins().map(|b| b.at), Margin::Both);
        let x_label = match self.axis {
            DriftAxis::Length => "segment length [m]",
            DriftAxis::Speed => "speed [km/h]",
        };
        self.draw_panel(canvas, first, x, (x_label, "translation error [%]"), |b| b.t_rel_percent);
        let second = first + 320.0;
        self.draw_panel(canvas, second, x, (x_label, "rotation error [deg/100 m]"), |b| b.r_rel_deg_per_100m);
        Ok(())
    }
}

impl DriftFigure {
    fn names(&self) -> impl Iterator<Item = &str> {
        self.curves.iter().map(|c| c.0.as_str())
    }

    fn draw_panel(
        &self,
        canvas: &mut Canvas,
        top: f64,
        x: (f64, f64),
        labels: (&str, &str),
        value: impl Fn(&DriftBin) -> f64,
    ) {
        let frame = Frame { left: 90.0, top, width: 685.0, height: 255.0 };
        let values = self.curves.iter().flat_map(|c| &c.1).map(&value);
        let axes = Axes { frame, x, y: range(values, Margin::FromZero) };
        axes.draw(canvas, labels.0, labels.1);
        for (i, (_, curve)) in self.curves.iter().enumerate() {
            let pixels: Vec<(f64, f64)> = curve.iter().map(|b| axes.at(b.at, value(b))).collect();
            canvas.line(&pixels, color(i), 2.5);
            for &pixel in &pixels {
                canvas.dot(pixel, 4.0, color(i));
            }
        }
    }
}
