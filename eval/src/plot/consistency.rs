//! Normalized errors squared over the frames, with the bounds that 95 % of them should lie within.

use anyhow::{Result, ensure};

use super::axes::{Axes, Frame, Key, header};
use super::canvas::{Canvas, Figure, INK, PALETTE};
use crate::consistency::{Consistency, NEES_BOUNDS};

/// Values beyond are drawn at the edges.
const RANGE: [f64; 2] = [0.1, 1000.0];

/// A dot per motion, on a logarithmic axis.
#[derive(Clone, Debug)]
pub struct ConsistencyFigure {
    /// Title above.
    pub title: String,
    /// The errors.
    pub consistency: Consistency,
}

impl Figure for ConsistencyFigure {
    fn size(&self) -> (u32, u32) {
        (800, 420)
    }

    fn draw(&self, canvas: &mut Canvas) -> Result<()> {
        let Consistency { nees, mean, inside, .. } = &self.consistency;
        let (Some(first), Some(last)) = (nees.first(), nees.last()) else {
            ensure!(!nees.is_empty(), "no motion has a covariance: nothing to draw");
            return Ok(());
        };
        let (width, height) = (800.0, 420.0);
        let names = [format!("NEES, mean {mean:.2}"), format!("95 % bounds, {:.0} % within", 100.0 * inside)];
        let keys = [
            Key { text: &names[0], color: PALETTE[1], width: 4.0 },
            Key { text: &names[1], color: INK, width: 1.5 },
        ];
        let top = header(canvas, width, &self.title, &keys);
        let axes = Axes {
            frame: Frame { left: 90.0, top, width: width - 115.0, height: height - top - 55.0 },
            x: (f64::from(first.0) - 1.0, f64::from(last.0) + 1.0),
            y: (RANGE[0].log10(), RANGE[1].log10()),
        };
        axes.draw(canvas, "frame", "log10 of NEES (6 degrees of freedom)");
        for bound in NEES_BOUNDS {
            canvas.line(&[axes.at(axes.x.0, bound.log10()), axes.at(axes.x.1, bound.log10())], INK, 1.5);
        }
        for &(frame, value) in nees {
            let shown = value.clamp(RANGE[0], RANGE[1]).log10();
            canvas.dot(axes.at(f64::from(frame), shown), 2.5, PALETTE[1]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::svg;

    #[test]
    fn a_dot_for_each_motion_and_two_bounds() {
        let nees = vec![(10, 6.0), (11, 0.001), (12, 1e9)];
        let consistency = Consistency {
            nees,
            mean: 5.5,
            median: 6.0,
            inside: 0.9,
            above: 0.1,
            below: 0.0,
            per_axis: [1.0; 6],
        };
        let mut figure = ConsistencyFigure { title: "town".to_owned(), consistency };
        let text = svg(&figure).unwrap();
        assert_eq!(text.matches("<circle").count(), 3);
        assert!(text.contains("NEES, mean 5.50") && text.contains("90 % within"));
        figure.consistency.nees.clear();
        assert!(svg(&figure).unwrap_err().to_string().contains("nothing to draw"));
    }
}
