//! Estimated trajectory over ground truth, from above and from the side, with equal axes.

use anyhow::{Result, ensure};
use geometry::Vec3;
use plotters::style::RGBColor;

use super::axes::{Axes, Frame, Key, Margin, header, range};
use super::canvas::{Canvas, INK, PALETTE};

/// Above this extent (meters) a trajectory is a car's: its map is the x-z plane of the first camera.
const OUTDOORS_M: f64 = 60.0;
/// Exaggerations of height that may be chosen in the side view.
const EXAGGERATIONS: [f64; 6] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0];

/// Side from which trajectories are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// Onto the plane of motion: x-z of KITTI's camera frame, else the two axes of largest extent.
    Top,
    /// Height over the longer axis of the top view, exaggerated by a stated factor.
    Side,
}

/// Three axes of the world: two of the map and the height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Projection {
    right: usize,
    up: usize,
    height: usize,
    /// The one of `right` and `up` with the larger extent.
    along: usize,
}

impl Projection {
    /// Chosen by the extents in x, y and z, meters. A long path, or one that leads mostly along z, is that of a forward-looking
    /// camera whose y axis points down.
    fn of(extents: [f64; 3]) -> Projection {
        let [x, y, z] = extents;
        let is_long = x.max(y).max(z) > OUTDOORS_M && y < 0.5 * z.max(x);
        let is_straight_ahead = z > 2.0 * x.max(y);
        let height = if is_long || is_straight_ahead {
            1
        } else {
            (0..3).min_by(|&a, &b| extents[a].total_cmp(&extents[b])).unwrap_or(2)
        };
        let (right, up) = match height {
            0 => (1, 2),
            1 => (0, 2),
            _ => (0, 1),
        };
        let along = if extents[up] > extents[right] { up } else { right };
        Projection { right, up, height, along }
    }
}

/// An estimate over its ground truth: estimated positions in the world of the ground truth, meters, with gaps where frames are lost; true
/// positions, meters, of which there may be none.
///
/// # Errors
/// No position, or one that is not finite.
pub fn trajectory(
    title: &str,
    estimate: &[Option<Vec3>],
    ground_truth: &[Vec3],
    view: View,
) -> Result<Canvas> {
    let paths = Paths { estimate, ground_truth };
    ensure!(paths.all().next().is_some(), "no positions to draw");
    ensure!(paths.all().all(|p| p.iter().all(|v| v.is_finite())), "a position is not a finite number");
    let keys = [
        Key { text: "ground truth", color: INK, width: 5.0 },
        Key { text: "estimate", color: PALETTE[0], width: 2.5 },
    ];
    let shown = if ground_truth.is_empty() { &keys[1..] } else { &keys[..] };
    let mut canvas = Canvas::new(800, if view == View::Top { 760 } else { 360 })?;
    let top = header(&mut canvas, title, shown);
    let frame = Frame::below(top, &canvas);
    let p = paths.projection();
    let name = |axis: usize| ["x", "y", "z"][axis];
    match view {
        View::Top => {
            let to_plane = |v: &Vec3| (v[p.right], v[p.up]);
            let axes = paths.axes(frame, &to_plane);
            axes.draw(&mut canvas, &format!("{} [m]", name(p.right)), &format!("{} [m]", name(p.up)));
            paths.draw(&mut canvas, &axes, &to_plane);
        }
        View::Side => {
            // A camera's y axis points down: height is -y.
            let sign = if p.height == 1 { -1.0 } else { 1.0 };
            let factor = paths.exaggeration(&p, frame);
            let to_plane = |v: &Vec3| (v[p.along], sign * factor * v[p.height]);
            let flat = paths.axes(frame, &to_plane);
            let axes = Axes { y: (flat.y.0 / factor, flat.y.1 / factor), ..flat };
            let minus = if sign < 0.0 { "-" } else { "" };
            let label = match factor {
                1.0 => format!("{minus}{} [m]", name(p.height)),
                _ => format!("{minus}{} [m], drawn {factor}x", name(p.height)),
            };
            axes.draw(&mut canvas, &format!("{} [m]", name(p.along)), &label);
            paths.draw(&mut canvas, &axes, &|v: &Vec3| (v[p.along], sign * v[p.height]));
        }
    }
    Ok(canvas)
}

#[derive(Clone, Copy)]
struct Paths<'a> {
    estimate: &'a [Option<Vec3>],
    ground_truth: &'a [Vec3],
}

impl<'a> Paths<'a> {
    fn all(self) -> impl Iterator<Item = &'a Vec3> {
        self.ground_truth.iter().chain(self.estimate.iter().flatten())
    }

    /// Axes of the drawing, chosen by the ground truth (by the estimate where there is none).
    fn projection(self) -> Projection {
        let n = if self.ground_truth.is_empty() { usize::MAX } else { self.ground_truth.len() };
        let extent = |axis: usize| {
            let (low, high) = range(self.all().take(n).map(|p| p[axis]), Margin::Tight);
            high - low
        };
        Projection::of([extent(0), extent(1), extent(2)])
    }

    fn axes(self, frame: Frame, to_plane: &impl Fn(&Vec3) -> (f64, f64)) -> Axes {
        let x = range(self.all().map(|v| to_plane(v).0), Margin::Both);
        let y = range(self.all().map(|v| to_plane(v).1), Margin::Both);
        Axes::equal(frame, x, y)
    }

    /// Largest exaggeration of height that still lets the whole width decide the scale.
    fn exaggeration(self, p: &Projection, frame: Frame) -> f64 {
        let x = range(self.all().map(|v| v[p.along]), Margin::Both);
        let y = range(self.all().map(|v| v[p.height]), Margin::Both);
        let free = (x.1 - x.0) / frame.width * frame.height / (y.1 - y.0);
        EXAGGERATIONS.iter().copied().rfind(|&e| e <= free).unwrap_or(1.0)
    }

    fn draw(self, canvas: &mut Canvas, axes: &Axes, to_plane: &impl Fn(&Vec3) -> (f64, f64)) {
        let at = |v: &Vec3| {
            let (x, y) = to_plane(v);
            axes.at(x, y)
        };
        canvas.line(&self.ground_truth.iter().map(at).collect::<Vec<_>>(), INK, 5.0);
        for run in self.estimate.split(Option::is_none).filter(|run| !run.is_empty()) {
            canvas.line(&run.iter().flatten().map(at).collect::<Vec<_>>(), PALETTE[0], 2.5);
        }
        if let Some(start) = self.all().next() {
            canvas.dot(at(start), 7.0, INK);
            canvas.dot(at(start), 4.0, RGBColor(255, 255, 255));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(extents: [f64; 3]) -> [usize; 4] {
        let p = Projection::of(extents);
        [p.right, p.up, p.height, p.along]
    }

    #[test]
    fn a_drive_is_seen_from_above_however_short_and_straight() {
        assert_eq!(axes([560.0, 26.0, 500.0]), [0, 2, 1, 0]);
        assert_eq!(axes([30.0, 6.0, 400.0]), [0, 2, 1, 2]);
        assert_eq!(
            axes([1.0, 1.2, 60.0]),
            [0, 2, 1, 2],
            "51 frames of KITTI 06: less to the right than down"
        );
    }

    #[test]
    fn in_a_room_the_smallest_extent_is_the_height() {
        assert_eq!(axes([4.0, 5.0, 1.0]), [0, 1, 2, 1]);
        assert_eq!(axes([5.0, 0.5, 4.0]), [0, 2, 1, 0]);
        assert_eq!(axes([0.5, 3.0, 2.0]), [1, 2, 0, 1]);
    }
}
