//! Bar chart of one figure per sequence: our configurations beside published baselines.

use anyhow::{Result, ensure};

use super::axes::{Axes, Frame, Margin, SMALL, colored, header, header_height, range};
use super::canvas::{Anchor, Canvas, INK, color};

/// Groups of bars (sequences). Each series has its name and its value in each group; `None` leaves a gap. `y_label` has the unit.
///
/// # Errors
/// No value.
pub fn bars(
    title: &str,
    y_label: &str,
    groups: &[String],
    series: &[(String, Vec<Option<f64>>)],
) -> Result<Canvas> {
    let values = || series.iter().flat_map(|s| s.1.iter().flatten().copied());
    ensure!(values().next().is_some() && !groups.is_empty(), "no values: nothing to draw");
    let names = || series.iter().map(|s| s.0.as_str());
    let mut canvas = Canvas::new(800, 400 + header_height(800.0, names()) as u32)?;
    let top = header(&mut canvas, title, &colored(names(), 10.0));
    let frame = Frame { left: 90.0, top, width: 685.0, height: 335.0 };
    let x = (0.0, groups.len() as f64);
    let axes = Axes { frame, x, y: range(values(), Margin::FromZero) };
    axes.draw_y(&mut canvas, y_label);
    let bar = 0.8 / series.len() as f64;
    for (g, group) in groups.iter().enumerate() {
        for (i, (_, series)) in series.iter().enumerate() {
            let Some(value) = series.get(g).copied().flatten() else { continue };
            let left = g as f64 + 0.1 + bar * i as f64;
            canvas.bar(axes.at(left, value), axes.at(left + 0.92 * bar, 0.0), color(i));
        }
        let (middle, bottom) = axes.at(g as f64 + 0.5, 0.0);
        group_name(&mut canvas, group, 685.0 / groups.len() as f64 - 4.0, (middle, bottom + 18.0));
    }
    canvas.line(&[axes.at(0.0, 0.0), axes.at(x.1, 0.0)], INK, 1.5);
    Ok(canvas)
}

/// The group's name below its bars, small enough to fit into the space.
fn group_name(canvas: &mut Canvas, name: &str, space: f64, at: (f64, f64)) {
    let mut size = SMALL;
    while size > 8.0 && canvas.text_width(name, size) > space {
        size -= 1.0;
    }
    canvas.text(name, at, size, Anchor::Center);
}
