//! Estimated trajectory over ground truth, from above and from the side, with equal axes.

use anyhow::{Result, ensure};
use geometry::Vec3;
use plotters::style::RGBColor;

use super::axes::{Axes, Frame, Key, Margin, header, range};
use super::canvas::{Canvas, Figure, INK, PALETTE};

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

/// Drawing of an estimate over its ground truth.
#[derive(Clone, Debug)]
pub struct TrajectoryFigure {
    /// Title above the plot.
    pub title: String,
    /// Estimated positions, in the world of the ground truth, meters; `None` leaves a gap (lost frames).
    pub estimate: Vec<Option<Vec3>>,
    /// True positions, meters; may be empty.
    pub ground_truth: Vec<Vec3>,
    /// Side from which to look.
    pub view: View,
}

impl TrajectoryFigure {
    fn all(&self) -> impl Iterator<Item = &Vec3> {
        self.ground_truth.iter().chain(self.estimate.iter().flatten())
    }

    /// Axes of the drawing, chosen by the ground truth (by the estimate where there is none).
    fn projection(&self) -> Projection {
        let reference: Vec<Vec3> = if self.ground_truth.is_empty() {
            self.estimate.iter().flatten().copied().collect()
        } else {
            self.ground_truth.clone()
        };
        let extent = |axis: usize| {
            let (low, high) = range(reference.iter().map(|p| p[axis]), Margin::Tight);
            high - low
        };
        Projection::of([extent(0), extent(1), extent(2)])
    }

    fn runs(&self, to_plane: impl Fn(&Vec3) -> (f64, f64)) -> Vec<Vec<(f64, f64)>> {
        let mut runs = vec![Vec::new()];
        for position in &self.estimate {
            match (position, runs.last_mut()) {
                (Some(p), Some(run)) => run.push(to_plane(p)),
                (None, Some(run)) if !run.is_empty() => runs.push(Vec::new()),
                _ => {}
            }
        }
        runs
    }
}

impl Figure for TrajectoryFigure {
    fn size(&self) -> (u32, u32) {
        match self.view {
            View::Top => (800, 760),
            View::Side => (800, 360),
        }
    }

    fn draw(&self, canvas: &mut Canvas) -> Result<()> {
        ensure!(self.all().next().is_some(), "no positions to draw");
        ensure!(self.all().all(|p| p.iter().all(|v| v.is_finite())), "a position is not a finite number");
        let (width, height) = self.size();
        let (width, height) = (f64::from(width), f64::from(height));
        let keys = [
            Key { text: "ground truth", color: INK, width: 5.0 },
            Key { text: "estimate", color: PALETTE[0], width: 2.5 },
        ];
        let shown = if self.ground_truth.is_empty() { &keys[1..] } else { &keys[..] };
        let top = header(canvas, width, &self.title, shown);
        let frame = Frame { left: 90.0, top, width: width - 115.0, height: height - top - 55.0 };
        let p = self.projection();
        let name = |axis: usize| ["x", "y", "z"][axis];
        match self.view {
            View::Top => {
                let to_plane = |v: &Vec3| (v[p.right], v[p.up]);
                let axes = self.axes(frame, &to_plane);
                axes.draw(canvas, &format!("{} [m]", name(p.right)), &format!("{} [m]", name(p.up)));
                self.draw_paths(canvas, &axes, &to_plane);
            }
            View::Side => {
                // A camera's y axis points down: height is -y.
                let sign = if p.height == 1 { -1.0 } else { 1.0 };
                let factor = self.exaggeration(&p, frame);
                let to_plane = |v: &Vec3| (v[p.along], sign * factor * v[p.height]);
                let flat = self.axes(frame, &to_plane);
                let axes = Axes { y: (flat.y.0 / factor, flat.y.1 / factor), ..flat };
                let minus = if sign < 0.0 { "-" } else { "" };
                let label = match factor {
                    1.0 => format!("{minus}{} [m]", name(p.height)),
                    _ => format!("{minus}{} [m], drawn {factor}x", name(p.height)),
                };
                axes.draw(canvas, &format!("{} [m]", name(p.along)), &label);
                self.draw_paths(canvas, &axes, &|v: &Vec3| (v[p.along], sign * v[p.height]));
            }
        }
        Ok(())
    }
}

impl TrajectoryFigure {
    fn axes(&self, frame: Frame, to_plane: &impl Fn(&Vec3) -> (f64, f64)) -> Axes {
        let x = range(self.all().map(|v| to_plane(v).0), Margin::Both);
        let y = range(self.all().map(|v| to_plane(v).1), Margin::Both);
        Axes::equal(frame, x, y)
    }

    /// Largest exaggeration of height that still lets the whole width decide the scale.
    fn exaggeration(&self, p: &Projection, frame: Frame) -> f64 {
        let x = range(self.all().map(|v| v[p.along]), Margin::Both);
        let y = range(self.all().map(|v| v[p.height]), Margin::Both);
        let free = (x.1 - x.0) / frame.width * frame.height / (y.1 - y.0);
        EXAGGERATIONS.iter().copied().rfind(|&e| e <= free).unwrap_or(1.0)
    }

    fn draw_paths(&self, canvas: &mut Canvas, axes: &Axes, to_plane: &impl Fn(&Vec3) -> (f64, f64)) {
        let mut path = |points: Vec<(f64, f64)>, color: RGBColor, width: f64| {
            let pixels: Vec<(f64, f64)> = points.iter().map(|&(x, y)| axes.at(x, y)).collect();
            canvas.line(&pixels, color, width);
        };
        path(self.ground_truth.iter().map(to_plane).collect(), INK, 5.0);
        for run in self.runs(to_plane) {
            path(run, PALETTE[0], 2.5);
        }
        if let Some(start) = self.ground_truth.first().or(self.estimate.iter().flatten().next()) {
            let (x, y) = to_plane(start);
            canvas.dot(axes.at(x, y), 7.0, INK);
            canvas.dot(axes.at(x, y), 4.0, RGBColor(255, 255, 255));
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
