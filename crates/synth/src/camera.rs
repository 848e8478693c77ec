//! The camera, and what it sees of the world: transformed, culled, clipped polygons ready for scan conversion.

use crate::daylight::{Haze, Light};
use crate::mesh::{Instance, Layer, Mesh, Surface, SurfaceKind, V3};
use geometry::Pinhole;
use nalgebra::Matrix3;

/// Image width in pixels (KITTI).
pub(crate) const WIDTH: usize = 1241;
/// Image height in pixels (KITTI).
pub(crate) const HEIGHT: usize = 376;
/// Samples per pixel and direction; the image is the mean over this square.
pub(crate) const SAMPLES: usize = 2;

/// Nothing nearer than this is drawn, meters.
const NEAR_M: f64 = 0.25;
/// Objects beyond are not drawn, meters.
const FAR_M: f64 = 320.0;
/// Objects with a smaller radius in the image are not drawn, pixels.
const MIN_RADIUS_PX: f64 = 0.8;
/// Leafy cards are not drawn when the view is nearly along them: sine of the angle.
const EDGE_ON: f64 = 0.1;
/// A decal counts as nearer by this share.
const DECAL_BIAS: f64 = 4e-4;
const MAX_CORNERS: usize = 12;

/// A camera in the world.
#[derive(Clone, Debug)]
pub(crate) struct View {
    /// Rotation cam_from_world.
    pub(crate) rotation: Matrix3<f64>,
    /// Camera center in the world.
    pub(crate) center: V3,
    pub(crate) camera: Pinhole,
}

/// A side of a polygon in sample coordinates, upper end first.
#[derive(Clone, Copy, Debug, Default)]
struct Edge {
    pub(crate) top: f64,
    pub(crate) bottom: f64,
    /// x at row 0 would be `x - top * slope`; here x at `top`.
    pub(crate) x: f64,
    pub(crate) slope: f64,
}

/// A polygon as the rasteriser needs it. Affine functions of the sample position are `[constant, per x, per y]`.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    pub(crate) outline: Outline,
    pub(crate) planes: Planes,
    pub(crate) surface: Surface,
    /// Brightness under the light, the surface's own included.
    pub(crate) gain: f32,
    pub(crate) haze: Haze,
    /// Factor on inverse depth in the depth test.
    pub(crate) bias: f64,
    pub(crate) label: u8,
}

/// Sample coordinate of a pixel coordinate: samples lie at integers, pixel centers between them.
pub(crate) fn sample_of_pixel(pixel: f64) -> f64 {
    SAMPLES as f64 * (pixel + 0.5) - 0.5
}

/// All polygons of `instances` that can be seen, nearest objects first, then ground, then sky.
pub(crate) fn prepare(view: &View, meshes: &[Mesh], instances: &[Instance], light: &Light) -> Vec<Prepared> {
    let mut order: Vec<(Layer, f64, usize)> = instances
        .iter()
        .enumerate()
        .filter_map(|(i, instance)| {
            let mesh = &meshes[instance.mesh as usize];
            let center = view.rotation * (instance.placement.apply(&mesh.center) - view.center);
            let near = center.norm() - mesh.radius;
            let seen = instance.layer == Layer::Sky || may_be_seen(view, &center, mesh.radius);
            seen.then_some((instance.layer, near, i))
        })
        .collect();
    order.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut prepared = Vec::with_capacity(order.len() * 8);
    for (_, _, i) in order {
        prepare_instance(view, &meshes[instances[i].mesh as usize], &instances[i], light, &mut prepared);
    }
    prepared
}

/// Tests a sphere (camera frame) against the view pyramid, the far limit and the least size.
fn may_be_seen(view: &View, center: &V3, radius: f64) -> bool {
    let camera = &view.camera;
    if center.z + radius < NEAR_M {
        return false;
    }
    let distance = center.norm();
    if distance - radius > FAR_M || radius * camera.fx < MIN_RADIUS_PX * distance {
        return false;
    }
    // Signed distance to a side plane whose inner normal is (slope_x, slope_y, slope_z), not normalized.
    let outside = |x: f64, y: f64, z: f64| {
        (x * center.x + y * center.y + z * center.z) < -radius * (x * x + y * y + z * z).sqrt()
    };
    let (w, h) = (WIDTH as f64, HEIGHT as f64);
    !(outside(camera.fx, 0.0, camera.cx + 1.0)
        || outside(-camera.fx, 0.0, w - camera.cx)
        || outside(0.0, camera.fy, camera.cy + 1.0)
        || outside(0.0, -camera.fy, h - camera.cy))
}

fn prepare_instance(view: &View, mesh: &Mesh, instance: &Instance, light: &Light, out: &mut Vec<Prepared>) {
    let rotation = view.rotation * instance.placement.rotation();
    let translation = view.rotation * (instance.placement.position - view.center);
    let vertices: Vec<V3> = mesh.vertices.iter().map(|p| rotation * p + translation).collect();
    let sun_cam = view.rotation * light.sun;
    for polygon in &mesh.polygons {
        let corners = &vertices[polygon.first as usize..(polygon.first + polygon.count) as usize];
        let normal = rotation * polygon.normal;
        // Plane: normal . p = offset; the eye is on the outer side when the offset is negative.
        let offset = normal.dot(&corners[0]);
        let two_sided = polygon.surface.kind == SurfaceKind::CutOut;
        let edge_on = if two_sided { EDGE_ON * corners[0].norm() } else { 1e-5 };
        if offset.abs() < edge_on || (offset > 0.0 && !two_sided) {
            continue;
        }
        let Some(outline) = Outline::new(view, corners) else { continue };
        let gain =
            polygon.surface.gain * instance.gain * brightness(light, &normal, &sun_cam, polygon.surface.kind);
        let texture = |map: &(V3, f64)| {
            let gradient = rotation * map.0;
            (gradient, map.1 - gradient.dot(&translation))
        };
        let planes = Planes::new(view, &normal, offset, texture(&polygon.u), texture(&polygon.v));
        let bias = if polygon.surface.kind == SurfaceKind::Decal { 1.0 + DECAL_BIAS } else { 1.0 };
        let (surface, gain, haze, label) = (polygon.surface, gain as f32, light.haze(), instance.label);
        out.push(Prepared { outline, planes, surface, gain, haze, bias, label });
    }
}

/// Factor on a surface's gray value.
fn brightness(light: &Light, normal: &V3, sun_cam: &V3, kind: SurfaceKind) -> f64 {
    let Light { ambient, direct, .. } = light;
    match kind {
        SurfaceKind::Emissive => light.sky,
        // Leaves scatter: both sides are equally bright.
        SurfaceKind::CutOut => ambient + 0.6 * direct * normal.dot(sun_cam).abs(),
        SurfaceKind::Solid | SurfaceKind::Decal => ambient + direct * normal.dot(sun_cam).max(0.0),
    }
}

/// The affine functions of a plane in sample coordinates: inverse depth (1/m), and texture coordinates over depth (texels/m).
#[derive(Clone, Debug)]
pub(crate) struct Planes {
    pub(crate) inv_z: [f64; 3],
    pub(crate) u_over_z: [f64; 3],
    pub(crate) v_over_z: [f64; 3],
}

impl Planes {
    /// With the ray r = (x, y, 1) of a sample and its point r z on the plane n . p = d: 1/z = n . r / d, and for a texture
    /// coordinate u = g . p + c: u/z = g . r + c/z.
    fn new(view: &View, normal: &V3, offset: f64, u: (V3, f64), v: (V3, f64)) -> Self {
        let camera = &view.camera;
        let affine = |g: &V3| {
            let (bx, by) = (g.x / camera.fx, g.y / camera.fy);
            let s = SAMPLES as f64;
            // Pixel = (sample + 0.5) / s - 0.5.
            let origin = 0.5 / s - 0.5;
            [g.z + bx * (origin - camera.cx) + by * (origin - camera.cy), bx / s, by / s]
        };
        let inv_z = affine(&(normal / offset));
        let over_z = |(gradient, constant): (V3, f64)| {
            let a = affine(&gradient);
            [0, 1, 2].map(|i| a[i] + constant * inv_z[i])
        };
        Self { inv_z, u_over_z: over_z(u), v_over_z: over_z(v) }
    }

    /// Depth in meters at a pixel, on the polygon's plane.
    pub(crate) fn depth_at(&self, x: usize, y: usize) -> f32 {
        let [c, dx, dy] = self.inv_z;
        let inv_z = c + dx * sample_of_pixel(x as f64) + dy * sample_of_pixel(y as f64);
        (1.0 / inv_z.max(1e-4)) as f32
    }
}

/// A polygon's outline in sample coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    edges: [Edge; MAX_CORNERS],
    n_edges: usize,
    pub(crate) top: f64,
    pub(crate) bottom: f64,
}

impl Outline {
    /// Clips at the near plane and projects; `None` when nothing is inside the image.
    fn new(view: &View, corners: &[V3]) -> Option<Self> {
        let (mut points, mut n) = ([[0.0; 2]; MAX_CORNERS], 0);
        let mut push = |p: V3| {
            let (x, y) = (p.x / p.z * view.camera.fx, p.y / p.z * view.camera.fy);
            if n < MAX_CORNERS {
                points[n] = [sample_of_pixel(x + view.camera.cx), sample_of_pixel(y + view.camera.cy)];
                n += 1;
            }
        };
        for (i, a) in corners.iter().enumerate() {
            let b = &corners[(i + 1) % corners.len()];
            if a.z >= NEAR_M {
                push(*a);
            }
            if (a.z >= NEAR_M) != (b.z >= NEAR_M) {
                // Ordered by depth, so that two polygons that share this side cut it at the same point.
                let (near, far) = if a.z < b.z { (a, b) } else { (b, a) };
                let mut cut = near + (far - near) * ((NEAR_M - near.z) / (far.z - near.z));
                cut.z = NEAR_M;
                push(cut);
            }
        }
        if n < 3 {
            return None;
        }
        let points = &points[..n];
        let range = |axis: usize| {
            points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
                (f64::min(low, p[axis]), f64::max(high, p[axis]))
            })
        };
        let ((left, right), (top, bottom)) = (range(0), range(1));
        let (w, h) = ((WIDTH * SAMPLES) as f64, (HEIGHT * SAMPLES) as f64);
        if right < 0.0 || left > w || bottom < 0.0 || top > h {
            return None;
        }
        let mut edges = [Edge::default(); MAX_CORNERS];
        for (i, edge) in edges.iter_mut().take(n).enumerate() {
            let (a, b) = (points[i], points[(i + 1) % n]);
            let (upper, lower) = if a[1] <= b[1] { (a, b) } else { (b, a) };
            let height = lower[1] - upper[1];
            let slope = if height > 0.0 { (lower[0] - upper[0]) / height } else { 0.0 };
            *edge = Edge { top: upper[1], bottom: lower[1], x: upper[0], slope };
        }
        Some(Self { edges, n_edges: n, top, bottom })
    }

    /// First and one-past-last sample column of a sample row; empty when the row misses the polygon.
    pub(crate) fn columns(&self, row: i32) -> (i32, i32) {
        let y = f64::from(row);
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for edge in &self.edges[..self.n_edges] {
            if edge.top <= y && y < edge.bottom {
                let x = edge.x + (y - edge.top) * edge.slope;
                left = left.min(x);
                right = right.max(x);
            }
        }
        if left > right {
            return (0, 0);
        }
        let limit = (WIDTH * SAMPLES) as f64;
        (left.ceil().clamp(0.0, limit) as i32, right.ceil().clamp(0.0, limit) as i32)
    }
}
