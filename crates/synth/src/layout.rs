//! Which ground is taken: the street, side streets and houses; tests whether something else has room.

use crate::course::Course;
use crate::mesh::{Placement, V3};

/// A street that leaves the course at right angles, straight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SideStreet {
    /// Place on the course, meters.
    pub(crate) s: f64,
    /// Crossing with the course's center line.
    pub(crate) center: V3,
    /// Unit vector to the right of the course.
    pub(crate) right: V3,
    /// Heading of `right`.
    pub(crate) heading: f64,
    /// Lengths to the left and to the right, meters from the center line; 0 where there is none.
    pub(crate) left_m: f64,
    pub(crate) right_m: f64,
}

/// Half the width of a side street's carriageway, meters.
pub(crate) const SIDE_HALF_M: f64 = 3.6;
/// Half the width of the main carriageway, meters.
pub(crate) const ROAD_HALF_M: f64 = 5.4;

impl SideStreet {
    /// Both directions exist: traffic can cross.
    pub(crate) fn is_crossing(&self) -> bool {
        self.left_m > 0.0 && self.right_m > 0.0
    }

    /// Distance of a point from the street's middle line.
    fn distance(&self, point: &V3) -> f64 {
        let offset = point - self.center;
        let along = offset.dot(&self.right).clamp(-self.left_m, self.right_m);
        (offset - self.right * along).norm()
    }
}

/// A house's ground: placement of its front's left corner, width along x, depth along z.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint {
    pub(crate) placement: Placement,
    pub(crate) width: f64,
    pub(crate) depth: f64,
}

impl Footprint {
    fn corner(&self, x: f64, z: f64) -> V3 {
        self.placement.apply(&V3::new(x * self.width, 0.0, z * self.depth))
    }

    fn center(&self) -> V3 {
        self.corner(0.5, 0.5)
    }

    fn radius(&self) -> f64 {
        0.5 * self.width.hypot(self.depth)
    }

    /// Points of the rectangle no more than about 2 m apart.
    fn points(&self) -> impl Iterator<Item = V3> + '_ {
        let (nx, nz) = ((self.width / 2.0).ceil() as i32, (self.depth / 2.0).ceil() as i32);
        (0..=nx).flat_map(move |i| {
            (0..=nz).map(move |k| self.corner(f64::from(i) / f64::from(nx), f64::from(k) / f64::from(nz)))
        })
    }

    /// Whether two rectangles overlap (separating axes).
    fn overlaps(&self, other: &Self) -> bool {
        if (self.center() - other.center()).norm() > self.radius() + other.radius() {
            return false;
        }
        let axes = [self, other].into_iter().flat_map(|f| {
            let rotation = f.placement.rotation();
            [rotation * V3::x(), rotation * V3::z()]
        });
        let span = |f: &Self, axis: &V3| {
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
                .iter()
                .map(|(x, z)| f.corner(*x, *z).dot(axis))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
        };
        !axes.into_iter().any(|axis| {
            let (a, b) = (span(self, &axis), span(other, &axis));
            a.1 <= b.0 + 1e-6 || b.1 <= a.0 + 1e-6
        })
    }
}

/// Ground that is taken.
#[derive(Clone, Debug)]
pub(crate) struct Layout<'a> {
    pub(crate) course: &'a Course,
    pub(crate) side_streets: Vec<SideStreet>,
    pub(crate) houses: Vec<Footprint>,
}

impl Layout<'_> {
    /// Whether a house can stand there, at least `clearance` meters from the course's center line.
    pub(crate) fn has_room(&self, house: &Footprint, clearance: f64) -> bool {
        let near_course = self.course.distance(&house.center()) < house.radius() + clearance;
        if near_course && house.points().any(|p| self.course.distance(&p) < clearance) {
            return false;
        }
        let in_side_street =
            |p: V3| self.side_streets.iter().any(|street| street.distance(&p) < SIDE_HALF_M + 1.6);
        !house.points().any(in_side_street) && !self.houses.iter().any(|other| other.overlaps(house))
    }

    /// Whether a thing of the given radius can stand at a point.
    pub(crate) fn is_free(&self, point: &V3, radius: f64, clearance: f64) -> bool {
        let spot = Footprint {
            placement: Placement { position: point - V3::new(radius, 0.0, radius), yaw: 0.0 },
            width: 2.0 * radius,
            depth: 2.0 * radius,
        };
        self.course.distance(point) >= clearance
            && !self.side_streets.iter().any(|street| street.distance(point) < SIDE_HALF_M + radius)
            && !self.houses.iter().any(|house| house.overlaps(&spot))
    }

    /// Distance along the course to the nearest side street's middle, on the side `sign` (right is positive).
    pub(crate) fn to_side_street(&self, s: f64, sign: f64) -> f64 {
        let length = self.course.length;
        self.side_streets
            .iter()
            .filter(|street| if sign > 0.0 { street.right_m > 0.0 } else { street.left_m > 0.0 })
            .map(|street| {
                let d = (street.s - s).abs();
                if self.course.closed { d.min((length - d).abs()) } else { d }
            })
            .fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, z: f64, yaw: f64) -> Footprint {
        Footprint { placement: Placement { position: V3::new(x, 0.0, z), yaw }, width: 10.0, depth: 10.0 }
    }

    #[test]
    fn rectangles_overlap_only_where_they_share_ground() {
        assert!(square(0.0, 0.0, 0.0).overlaps(&square(9.0, 0.0, 0.0)));
        assert!(!square(0.0, 0.0, 0.0).overlaps(&square(10.0, 0.0, 0.0)));
        assert!(square(0.0, 0.0, 0.0).overlaps(&square(5.0, 4.0, 0.8)));
        // The corner of a turned square reaches 14.1 m from its own corner.
        assert!(!square(0.0, 0.0, 0.0).overlaps(&square(17.2, -2.0, 0.78)));
    }

    #[test]
    fn nothing_has_room_on_the_street() {
        let course = Course::town(1);
        let layout = Layout { course: &course, side_streets: Vec::new(), houses: Vec::new() };
        let on = course.at(50.0).beside(2.0);
        assert!(!layout.has_room(&Footprint { placement: on, width: 8.0, depth: 8.0 }, 7.0));
        let mut beside = course.at(50.0).beside(9.0);
        beside.yaw += std::f64::consts::FRAC_PI_2;
        beside.position = course.at(58.0).beside(9.0).position;
        assert!(layout.has_room(&Footprint { placement: beside, width: 8.0, depth: 8.0 }, 7.0));
        assert!(!layout.is_free(&course.at(20.0).position, 0.5, 5.0));
    }
}
