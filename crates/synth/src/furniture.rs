//! Meshes of trees, bushes, lamps, signs, bins, hedges and garden walls. Origin on the ground; facing -z where it matters.

use crate::library::Common;
use crate::mesh::{Mesh, Surface, V3};
use crate::noise::{signed, unit};

/// A tree: tapered trunk with boughs, and leafy cards set around an ellipsoid.
pub(crate) fn tree(common: &Common, seed: u32) -> Mesh {
    let r = |k: i32| f64::from(unit(k, 5, seed));
    let mut mesh = Mesh::default();
    let (trunk, girth) = (2.2 + 1.4 * r(0), 0.14 + 0.12 * r(1));
    mesh.prism(V3::zeros(), trunk + 1.0, [girth, 0.7 * girth], 7, common.bark);
    let radii = V3::new(1.5 + 0.9 * r(2), 1.7 + 1.0 * r(3), 1.5 + 0.9 * r(2));
    let center = V3::new(0.0, -trunk - 0.75 * radii.y, 0.0);
    let n = 22;
    for i in 0..n {
        // Directions spread evenly over the sphere (golden angle), then shaken.
        let up = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(n);
        let around = f64::from(i) * 2.399_963 + 0.6 * f64::from(signed(i, 1, seed));
        let flat = (1.0 - up * up).sqrt();
        let out = V3::new(flat * around.cos(), -up, flat * around.sin());
        let at = center + out.component_mul(&radii) * (0.72 + 0.2 * f64::from(signed(i, 2, seed)));
        let shake = V3::new(
            f64::from(signed(i, 3, seed)),
            f64::from(signed(i, 4, seed)),
            f64::from(signed(i, 5, seed)),
        );
        card(
            &mut mesh,
            common,
            at,
            (out + 0.7 * shake).normalize(),
            1.5 + 0.9 * f64::from(unit(i, 6, seed)),
            i,
        );
    }
    // The dense middle, seen through the gaps.
    for i in 0..3 {
        let angle = f64::from(i) * std::f64::consts::PI / 3.0;
        let out = V3::new(angle.cos(), 0.0, angle.sin());
        card(&mut mesh, common, center, out, 1.7 * radii.x.min(radii.y), i + 1);
    }
    mesh.finish()
}

/// A low bush of a few cards.
pub(crate) fn bush(common: &Common, seed: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..7 {
        let s = |k: i32| f64::from(signed(i, k, seed));
        let at = V3::new(0.45 * s(1), -0.55 + 0.2 * s(2), 0.45 * s(3));
        let out = V3::new(s(4), -0.3, s(5)).normalize();
        card(&mut mesh, common, at, out, 1.1 + 0.2 * s(6), i);
    }
    mesh.finish()
}

/// A square of leaves of the given size around a point.
fn card(mesh: &mut Mesh, common: &Common, at: V3, normal: V3, size: f64, k: i32) {
    let leaves = common.leaves[k.rem_euclid(common.leaves.len() as i32) as usize];
    let right = normal.cross(&V3::y()).try_normalize(1e-6).unwrap_or_else(V3::x);
    let down = normal.cross(&right).normalize();
    // Inner and lower leaves are darker.
    let gain = 0.85 + 0.35 * (0.5 - 0.5 * normal.y) + 0.1 * f64::from((k * 7) % 5) / 5.0;
    let surface = Surface { density: [256.0 / size; 2], gain, ..leaves };
    mesh.quad(at - 0.5 * size * (right + down), right * size, down * size, surface);
}

/// A street lamp: mast, arm over the road (towards -z), head.
pub(crate) fn lamp(common: &Common, height: f64) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.prism(V3::zeros(), height, [0.095, 0.06], 8, common.metal);
    mesh.prism(V3::zeros(), 1.0, [0.13, 0.13], 8, Surface { gain: 0.7, ..common.metal });
    mesh.block(V3::new(-0.04, -height, -1.3), V3::new(0.08, 0.08, 1.3), common.metal, common.metal);
    mesh.block(
        V3::new(-0.14, -height - 0.06, -1.9),
        V3::new(0.28, 0.16, 0.7),
        common.concrete,
        common.concrete,
    );
    mesh.finish()
}

/// A traffic sign on a pole, its plate to the traffic (-z).
pub(crate) fn sign(common: &Common, kind: usize) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.prism(V3::zeros(), 2.9, [0.035, 0.035], 6, common.metal);
    let plate = common.signs[kind % common.signs.len()];
    let size = 0.72;
    let corner = V3::new(-0.5 * size, -2.85, -0.05);
    let fitted = Surface { density: [128.0 / size; 2], ..plate };
    mesh.quad(corner, V3::x() * size, V3::y() * size, fitted);
    let back = V3::new(0.5 * size, -2.85, -0.04);
    mesh.quad(back, -V3::x() * size, V3::y() * size, common.metal);
    mesh.finish()
}

/// A bin, box or cabinet at the curb.
pub(crate) fn cabinet(common: &Common, seed: u32) -> Mesh {
    let r = |k: i32| f64::from(unit(k, 8, seed));
    let mut mesh = Mesh::default();
    let size = V3::new(0.6 + 0.7 * r(0), 0.9 + 0.5 * r(1), 0.45 + 0.25 * r(2));
    let poster = common.signs[(r(3) * common.signs.len() as f64) as usize];
    let sides = Surface { density: [128.0 / size.x, 128.0 / size.y], gain: 0.6 + 0.4 * r(4), ..poster };
    mesh.block(V3::new(-0.5 * size.x, -size.y, -0.5 * size.z), size, sides, common.metal);
    mesh.finish()
}

/// A hedge or wall along x from 0 to `length`, its near side at z = 0.
pub(crate) fn barrier(length: f64, height: f64, surface: Surface, top: Surface) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.block(V3::new(0.0, -height, 0.0), V3::new(length, height, 0.55), surface, top);
    mesh.finish()
}

/// A picket fence along x: posts, rails and pales as boxes.
pub(crate) fn fence(common: &Common, length: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let wood = Surface { gain: 1.2, ..common.bark };
    let pales = (length / 0.32).floor() as i32;
    for i in 0..=pales {
        let x = f64::from(i) * 0.32;
        let post = i % 6 == 0;
        let (w, h) = if post { (0.12, 1.2) } else { (0.09, 1.0) };
        mesh.block(V3::new(x, -h, 0.0), V3::new(w, h, 0.03), wood, wood);
    }
    for up in [0.3, 0.8] {
        mesh.block(V3::new(0.0, -up - 0.08, 0.03), V3::new(length, 0.08, 0.03), wood, wood);
    }
    mesh.finish()
}
