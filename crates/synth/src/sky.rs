//! Clouds on a wide plane high above, and a bright band at the horizon.

use crate::library::Common;
use crate::mesh::{Mesh, Surface, V3};

/// Height of the clouds, meters.
const CLOUDS_M: f64 = 1600.0;
/// How far the cloud plane reaches, and the distance of the horizon's band, meters.
const REACH_M: f64 = 60_000.0;
const BAND_M: f64 = 6_000.0;

/// The sky around a world whose middle is `center`.
pub(crate) fn build(common: &Common, center: V3) -> Mesh {
    let mut mesh = Mesh::default();
    let corner = |x: f64, z: f64| V3::new(center.x + x * REACH_M, -CLOUDS_M, center.z + z * REACH_M);
    // Seen from below.
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    mesh.add(&corners, V3::x(), V3::z(), common.clouds);
    let band = Surface { density: [1.0 / 40.0, 1.0 / 40.0], gain: 1.03, ..common.clouds };
    let n = 12;
    let rim = |i: i32, up: f64| {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        center + V3::new(BAND_M * angle.cos(), -up, BAND_M * angle.sin())
    };
    for i in 0..n {
        // Seen from inside.
        let corners = [rim(i + 1, 190.0), rim(i, 190.0), rim(i, -400.0), rim(i + 1, -400.0)];
        let right = (corners[1] - corners[0]).normalize();
        mesh.add(&corners, right, V3::y(), band);
    }
    mesh.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::library::Recipes;

    #[test]
    fn the_sky_faces_its_middle() {
        let common = Common::new(&mut Recipes::default(), 1);
        let mesh = build(&common, V3::new(100.0, 0.0, 50.0));
        for p in &mesh.polygons {
            let corner = mesh.vertices[p.first as usize];
            assert!(p.normal.dot(&(V3::new(100.0, -1.65, 50.0) - corner)) > 0.0);
        }
    }
}
