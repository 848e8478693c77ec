//! Rows of houses along streets, and houses behind them.

use crate::course::Station;
use crate::houses::{self, Plot};
use crate::layout::{Footprint, ROAD_HALF_M, SIDE_HALF_M, SideStreet};
use crate::mesh::{Placement, V3};
use crate::street::WALK_M;
use crate::town::Town;
use rand::Rng;
use std::f64::consts::TAU;

/// Least distance of houses from the course's center line, meters.
const CLEARANCE_M: f64 = 7.4;
/// Heights of houses, as often as they stand here.
const STORIES: [u32; 8] = [1, 2, 2, 2, 3, 3, 4, 5];

impl Town<'_, '_> {
    /// A row of houses along one side of the course.
    pub(crate) fn course_row(&mut self, side: f64) {
        let course = self.layout.course;
        let end = if course.closed { course.length } else { course.length + 60.0 };
        let start = if course.closed { 0.0 } else { -20.0 };
        self.row(&|s| course.at(s), start, end, side, ROAD_HALF_M + WALK_M);
    }

    /// Rows along both sides of both arms of a side street, and a house across each end.
    pub(crate) fn side_rows(&mut self, street: &SideStreet) {
        for (sign, length) in [(-1.0, street.left_m), (1.0, street.right_m)] {
            if length <= 0.0 {
                continue;
            }
            let dir = street.right * sign;
            let heading = street.heading + if sign < 0.0 { std::f64::consts::PI } else { 0.0 };
            let line = |s: f64| Station { position: street.center + dir * s, heading, curvature: 0.0 };
            let width = 13.0;
            let placement = line(length + 5.4).beside(-0.5 * width);
            let end = Footprint { placement, width, depth: 9.0 };
            if self.layout.has_room(&end, CLEARANCE_M) {
                self.house(end, 3, false);
            }
            for side in [-1.0, 1.0] {
                self.row(&line, ROAD_HALF_M + WALK_M + 0.5, length, side, SIDE_HALF_M + 2.0);
            }
        }
    }

    /// Houses side by side along a line from `from` to `to`, their fronts `lateral` meters (or a front garden more) from it.
    fn row(&mut self, line: &dyn Fn(f64) -> Station, from: f64, to: f64, side: f64, lateral: f64) {
        let regular = self.settings.regular;
        let mut s = from;
        let (mut setback, mut left_in_group) = (0.0, 0);
        while s < to {
            if left_in_group == 0 {
                left_in_group = self.rng.random_range(2..6);
                setback =
                    if regular || self.rng.random_bool(0.5) { 0.1 } else { self.rng.random_range(2.0..5.0) };
            }
            let wish = if regular { 12.0 } else { self.rng.random_range(8.5..16.0) };
            let depth = if regular { 10.0 } else { self.rng.random_range(8.0..11.5) };
            let stories = if regular { 3 } else { STORIES[self.rng.random_range(0..STORIES.len())] };
            let fits =
                [(wish, depth), (0.7 * wish, 0.8 * depth), (6.0, 6.0)].into_iter().find_map(|(w, d)| {
                    let footprint = footprint_along(line, s, to, side, lateral + setback, [w, d])?;
                    self.layout.has_room(&footprint, CLEARANCE_M).then_some(footprint)
                });
            let Some(footprint) = fits else {
                s += 1.0;
                continue;
            };
            self.house(footprint, stories, false);
            left_in_group -= 1;
            let gap = if regular || left_in_group > 0 { 0.02 } else { self.rng.random_range(1.0..7.0) };
            s = beyond(line, s, side * (lateral + setback), footprint.width).unwrap_or(s + footprint.width)
                + gap;
        }
    }

    fn house(&mut self, footprint: Footprint, stories: u32, distant: bool) {
        let plot = Plot { width: footprint.width, depth: footprint.depth, stories, distant };
        self.layout.houses.push(footprint);
        let mesh = if self.settings.regular { self.repeated(&plot) } else { self.designed(&plot) };
        self.scene.place(mesh, footprint.placement, 1.0);
    }

    fn designed(&mut self, plot: &Plot) -> u32 {
        self.looks += 1;
        let look = self.rng.random::<u32>();
        let mesh = houses::build(plot, &mut self.scene.recipes, self.common, look);
        self.scene.mesh(mesh)
    }

    /// Two designs in turn for each size.
    fn repeated(&mut self, plot: &Plot) -> u32 {
        self.looks += 1;
        let variant = self.looks % 2;
        let same = |w: f64| (w - plot.width).abs() < 0.05;
        if let Some((_, _, mesh)) = self.known.iter().find(|(w, v, _)| same(*w) && *v == variant) {
            return *mesh;
        }
        let mesh = houses::build(plot, &mut self.scene.recipes, self.common, 7 + variant);
        let mesh = self.scene.mesh(mesh);
        self.known.push((plot.width, variant, mesh));
        mesh
    }

    /// Houses at random behind the first row, to close the view through gaps.
    pub(crate) fn second_row(&mut self) {
        let (low, high) = self.layout.course.bounds();
        let margin = 70.0;
        for _ in 0..900 {
            let x = self.rng.random_range(low.x - margin..high.x + margin);
            let z = self.rng.random_range(low.z - margin..high.z + margin);
            let placement = Placement { position: V3::new(x, 0.0, z), yaw: self.rng.random_range(0.0..TAU) };
            let (width, depth) = (self.rng.random_range(9.0..17.0), self.rng.random_range(9.0..13.0));
            let stories = self.rng.random_range(3..7);
            let footprint = Footprint { placement, width, depth };
            if self.layout.has_room(&footprint, 21.0) {
                self.house(footprint, stories, true);
            }
        }
    }
}

/// The place along the line where a chord of the given width, `lateral` beside the line, ends; `None` when 4 widths do not reach.
fn beyond(line: &dyn Fn(f64) -> Station, s: f64, lateral: f64, width: f64) -> Option<f64> {
    let start = line(s).beside(lateral).position;
    let steps = (16.0 * width) as i32;
    (1..steps)
        .map(|k| s + 0.25 * f64::from(k))
        .find(|end| (line(*end).beside(lateral).position - start).norm() >= width)
}

/// Ground of a house whose front is a chord of the line's offset curve and starts at `s`; `None` when it would end beyond `to`.
pub(crate) fn footprint_along(
    line: &dyn Fn(f64) -> Station,
    s: f64,
    to: f64,
    side: f64,
    lateral: f64,
    [width, depth]: [f64; 2],
) -> Option<Footprint> {
    let end = beyond(line, s, side * lateral, width)?;
    if end > to {
        return None;
    }
    let (a, b) = (line(s).beside(side * lateral).position, line(end).beside(side * lateral).position);
    // Seen from the street, the front runs forwards on the left side and backwards on the right.
    let (from, dir) = if side < 0.0 { (a, (b - a).normalize()) } else { (b, (a - b).normalize()) };
    let position = if side < 0.0 { from } else { a - dir * width };
    Some(Footprint { placement: Placement { position, yaw: (-dir.z).atan2(dir.x) }, width, depth })
}
