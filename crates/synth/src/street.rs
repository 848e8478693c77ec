//! The ground: carriageway, curbs, walks, side streets, road marks, patches, manholes, tar seams.

use crate::course::{Course, Station};
use crate::layout::{Layout, ROAD_HALF_M, SIDE_HALF_M, SideStreet};
use crate::library::Common;
use crate::mesh::{Mesh, Surface, V3};
use crate::noise::{signed, unit};

/// Width of the walks, meters.
pub(crate) const WALK_M: f64 = 3.0;
/// Height of the curb, meters.
const CURB_M: f64 = 0.12;
/// Distance between cross-sections, meters, and their number in one mesh.
const SECTION_M: f64 = 2.5;
const SECTIONS: usize = 10;

/// Everything that lies on the ground, in pieces about 25 m long (world coordinates).
pub(crate) fn build(layout: &Layout<'_>, common: &Common, seed: u32, regular: bool) -> Vec<Mesh> {
    let course = layout.course;
    let n = (course.length / SECTION_M).round() as usize;
    let step = course.length / n as f64;
    let mut meshes = vec![ground(course, common)];
    for first in (0..n).step_by(SECTIONS) {
        let mut mesh = Mesh::default();
        for k in first..(first + SECTIONS).min(n) {
            section(&mut mesh, layout, common, k as f64 * step, step);
        }
        let (from, to) = (first as f64 * step, (first + SECTIONS).min(n) as f64 * step);
        marks(&mut mesh, layout, common, from, to);
        wear(
            &mut mesh,
            course,
            common,
            from,
            to,
            if regular { first as u32 % 2 } else { seed ^ first as u32 },
        );
        meshes.push(mesh.finish());
    }
    meshes.extend(layout.side_streets.iter().map(|street| side_street(street, common)));
    meshes
}

/// A flat polygon textured by world coordinates, so that neighbors join; corners clockwise seen from above.
fn flat(mesh: &mut Mesh, corners: &[V3], surface: Surface) {
    let offset = [surface.density[0] * corners[0].x, surface.density[1] * -corners[0].z];
    mesh.add(corners, V3::x(), -V3::z(), Surface { offset, ..surface });
}

/// Grass all around, a little lower than the road.
fn ground(course: &Course, common: &Common) -> Mesh {
    let (low, high) = course.bounds();
    let (x0, x1, z0, z1, y) = (low.x - 420.0, high.x + 420.0, low.z - 420.0, high.z + 420.0, 0.03);
    let mut mesh = Mesh::default();
    let corners = [V3::new(x0, y, z1), V3::new(x1, y, z1), V3::new(x1, y, z0), V3::new(x0, y, z0)];
    flat(&mut mesh, &corners, common.grass);
    mesh.finish()
}

/// A flat piece of road between two cross-sections, from `left` to `right` of the course.
fn piece(mesh: &mut Mesh, [a, b]: [&Station; 2], [left, right]: [f64; 2], surface: Surface) {
    let at = |station: &Station, lateral: f64| station.beside(lateral).position;
    flat(mesh, &[at(b, left), at(b, right), at(a, right), at(a, left)], surface);
}

/// Carriageway, curbs and walks between two cross-sections.
fn section(mesh: &mut Mesh, layout: &Layout<'_>, common: &Common, s: f64, step: f64) {
    let (a, b) = (layout.course.at(s), layout.course.at(s + step));
    let half = ROAD_HALF_M;
    piece(mesh, [&a, &b], [-half, half], common.asphalt);
    for side in [-1.0, 1.0] {
        if layout.to_side_street(s + 0.5 * step, side) < SIDE_HALF_M + 0.9 {
            let mouth = [side * half, side * (half + WALK_M)];
            let (left, right) = (mouth[0].min(mouth[1]), mouth[0].max(mouth[1]));
            piece(mesh, [&a, &b], [left, right], common.asphalt);
            continue;
        }
        walk(mesh, common, [&a, &b], side, s);
    }
}

/// The walk of one side with its curb; the slabs follow the street.
fn walk(mesh: &mut Mesh, common: &Common, [a, b]: [&Station; 2], side: f64, s: f64) {
    let at =
        |station: &Station, lateral: f64, up: f64| station.beside(side * lateral).position - V3::y() * up;
    let (inner, stone, outer) = (ROAD_HALF_M, ROAD_HALF_M + 0.16, ROAD_HALF_M + WALK_M);
    // On the left the corners run the other way round.
    let turned = |[a, b, c, d]: [V3; 4]| if side < 0.0 { [b, a, d, c] } else { [a, b, c, d] };
    let strip = |mesh: &mut Mesh, from: f64, to: f64, surface: Surface| {
        let corners =
            turned([at(b, from, CURB_M), at(b, to, CURB_M), at(a, to, CURB_M), at(a, from, CURB_M)]);
        let back = (corners[3] - corners[0]).normalize();
        let across = V3::y().cross(&back);
        let offset = [surface.density[0] * from, -surface.density[1] * s];
        mesh.add(&corners, -across, back, Surface { offset, ..surface });
    };
    strip(mesh, inner, stone, common.curb);
    strip(mesh, stone, outer, common.paving);
    let face = turned([at(b, inner, CURB_M), at(a, inner, CURB_M), at(a, inner, 0.0), at(b, inner, 0.0)]);
    let along = (face[1] - face[0]).normalize();
    mesh.add(&face, along, V3::y(), Surface { offset: [common.curb.density[0] * s, 0.0], ..common.curb });
}

/// A mark along the street: its middle at `lateral`, from `s` over `length`.
fn stripe(mesh: &mut Mesh, course: &Course, surface: Surface, s: f64, length: f64, lateral: f64, width: f64) {
    let half = 0.5 * width;
    let ends = [&course.at(s), &course.at(s + length)];
    piece(mesh, ends, [lateral - half, lateral + half], surface);
}

/// Center dashes, parking bays, zebra crossings and stop lines before side streets.
fn marks(mesh: &mut Mesh, layout: &Layout<'_>, common: &Common, from: f64, to: f64) {
    let course = layout.course;
    let near_crossing = |s: f64| layout.to_side_street(s, 1.0).min(layout.to_side_street(s, -1.0));
    let mut s = (from / 6.25).ceil() * 6.25;
    while s < to {
        if near_crossing(s + 1.2) > 8.0 {
            stripe(mesh, course, common.paint, s, 2.4, 0.0, 0.14);
            for side in [-1.0, 1.0] {
                stripe(mesh, course, common.paint, s, 0.12, side * 4.35, 2.0);
                stripe(mesh, course, common.paint, s - 0.6, 1.3, side * 3.3, 0.12);
            }
        }
        s += 6.25;
    }
    for street in layout.side_streets.iter().filter(|street| (from..to).contains(&street.s)) {
        for side in [-1.0, 1.0] {
            let zebra = street.s + side * 7.0 - 1.5;
            for k in 0..10 {
                stripe(mesh, course, common.paint, zebra, 3.0, -4.7 + 1.04 * f64::from(k), 0.5);
            }
            stripe(mesh, course, common.paint, street.s + side * 10.0, 0.35, -side * 1.65, 3.1);
        }
    }
}

/// Repaired rectangles, manholes and tar seams.
fn wear(mesh: &mut Mesh, course: &Course, common: &Common, from: f64, to: f64, seed: u32) {
    let length = to - from;
    for k in 0..4 {
        let r = |j: i32| f64::from(unit(k, j, seed));
        let s = from + (length - 4.0) * r(0);
        let lateral = 4.2 * (2.0 * r(1) - 1.0);
        if r(2) < 0.7 {
            let tone = Surface { gain: 0.62 + 0.7 * r(3), ..common.patch };
            let (patch_l, patch_w) = (0.7 + 2.6 * r(4), 0.5 + 1.4 * r(5));
            stripe(mesh, course, tone, s, patch_l, lateral, patch_w);
            for edge in [-0.5, 0.5] {
                stripe(mesh, course, common.dark, s, patch_l, lateral + edge * patch_w, 0.05);
            }
        }
        if r(6) < 0.45 {
            let corner = course.at(from + length * r(7)).beside(3.0 * (2.0 * r(8) - 1.0)).position;
            let offset = [0.0; 2];
            let corners =
                [V3::new(0.0, 0.0, 0.7), V3::new(0.7, 0.0, 0.7), V3::new(0.7, 0.0, 0.0), V3::zeros()];
            let density = [64.0 / 0.7; 2];
            mesh.add(
                &corners.map(|c| c + corner),
                V3::x(),
                -V3::z(),
                Surface { offset, density, ..common.manhole },
            );
        }
    }
    for k in 0..5 {
        let s = |j: i32| f64::from(signed(k, j, seed ^ 0x7a));
        let mut place = [from + length * (0.5 + 0.5 * s(0)), 4.5 * s(1)];
        let mut direction = 1.6 * s(2);
        for piece in 0..7 {
            direction += 0.5 * s(10 + piece);
            let (sin, cos) = direction.sin_cos();
            let next = [place[0] + 0.9 * cos, (place[1] + 0.9 * sin).clamp(-5.2, 5.2)];
            seam(mesh, course, common.dark, place, next);
            place = next;
        }
    }
}

/// A line 4 cm wide between two places given by course length and lateral offset.
fn seam(mesh: &mut Mesh, course: &Course, surface: Surface, from: [f64; 2], to: [f64; 2]) {
    let point = |p: [f64; 2]| course.at(p[0]).beside(p[1]).position;
    let (a, b) = (point(from), point(to));
    let Some(along) = (b - a).try_normalize(1e-6) else { return };
    let right = V3::y().cross(&along) * 0.02;
    flat(mesh, &[b - right, b + right, a + right, a - right], surface);
}

/// Carriageway and walks of a side street, both arms.
fn side_street(street: &SideStreet, common: &Common) -> Mesh {
    let mut mesh = Mesh::default();
    let along = V3::new(street.heading.sin(), 0.0, street.heading.cos());
    let right = V3::y().cross(&along);
    for (sign, length) in [(-1.0, street.left_m), (1.0, street.right_m)] {
        if length <= 0.0 {
            continue;
        }
        let (dir, side) = (along * sign, right * sign);
        let point = |forward: f64, lateral: f64, up: f64| {
            street.center + dir * forward + side * lateral - V3::y() * up
        };
        let (near, far) = (ROAD_HALF_M + WALK_M, length);
        let strip = |mesh: &mut Mesh, [from, to]: [f64; 2], [l, r]: [f64; 2], up: f64, surface: Surface| {
            let corners = [point(to, l, up), point(to, r, up), point(from, r, up), point(from, l, up)];
            flat(mesh, &corners, surface);
        };
        strip(&mut mesh, [near, far], [-SIDE_HALF_M, SIDE_HALF_M], 0.0, common.asphalt);
        for k in [-1.0, 1.0] {
            let (inner, outer) = (k * SIDE_HALF_M, k * (SIDE_HALF_M + 1.8));
            let walk = [inner.min(outer), inner.max(outer)];
            strip(&mut mesh, [near, far], walk, CURB_M, common.paving);
            let (a, b) = (point(near, inner, CURB_M), point(far, inner, CURB_M));
            let (from, to) = if k > 0.0 { (b, a) } else { (a, b) };
            mesh.quad(from, to - from, V3::y() * CURB_M, common.curb);
        }
        let mut s = near + 1.0;
        while s + 2.0 < far {
            strip(&mut mesh, [s, s + 2.0], [-0.06, 0.06], 0.0, common.paint);
            s += 5.0;
        }
    }
    mesh.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::library::Recipes;

    #[test]
    fn everything_on_the_ground_is_seen_from_above() {
        let course = Course::town(2);
        let station = course.at(60.0);
        let street = SideStreet {
            s: 60.0,
            center: station.position,
            right: station.right(),
            heading: station.heading + std::f64::consts::FRAC_PI_2,
            left_m: 50.0,
            right_m: 60.0,
        };
        let layout = Layout { course: &course, side_streets: vec![street], houses: Vec::new() };
        let common = Common::new(&mut Recipes::default(), 1);
        let meshes = build(&layout, &common, 4, false);
        let polygons: Vec<_> = meshes.iter().flat_map(|m| &m.polygons).collect();
        assert!(polygons.len() > 2000);
        for p in &polygons {
            assert!(p.normal.y < -0.999 || p.normal.y.abs() < 1e-6, "{:?}", p.normal);
        }
    }
}
