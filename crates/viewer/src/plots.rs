//! Curves over time, with colors that can be told apart.

use std::collections::BTreeMap;

use draw::PALETTE;
use rerun::{RecordingStream, RecordingStreamResult, Scalars, SeriesLines};

use crate::colors::color;

/// Width of curves, points of the user interface.
const WIDTH: f32 = 1.5;

/// Knows which curves there are.
#[derive(Debug, Default)]
pub(crate) struct Plots {
    /// Names of curves by the plot that they are in, in the order of their first points.
    curves: BTreeMap<&'static str, Vec<String>>,
}

impl Plots {
    /// Adds a point to a curve of a plot, at the time of the recording.
    ///
    /// # Errors
    /// Those of the recording.
    pub(crate) fn add(
        &mut self,
        plot: &'static str,
        name: &str,
        value: f64,
        to: &RecordingStream,
    ) -> RecordingStreamResult<()> {
        let entity = format!("{plot}/{name}");
        let curves = self.curves.entry(plot).or_default();
        if !curves.iter().any(|curve| curve == name) {
            let color = color(PALETTE[curves.len() % PALETTE.len()]);
            let style = SeriesLines::new().with_colors([color]).with_names([name]).with_widths([WIDTH]);
            to.log_static(entity.as_str(), &style)?;
            curves.push(name.to_owned());
        }
        to.log(entity, &Scalars::single(value))
    }
}
