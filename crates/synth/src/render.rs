//! Draws a view in bands of rows, in parallel; every band is computed alone, so that the bytes do not depend on the threads.

use crate::camera::{HEIGHT, Prepared, View, WIDTH, prepare};
use crate::library::Library;
use crate::mesh::{Instance, Mesh};
use crate::raster::Band;
use crate::sensor::Shot;
use crate::town::LABEL_SKY;
use geometry::{GrayImage, Raster};
use rayon::prelude::*;

/// Pixel rows drawn at a time: the sample buffers fit a core's cache.
const BAND_ROWS: usize = 8;

/// What the left camera truly sees.
#[derive(Clone, Debug)]
pub(crate) struct Truth {
    /// Meters along the optical axis; 0 in the sky.
    pub(crate) depth_m: Raster<f32>,
    pub(crate) labels: Raster<u8>,
}

/// What a world is made of: meshes and the textures on them.
#[derive(Debug)]
pub(crate) struct Shapes {
    pub(crate) meshes: Vec<Mesh>,
    pub(crate) library: Library,
}

/// The picture alone.
pub(crate) fn picture(view: &View, shapes: &Shapes, instances: &[Instance], shot: &Shot) -> GrayImage {
    let prepared = prepare(view, &shapes.meshes, instances, &shot.light);
    let mut gray = GrayImage::new(WIDTH, HEIGHT, 0);
    let bands = gray.data.par_chunks_mut(BAND_ROWS * WIDTH).enumerate();
    bands.for_each_init(Workspace::new, |work, (i, rows)| {
        work.draw(i * BAND_ROWS, rows, &prepared, &shapes.library, shot);
    });
    gray
}

/// The picture with depth and labels.
pub(crate) fn picture_and_truth(
    view: &View,
    shapes: &Shapes,
    instances: &[Instance],
    shot: &Shot,
) -> (GrayImage, Truth) {
    let prepared = prepare(view, &shapes.meshes, instances, &shot.light);
    let mut gray = GrayImage::new(WIDTH, HEIGHT, 0);
    let mut depth_m = Raster::new(WIDTH, HEIGHT, 0.0);
    let mut labels = Raster::new(WIDTH, HEIGHT, LABEL_SKY);
    let size = BAND_ROWS * WIDTH;
    gray.data
        .par_chunks_mut(size)
        .zip(depth_m.data.par_chunks_mut(size))
        .zip(labels.data.par_chunks_mut(size))
        .enumerate()
        .for_each_init(Workspace::new, |work, (i, ((rows, depth), labels))| {
            work.draw(i * BAND_ROWS, rows, &prepared, &shapes.library, shot);
            work.truth(i * BAND_ROWS, &prepared, depth, labels);
        });
    (gray, Truth { depth_m, labels })
}

/// Buffers of a worker, used again for each of its bands.
struct Workspace {
    band: Band,
    tones: Vec<u16>,
}

impl Workspace {
    fn new() -> Self {
        Self { band: Band::new(BAND_ROWS), tones: vec![0; WIDTH] }
    }

    fn draw(&mut self, first: usize, rows: &mut [u8], prepared: &[Prepared], library: &Library, shot: &Shot) {
        self.band.start(first, rows.len() / WIDTH);
        for (i, polygon) in prepared.iter().enumerate() {
            // 0 stands for nothing seen.
            self.band.draw(polygon, i as u32 + 1, library);
        }
        for (i, row) in rows.chunks_exact_mut(WIDTH).enumerate() {
            self.band.resolve(i, &mut self.tones);
            shot.expose(first + i, &self.tones, row);
        }
    }

    fn truth(&self, first: usize, prepared: &[Prepared], depth: &mut [f32], labels: &mut [u8]) {
        for (i, (depth, label)) in depth.iter_mut().zip(labels).enumerate() {
            let (row, x) = (i / WIDTH, i % WIDTH);
            let Some(polygon) = (self.band.winner(row, x) as usize).checked_sub(1).map(|k| &prepared[k])
            else {
                continue;
            };
            *label = polygon.label;
            *depth = if polygon.label == LABEL_SKY { 0.0 } else { polygon.planes.depth_at(x, first + row) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::daylight::Light;
    use crate::library::Recipe;
    use crate::materials::Material;
    use crate::mesh::{Layer, Placement, Surface, SurfaceKind, V3};
    use crate::sensor::{Eye, Sensor};
    use crate::texture::TextureId;
    use geometry::Pinhole;
    use nalgebra::Matrix3;

    fn view() -> View {
        let camera = Pinhole { fx: 700.0, fy: 700.0, cx: 620.0, cy: 188.0 };
        View { rotation: Matrix3::identity(), center: V3::zeros(), camera }
    }

    fn surface(kind: SurfaceKind) -> Surface {
        Surface { texture: TextureId(0), detail: None, density: [40.0; 2], offset: [0.0; 2], gain: 1.0, kind }
    }

    /// A wall facing the camera: left upper corner and size.
    fn wall(corner: V3, width: f64, height: f64) -> Mesh {
        let mut mesh = Mesh::default();
        mesh.quad(corner, V3::x() * width, V3::y() * height, surface(SurfaceKind::Solid));
        mesh.finish()
    }

    /// Draws meshes with labels 0, 1, 2 ...
    fn draw(meshes: &[Mesh]) -> (GrayImage, Truth) {
        let instances: Vec<Instance> = (0..meshes.len())
            .map(|i| Instance {
                mesh: i as u32,
                placement: Placement::identity(),
                layer: Layer::Object,
                label: i as u8,
                gain: 1.0,
            })
            .collect();
        let library = Library::bake(&[Recipe::Material(Material::Concrete, 1)]);
        let shot = Sensor::new(1).shot(Eye::Left, 0, 0.0, Light::noon());
        picture_and_truth(&view(), &Shapes { meshes: meshes.to_vec(), library }, &instances, &shot)
    }

    #[test]
    fn a_wall_covers_exactly_its_pixels_at_its_depth() {
        // At 10 m a pixel is 1/70 m: columns 550..=689, rows 118..=257 have their centers inside.
        let edge = |pixels: f64| (pixels - 0.5) / 70.0;
        let (_, truth) = draw(&[wall(V3::new(edge(-70.0), edge(-70.0), 10.0), 2.0, 2.0)]);
        for y in 0..HEIGHT {
            for x in 0..WIDTH {
                let inside = (550..690).contains(&x) && (118..258).contains(&y);
                assert_eq!(truth.labels.at(x, y), if inside { 0 } else { LABEL_SKY }, "{x} {y}");
                assert!((truth.depth_m.at(x, y) - if inside { 10.0 } else { 0.0 }).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn the_nearer_surface_wins_in_any_order() {
        let near = || wall(V3::new(-1.0, -1.0, 8.0), 2.0, 2.0);
        let far = || wall(V3::new(-4.0, -4.0, 12.0), 8.0, 8.0);
        let (a, b) = (draw(&[near(), far()]).1, draw(&[far(), near()]).1);
        assert!(a.depth_m == b.depth_m);
        assert_eq!((a.labels.at(620, 188), b.labels.at(620, 188)), (0, 1));
        assert_eq!((a.labels.at(800, 188), b.labels.at(800, 188)), (1, 0));
    }

    #[test]
    fn ground_from_under_the_camera_to_the_horizon_has_the_depth_of_its_plane() {
        let mut ground = Mesh::default();
        let corners = [[-300.0, 300.0], [300.0, 300.0], [300.0, -300.0], [-300.0, -300.0]];
        let corners = corners.map(|[x, z]| V3::new(x, 1.65, z));
        ground.add(&corners, V3::x(), -V3::z(), surface(SurfaceKind::Solid));
        let (_, truth) = draw(&[ground.finish()]);
        for y in 200..HEIGHT {
            for x in [0, 333, 620, 1240] {
                let expected = 1.65 * 700.0 / (y as f64 - 188.0);
                assert!((f64::from(truth.depth_m.at(x, y)) / expected - 1.0).abs() < 1e-5, "{x} {y}");
            }
        }
        assert_eq!(truth.labels.at(620, 180), LABEL_SKY);
    }

    #[test]
    fn surfaces_that_share_an_edge_leave_no_crack() {
        // A fan of triangles around a point that is not a pixel center.
        let mut fan = Mesh::default();
        let rim = |i: i32| {
            let angle = f64::from(i) * std::f64::consts::TAU / 13.0;
            V3::new(0.013 + 9.0 * angle.cos(), 0.021 + 9.0 * angle.sin(), 5.0)
        };
        for i in 0..13 {
            fan.add(
                &[V3::new(0.013, 0.021, 5.0), rim(i), rim(i + 1)],
                V3::x(),
                V3::y(),
                surface(SurfaceKind::Solid),
            );
        }
        let (gray, truth) = draw(&[fan.finish()]);
        assert!(truth.labels.data.iter().all(|l| *l == 0));
        assert!(gray.data.iter().all(|g| *g > 30), "{:?}", gray.data.iter().min());
    }
}
