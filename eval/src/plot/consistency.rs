//! Normalized errors squared over the frames, with the bounds that 95 % of them should lie within.

use anyhow::{Context, Result};

use super::axes::{Axes, Frame, Key, header};
use super::canvas::{Canvas, INK, PALETTE};
use crate::consistency::{Consistency, NEES_BOUNDS};

/// Values beyond are drawn at the edges.
const RANGE: [f64; 2] = [0.1, 1000.0];

/// A dot per motion, on a logarithmic axis.
///
/// # Errors
/// No motion.
pub fn consistency(title: &str, found: &Consistency) -> Result<Canvas> {
    let Consistency { nees, mean, inside, .. } = found;
    let (first, last) =
        nees.first().zip(nees.last()).context("no motion has a covariance: nothing to draw")?;
    let names = [format!("NEES, mean {mean:.2}"), format!("95 % bounds, {:.0} % within", 100.0 * inside)];
    let keys = [
        Key { text: &names[0], color: PALETTE[1], width: 4.0 },
        Key { text: &names[1], color: INK, width: 1.5 },
    ];
    let mut canvas = Canvas::new(800, 420)?;
    let top = header(&mut canvas, title, &keys);
    let axes = Axes {
        frame: Frame::below(top, &canvas),
        x: (f64::from(first.0) - 1.0, f64::from(last.0) + 1.0),
        y: (RANGE[0].log10(), RANGE[1].log10()),
    };
    axes.draw(&mut canvas, "frame", "log10 of NEES (6 degrees of freedom)");
    for bound in NEES_BOUNDS {
        canvas.line(&[axes.at(axes.x.0, bound.log10()), axes.at(axes.x.1, bound.log10())], INK, 1.5);
    }
    for &(frame, value) in nees {
        let shown = value.clamp(RANGE[0], RANGE[1]).log10();
        canvas.dot(axes.at(f64::from(frame), shown), 2.5, PALETTE[1]);
    }
    Ok(canvas)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::svg;

    #[test]
    fn a_dot_for_each_motion_and_two_bounds() {
        let nees = vec![(10, 6.0), (11, 0.001), (12, 1e9)];
        let mut found = Consistency {
            nees,
            mean: 5.5,
            median: 6.0,
            inside: 0.9,
            above: 0.1,
            below: 0.0,
            per_axis: [1.0; 6],
        };
        let text = svg(&consistency("town", &found).unwrap()).unwrap();
        assert_eq!(text.matches("<circle").count(), 3);
        assert!(text.contains("NEES, mean 5.50") && text.contains("90 % within"));
        found.nees.clear();
        assert!(consistency("town", &found).err().unwrap().to_string().contains("nothing to draw"));
    }
}
