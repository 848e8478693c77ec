//! Bar chart of one figure per sequence: our configurations beside published baselines.

use anyhow::{Result, ensure};

use super::axes::{Axes, Frame, Margin, SMALL, colored, header, header_height, range};
use super::canvas::{Anchor, Canvas, Figure, INK, color};

/// Groups of bars.
#[derive(Clone, Debug)]
pub struct BarFigure {
    /// Title above the chart.
    pub title: String,
    /// Label of the vertical axis, with its unit.
    pub y_label: String,
    /// Name of each group (sequence).
    pub groups: Vec<String>,
    /// Name of each series and its value in each group; `None` leaves a gap.
    pub series: Vec<(String, Vec<Option<f64>>)>,
}

impl Figure for BarFigure {
    fn size(&self) -> (u32, u32) {
        (800, 400 + header_height(800.0, self.names()) as u32)
    }

    fn draw(&self, canvas: &mut Canvas) -> Result<()> {
        let values = || self.series.iter().flat_map(|s| s.1.iter().flatten().copied());
        ensure!(values().next().is_some() && !self.groups.is_empty(), "no values: nothing to draw");
        let top = header(canvas, 800.0, &self.title, &colored(self.names(), 10.0));
        let frame = Frame { left: 90.0, top, width: 685.0, height: 335.0 };
        let x = (0.0, self.groups.len() as f64);
        let axes = Axes { frame, x, y: range(values(), Margin::FromZero) };
        axes.draw_y(canvas, &self.y_label);
        let bar = 0.8 / self.series.len() as f64;
        for (g, group) in self.groups.iter().enumerate() {
            for (i, (_, series)) in self.series.iter().enumerate() {
                let Some(value) = series.get(g).copied().flatten() else { continue };
                let left = g as f64 + 0.1 + bar * i as f64;
                canvas.bar(axes.at(left, value), axes.at(left + 0.92 * bar, 0.0), color(i));
            }
            let (middle, bottom) = axes.at(g as f64 + 0.5, 0.0);
            self.group_name(canvas, group, middle, bottom + 18.0);
        }
        canvas.line(&[axes.at(0.0, 0.0), axes.at(x.1, 0.0)], INK, 1.5);
        Ok(())
    }
}

impl BarFigure {
    fn names(&self) -> impl Iterator<Item = &str> {
        self.series.iter().map(|s| s.0.as_str())
    }

    /// The group's name below its bars, small enough to fit.
    fn group_name(&self, canvas: &mut Canvas, name: &str, x: f64, y: f64) {
        let space = 685.0 / self.groups.len() as f64 - 4.0;
        let mut size = SMALL;
        while size > 8.0 && canvas.text_width(name, size) > space {
            size -= 1.0;
        }
        canvas.text(name, (x, y), size, Anchor::Center);
    }
}
