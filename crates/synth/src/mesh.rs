//! Planar convex polygons with an affine texture mapping, gathered into meshes and placed as instances.

use crate::texture::TextureId;
use nalgebra::{Matrix3, Vector3};

/// Point or direction: x right, y down, z forward; meters.
pub(crate) type V3 = Vector3<f64>;

/// What a polygon looks like.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    pub(crate) texture: TextureId,
    /// Finer texture whose deviation from 128 is added, with its texels per texel of the first, in u and v.
    pub(crate) detail: Option<(TextureId, [f64; 2])>,
    /// Texels per meter in u and v.
    pub(crate) density: [f64; 2],
    /// Texture coordinates (texels) at the mapping's origin.
    pub(crate) offset: [f64; 2],
    /// Factor on the gray value, before light.
    pub(crate) gain: f64,
    pub(crate) kind: SurfaceKind,
}

/// How a polygon takes part in drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SurfaceKind {
    /// Seen from its outer side only.
    Solid,
    /// Seen from both sides, drawn where the texture's opacity passes the test.
    CutOut,
    /// Lies on another surface (road marks): wins over it.
    Decal,
    /// Sends out its own light, without haze: the sky.
    Emissive,
}

/// A convex planar polygon; `vertices` index its mesh.
#[derive(Clone, Debug)]
pub(crate) struct Polygon {
    pub(crate) first: u32,
    pub(crate) count: u32,
    /// Unit normal towards the visible side.
    pub(crate) normal: V3,
    /// Texture coordinate u = gradient . point + constant (texels), likewise v.
    pub(crate) u: (V3, f64),
    pub(crate) v: (V3, f64),
    pub(crate) surface: Surface,
}

/// Polygons in one local frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    pub(crate) vertices: Vec<V3>,
    pub(crate) polygons: Vec<Polygon>,
    /// Center and radius of a sphere around all vertices.
    pub(crate) center: V3,
    pub(crate) radius: f64,
}

impl Mesh {
    /// Adds a convex polygon whose corners run clockwise as seen from its visible side; u grows along `u_axis`, v along `v_axis`
    /// (unit vectors in the plane), both counted from the first corner.
    pub(crate) fn add(&mut self, corners: &[V3], u_axis: V3, v_axis: V3, surface: Surface) {
        // y points down: clockwise corners as seen give a normal towards the viewer with this order of the product.
        let normal = (corners[2] - corners[0]).cross(&(corners[1] - corners[0])).normalize();
        let map = |axis: V3, i: usize| {
            let gradient = axis * surface.density[i];
            (gradient, surface.offset[i] - gradient.dot(&corners[0]))
        };
        let (u, v) = (map(u_axis, 0), map(v_axis, 1));
        let first = self.vertices.len() as u32;
        self.vertices.extend_from_slice(corners);
        self.polygons.push(Polygon { first, count: corners.len() as u32, normal, u, v, surface });
    }

    /// Adds a parallelogram: `origin` is its top left corner seen from the visible side, `right` and `down` its sides.
    pub(crate) fn quad(&mut self, origin: V3, right: V3, down: V3, surface: Surface) {
        let corners = [origin, origin + right, origin + right + down, origin + down];
        self.add(&corners, right.normalize(), down.normalize(), surface);
    }

    /// Adds a box without its bottom; `near` is the upper left near corner, the sides run along x (width), y (height), z (depth).
    /// `sides` dresses the four walls, `top` the upper face.
    pub(crate) fn block(&mut self, near: V3, size: V3, sides: Surface, top: Surface) {
        let (x, y, z) = (V3::x() * size.x, V3::y() * size.y, V3::z() * size.z);
        self.quad(near, x, y, sides);
        self.quad(near + x, z, y, sides);
        self.quad(near + x + z, -x, y, sides);
        self.quad(near + z, -z, y, sides);
        self.quad(near + z, x, -z, top);
    }

    /// Adds the walls of an upright tapered prism with `n` sides from `bottom` (center) up to `height`, radii at bottom and top.
    pub(crate) fn prism(&mut self, bottom: V3, height: f64, radii: [f64; 2], n: usize, surface: Surface) {
        let corner = |i: usize, top: bool| {
            let angle = std::f64::consts::TAU * i as f64 / n as f64;
            let (r, y) = if top { (radii[1], bottom.y - height) } else { (radii[0], bottom.y) };
            V3::new(bottom.x + r * angle.cos(), y, bottom.z + r * angle.sin())
        };
        for i in 0..n {
            let mut surface = surface;
            surface.offset[0] += i as f64 * 37.0;
            // Seen from outside, the angle (x towards z) grows to the right.
            let corners = [corner(i, true), corner(i + 1, true), corner(i + 1, false), corner(i, false)];
            let u = (corners[2] - corners[3]).normalize();
            self.add(&corners, u, V3::y(), surface);
        }
    }

    /// Computes the bounding sphere; call once all polygons are there.
    pub(crate) fn finish(mut self) -> Self {
        let (mut low, mut high) = (V3::repeat(f64::INFINITY), V3::repeat(f64::NEG_INFINITY));
        for p in &self.vertices {
            low = low.inf(p);
            high = high.sup(p);
        }
        self.center = (low + high) / 2.0;
        self.radius = self.vertices.iter().map(|p| (p - self.center).norm()).fold(0.0, f64::max);
        self
    }
}

/// Position and heading of an object on the ground plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    pub(crate) position: V3,
    /// Rotation about the downward axis, radians; 0 looks along z, positive to the right.
    pub(crate) yaw: f64,
}

impl Placement {
    /// At the world's origin.
    pub(crate) fn identity() -> Self {
        Self { position: V3::zeros(), yaw: 0.0 }
    }

    /// Rotation world_from_object.
    pub(crate) fn rotation(&self) -> Matrix3<f64> {
        yaw_matrix(self.yaw)
    }

    /// World coordinates of a point of the object.
    pub(crate) fn apply(&self, point: &V3) -> V3 {
        self.rotation() * point + self.position
    }
}

/// Rotation about y (down): z turns towards x for positive angles.
pub(crate) fn yaw_matrix(yaw: f64) -> Matrix3<f64> {
    let (s, c) = yaw.sin_cos();
    Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
}

/// When an instance is drawn: near things first, so that hidden samples are skipped early.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Layer {
    /// Everything that stands up.
    Object,
    /// Road, walks and ground.
    Ground,
    /// Behind everything.
    Sky,
}

/// A mesh placed in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instance {
    pub(crate) mesh: u32,
    pub(crate) placement: Placement,
    pub(crate) layer: Layer,
    /// Value in the label image.
    pub(crate) label: u8,
    /// Factor on all gray values.
    pub(crate) gain: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface() -> Surface {
        Surface {
            texture: TextureId(0),
            detail: None,
            density: [10.0, 10.0],
            offset: [0.0; 2],
            gain: 1.0,
            kind: SurfaceKind::Solid,
        }
    }

    #[test]
    fn faces_of_a_block_look_outwards() {
        let mut mesh = Mesh::default();
        mesh.block(V3::new(-1.0, -2.0, 4.0), V3::new(2.0, 2.0, 3.0), surface(), surface());
        mesh.prism(V3::new(0.0, 0.0, 5.5), 2.0, [0.8, 0.5], 7, surface());
        let mesh = mesh.finish();
        assert_eq!(mesh.polygons.len(), 12);
        for polygon in &mesh.polygons {
            let corner = mesh.vertices[polygon.first as usize];
            let axis = V3::new(0.0, -1.0, 5.5);
            assert!(polygon.normal.dot(&(corner - axis)) > 0.0, "{:?}", polygon.normal);
        }
    }

    #[test]
    fn front_face_maps_u_to_the_right_and_v_down() {
        let mut mesh = Mesh::default();
        mesh.quad(V3::new(1.0, -3.0, 5.0), V3::x() * 2.0, V3::y() * 3.0, surface());
        let p = &mesh.polygons[0];
        assert!((p.normal - V3::new(0.0, 0.0, -1.0)).norm() < 1e-12);
        let at = V3::new(2.5, -1.0, 5.0);
        assert!((p.u.0.dot(&at) + p.u.1 - 15.0).abs() < 1e-9);
        assert!((p.v.0.dot(&at) + p.v.1 - 20.0).abs() < 1e-9);
    }
}
