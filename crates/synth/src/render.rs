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
    /// Metres along the optical axis; 0 in the sky.
    pub(crate) depth_m: Raster<f32>,
    pub(crate) labels: Raster<u8>,
}

/// The picture alone.
pub(crate) fn picture(
    view: &View,
    meshes: &[Mesh],
    instances: &[Instance],
    library: &Library,
    shot: &Shot,
) -> GrayImage {
    let prepared = prepare(view, meshes, instances);
    let mut gray = GrayImage::new(WIDTH, HEIGHT, 0);
    gray.data.par_chunks_mut(BAND_ROWS * WIDTH).enumerate().for_each_init(
        Workspace::new,
        |work, (i, rows)| {
            work.draw(i * BAND_ROWS, rows, &prepared, library, shot);
        },
    );
    gray
}

/// The picture with depth and labels.
pub(crate) fn picture_and_truth(
    view: &View,
    meshes: &[Mesh],
    instances: &[Instance],
    library: &Library,
    shot: &Shot,
) -> (GrayImage, Truth) {
    let prepared = prepare(view, meshes, instances);
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
            work.draw(i * BAND_ROWS, rows, &prepared, library, shot);
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
            *depth = if polygon.label == LABEL_SKY { 0.0 } else { polygon.depth_at(x, first + row) };
        }
    }
}
