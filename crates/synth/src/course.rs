//! The street's center line: a polygon with rounded corners, smoothed until its curvature is continuous, sampled by length.

use crate::mesh::{Placement, V3};
use crate::noise::signed;

/// Distance between samples of the center line, meters.
const STEP_M: f64 = 0.25;
/// Width of the two smoothing passes, meters: the length over which a turn begins.
const SMOOTHING_M: f64 = 7.0;

/// A place on the center line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Station {
    /// On the ground plane (y = 0).
    pub(crate) position: V3,
    /// Direction of travel, radians; grows in right turns and is continuous along the course.
    pub(crate) heading: f64,
    /// Change of heading per meter.
    pub(crate) curvature: f64,
}

impl Station {
    /// Point `lateral` meters to the right, and the heading there.
    pub(crate) fn beside(&self, lateral: f64) -> Placement {
        Placement { position: self.position + self.right() * lateral, yaw: self.heading }
    }

    /// Unit vector to the right.
    pub(crate) fn right(&self) -> V3 {
        let (s, c) = self.heading.sin_cos();
        V3::new(c, 0.0, -s)
    }
}

/// A closed course, or an open street.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    positions: Vec<V3>,
    headings: Vec<f64>,
    curvatures: Vec<f64>,
    pub(crate) length: f64,
    pub(crate) closed: bool,
    /// Heading gained in one round.
    turn: f64,
}

/// A corner of the polygon: x, z and the radius of its rounding, meters.
type Corner = [f64; 3];

impl Course {
    /// A closed course of about a kilometer with street corners, gentle bends and an S; corners vary with the seed.
    pub(crate) fn town(seed: u64) -> Self {
        const SHARP: f64 = 13.0;
        const WIDE: f64 = 75.0;
        let template: [Corner; 9] = [
            [0.0, -88.0, SHARP],
            [0.0, 48.0, WIDE],
            [20.0, 152.0, SHARP],
            [128.0, 160.0, SHARP],
            [140.0, 76.0, SHARP],
            [232.0, 64.0, SHARP],
            [216.0, -48.0, WIDE],
            [228.0, -104.0, SHARP],
            [104.0, -120.0, WIDE],
        ];
        let seed32 = (seed ^ (seed >> 32)) as u32;
        let mirror = if seed & 1 == 1 { -1.0 } else { 1.0 };
        let corners: Vec<Corner> = template
            .iter()
            .enumerate()
            .map(|(i, [x, z, r])| {
                let jitter = |k: i32| 6.0 * f64::from(signed(i as i32, k, seed32));
                [mirror * (x + jitter(0)), z + jitter(1), *r]
            })
            .collect();
        // The course starts in the middle of the first side.
        let middle = [0, 1].map(|i| 0.5 * (corners[0][i] + corners[1][i]));
        let mut from_middle = vec![[middle[0], middle[1], 1.0]];
        from_middle.extend_from_slice(&corners[1..]);
        from_middle.push(corners[0]);
        Self::from_corners(&from_middle, true)
    }

    /// An open street of at least `length` meters that winds gently and never comes back.
    pub(crate) fn street(seed: u64, length: f64) -> Self {
        let seed32 = (seed ^ (seed >> 32)) as u32;
        let (mut corners, mut z, mut i) = (vec![[0.0, 0.0, 1.0]], 0.0, 0);
        while z < length + 80.0 {
            z += 75.0 + 25.0 * f64::from(signed(i, 1, seed32));
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            corners.push([side * (10.0 + 8.0 * f64::from(signed(i, 2, seed32))), z, 70.0]);
            i += 1;
        }
        Self::from_corners(&corners, false)
    }

    fn from_corners(corners: &[Corner], closed: bool) -> Self {
        let dense = round_corners(corners, closed);
        let smooth = smooth(&smooth(&dense, closed), closed);
        let (positions, length) = resample(&smooth, closed, STEP_M);
        let n = positions.len();
        let at = |i: isize| {
            if closed {
                positions[i.rem_euclid(n as isize) as usize]
            } else {
                positions[i.clamp(0, n as isize - 1) as usize]
            }
        };
        let mut headings: Vec<f64> = Vec::with_capacity(n + 1);
        for i in 0..=n as isize {
            let d = at(i + 1) - at(i - 1);
            let raw = d.x.atan2(d.z);
            let previous = headings.last().copied().unwrap_or(raw);
            headings.push(previous + wrap(raw - previous));
        }
        let step = length / (if closed { n } else { n - 1 }) as f64;
        let curvatures = (0..n).map(|i| (headings[i + 1] - headings[i]) / step).collect();
        let turn = headings[n] - headings[0];
        headings.truncate(n);
        Self { positions, headings, curvatures, length, closed, turn }
    }

    /// The station `s` meters from the start; on a closed course any `s`, on an open one its ends are extended straight on.
    pub(crate) fn at(&self, s: f64) -> Station {
        let n = self.positions.len();
        if !self.closed {
            let inside = s.clamp(0.0, self.length - 1e-6);
            let mut station = self.between(inside / self.length * (n - 1) as f64, n - 1, 0.0);
            let (sin, cos) = station.heading.sin_cos();
            station.position += V3::new(sin, 0.0, cos) * (s - inside);
            return station;
        }
        let round = (s / self.length).floor();
        let within = (s - round * self.length) / self.length * n as f64;
        self.between(within.clamp(0.0, n as f64 - 1e-9), n, round * self.turn)
    }

    fn between(&self, index: f64, segments: usize, turned: f64) -> Station {
        let i = (index.floor() as usize).min(segments - 1);
        let j = (i + 1) % self.positions.len();
        let f = index - i as f64;
        let end = if j == 0 { self.headings[0] + self.turn } else { self.headings[j] };
        Station {
            position: self.positions[i] * (1.0 - f) + self.positions[j] * f,
            heading: turned + self.headings[i] * (1.0 - f) + end * f,
            curvature: self.curvatures[i] * (1.0 - f) + self.curvatures[j] * f,
        }
    }

    /// Nearest distance from a point to the center line, from samples 1 m apart; meters.
    pub(crate) fn distance(&self, point: &V3) -> f64 {
        let skip = (1.0 / STEP_M) as usize;
        let nearest = |p: &V3| (p.x - point.x).powi(2) + (p.z - point.z).powi(2);
        self.positions.iter().step_by(skip).map(nearest).fold(f64::INFINITY, f64::min).sqrt()
    }

    /// Lower and upper corner of the box around the course, ground plane.
    pub(crate) fn bounds(&self) -> (V3, V3) {
        let start = (self.positions[0], self.positions[0]);
        self.positions.iter().fold(start, |(low, high), p| (low.inf(p), high.sup(p)))
    }
}

/// The angle in (-pi, pi] that differs by full turns.
fn wrap(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}

/// Replaces corners by arcs that touch both sides; points at most 0.1 m apart.
fn round_corners(corners: &[Corner], closed: bool) -> Vec<V3> {
    let n = corners.len();
    let point = |i: usize| V3::new(corners[i % n][0], 0.0, corners[i % n][1]);
    let mut out: Vec<V3> = Vec::new();
    let line_to = |out: &mut Vec<V3>, to: V3| {
        let Some(from) = out.last().copied() else { return out.push(to) };
        let pieces = ((to - from).norm() / 0.1).ceil().max(1.0) as usize;
        out.extend((1..=pieces).map(|k| from + (to - from) * (k as f64 / pieces as f64)));
    };
    for (i, [.., radius]) in corners.iter().enumerate() {
        if !closed && (i == 0 || i == n - 1) {
            line_to(&mut out, point(i));
            continue;
        }
        let (before, here, after) = (point(i + n - 1), point(i), point(i + 1));
        let (a, b) = ((here - before).normalize(), (after - here).normalize());
        let angle = a.dot(&b).clamp(-1.0, 1.0).acos();
        let tangent = radius * (angle / 2.0).tan();
        let pieces = (radius * angle / 0.1).ceil().max(2.0) as usize;
        // The arc as a rotation of its first radius.
        let side = if a.z * b.x - a.x * b.z > 0.0 { 1.0 } else { -1.0 };
        let to_center = V3::new(a.z, 0.0, -a.x) * side * *radius;
        let start = here - a * tangent;
        line_to(&mut out, start);
        for k in 1..=pieces {
            let turned = crate::mesh::yaw_matrix(side * angle * k as f64 / pieces as f64);
            out.push(start + to_center - turned * to_center);
        }
    }
    if closed {
        let first = out[0];
        line_to(&mut out, first);
        out.pop();
    }
    out
}

/// Moving mean over [`SMOOTHING_M`] of a line sampled about 0.1 m apart.
fn smooth(points: &[V3], closed: bool) -> Vec<V3> {
    let (even, _) = resample(points, closed, 0.1);
    let half = (SMOOTHING_M / 0.2) as isize;
    let n = even.len() as isize;
    (0..n)
        .map(|i| {
            let reach = if closed { half } else { half.min(i).min(n - 1 - i) };
            let sum: V3 = (i - reach..=i + reach).map(|k| even[k.rem_euclid(n) as usize]).sum();
            sum / (2 * reach + 1) as f64
        })
        .collect()
}

/// Points at equal distances of about `step` along the line, and its length.
fn resample(points: &[V3], closed: bool, step: f64) -> (Vec<V3>, f64) {
    let n = points.len();
    let segments = if closed { n } else { n - 1 };
    let mut lengths = vec![0.0];
    for i in 0..segments {
        lengths.push(lengths[i] + (points[(i + 1) % n] - points[i]).norm());
    }
    let total = lengths[segments];
    let pieces = (total / step).round().max(4.0) as usize;
    let count = if closed { pieces } else { pieces + 1 };
    let mut i = 0;
    let even = (0..count)
        .map(|k| {
            let s = total * k as f64 / pieces as f64;
            while i + 1 < segments && lengths[i + 1] < s {
                i += 1;
            }
            let f = (s - lengths[i]) / (lengths[i + 1] - lengths[i]).max(1e-12);
            points[i] + (points[(i + 1) % n] - points[i]) * f
        })
        .collect();
    (even, total)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_town_closes_on_itself_and_is_long_enough() {
        for seed in 0..20 {
            let course = Course::town(seed);
            assert!(course.length > 850.0 && course.length < 1150.0, "{}", course.length);
            let (start, end) = (course.at(0.0), course.at(course.length));
            assert!((start.position - end.position).norm() < 1e-6);
            assert!(((end.heading - start.heading).abs() - std::f64::consts::TAU).abs() < 1e-6);
        }
    }

    #[test]
    fn position_heading_and_curvature_agree() {
        for course in [Course::town(1), Course::town(2), Course::street(3, 900.0)] {
            let mut s = 3.0;
            while s < course.length - 3.0 {
                let (a, here, b) = (course.at(s - 0.5), course.at(s), course.at(s + 0.5));
                let (sin, cos) = here.heading.sin_cos();
                let along = (b.position - a.position).normalize();
                assert!(along.dot(&V3::new(sin, 0.0, cos)) > 0.999, "at {s}");
                assert!(((b.heading - a.heading) - here.curvature).abs() < 0.02, "at {s}");
                assert!(here.curvature.abs() < 0.12, "at {s}: {}", here.curvature);
                s += 1.7;
            }
        }
    }

    #[test]
    fn a_street_never_comes_back() {
        let course = Course::street(5, 900.0);
        assert!(course.length >= 900.0);
        let mut s = 0.0;
        while s < 900.0 {
            assert!((course.at(s + 60.0).position - course.at(s).position).norm() > 50.0);
            s += 10.0;
        }
    }
}
