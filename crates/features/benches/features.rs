//! Times of the stages on one KITTI stereo pair, or on a made one where `DSSLAM_DATA` names no data.
//!
//! For a single thread set `RAYON_NUM_THREADS=1`.

use criterion::{Criterion, criterion_group, criterion_main};
use dsslam_features::{
    ActivationError, ActivationMap, ActivationSource, DepthConfig, EpipolarRange, Extractor, ExtractorConfig,
    Frame, FrameBuilder, InTurn, ProjectionQuery, RemapTable, Rig, SelectionConfig, SelectionRule, Spread,
    StereoConfig, match_brute_force, remap, search_epipolar_all, search_windows,
};
use geometry::{CameraModel, Distortion, GrayImage, Pinhole, Raster, SE3, SO3, StereoRig, Vec3};
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

const FRAMES: [&str; 2] = ["kitti06_first51/image_0/000020.png", "kitti06_first51/image_1/000020.png"];

/// Left and right image, and where they come from.
fn images() -> (GrayImage, GrayImage, &'static str) {
    let data = std::env::var("DSSLAM_DATA").unwrap_or_default();
    let load = |name: &str| {
        let image = image::open(Path::new(&data).join(name)).ok()?.into_luma8();
        let (width, height) = (image.width() as usize, image.height() as usize);
        GrayImage::from_vec(width, height, image.into_raw())
    };
    match FRAMES.map(load) {
        [Some(left), Some(right)] => (left, right, "kitti06"),
        _ => (made(0), made(30), "made"),
    }
}

/// Blocks of random brightness under ramps, moved by `shift` pixels.
fn made(shift: usize) -> GrayImage {
    GrayImage::from_fn(1241, 376, |x, y| {
        let x = x + shift;
        let noise = geometry::mix_seed(1, (x / 6) as u64, (y / 5) as u64) >> 57;
        (noise as usize + (x + y) % 90) as u8
    })
}

fn rig(image: &GrayImage) -> Arc<Rig> {
    let camera = Pinhole { fx: 707.0912, fy: 707.0912, cx: 601.8873, cy: 183.1104 };
    let distortion = Distortion { k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0, k3: 0.0 };
    let stereo = StereoRig { camera, baseline_m: 0.5372 };
    Arc::new(Rig { stereo, distortion, width: image.width, height: image.height })
}

fn stages(criterion: &mut Criterion) {
    let (left, right, source) = images();
    let mut group = criterion.benchmark_group(source);
    group.sample_size(40);
    let mut extractor = Extractor::new(ExtractorConfig::default());
    group.bench_function("extract 2000", |b| b.iter(|| black_box(extractor.extract(&left))));
    let mut few = Extractor::new(ExtractorConfig { keep: 500, ..ExtractorConfig::default() });
    group.bench_function("extract 500", |b| b.iter(|| black_box(few.extract(&left))));

    let configs = (ExtractorConfig::default(), StereoConfig::default(), DepthConfig::default());
    let mut builder = FrameBuilder::new(rig(&left), configs.0, configs.1, configs.2);
    group.bench_function("stereo frame", |b| {
        b.iter(|| black_box(builder.stereo(0, 0.0, &left, &right).expect("no selection can fail").0))
    });

    let mut choosing = choosing(&left);
    let mut index = 0;
    group.bench_function("stereo frame, 500 by activation", |b| {
        b.iter(|| {
            index += 1;
            black_box(choosing.stereo(index, 0.0, &left, &right).expect("the map is given").0)
        });
    });

    let frame = builder.stereo(0, 0.0, &left, &right).expect("no selection can fail").0;
    let queries: Vec<ProjectionQuery> = (0..frame.len()).map(|i| query(&frame, i)).collect();
    let free = vec![true; frame.len()];
    group.bench_function("windows", |b| b.iter(|| black_box(search_windows(&frame, &queries, &free))));
    let all: Vec<u32> = (0..frame.len() as u32).collect();
    let forward = SE3::new(SO3::identity(), Vec3::new(0.0, 0.0, -1.0));
    let range = EpipolarRange { min_depth_m: 2.0, max_depth_m: f64::INFINITY, max_distance: 50 };
    group.bench_function("epipolar", |b| {
        b.iter(|| black_box(search_epipolar_all(&frame, &all, &frame, &forward, &range, &free)));
    });
    group.bench_function("brute force", |b| {
        b.iter(|| black_box(match_brute_force(&frame.descriptors, &frame.descriptors, 50, 0.8)));
    });
    group.finish();
}

/// An activation map that costs nothing.
#[derive(Debug)]
struct Given(ActivationMap);

impl ActivationSource for Given {
    fn activation(&self, _: &GrayImage) -> Result<ActivationMap, ActivationError> {
        Ok(self.0.clone())
    }
}

/// A builder that keeps 500 of 2000 candidates by the map of every second image.
fn choosing(image: &GrayImage) -> FrameBuilder {
    let cell = |x: usize, y: usize| {
        if geometry::mix_seed(3, x as u64 / 16, y as u64 / 8) & 7 == 0 { 0.0 } else { 1.0 }
    };
    let map = ActivationMap::new(Raster::from_fn(208, 64, cell), image.width, image.height).expect("values");
    let selection = SelectionRule::Activation;
    let config = ExtractorConfig { keep: 500, selection, network_every: 2, ..ExtractorConfig::default() };
    let rule = SelectionConfig { rule: selection, keep: 500, spread: Spread::Cells };
    FrameBuilder::new(rig(image), config, StereoConfig::default(), DepthConfig::default())
        .with_selection(rule, Box::new(InTurn::new(Arc::new(Given(map)))))
}

/// Rectification of an image of EuRoC's size.
fn rectification(criterion: &mut Criterion) {
    let camera = Pinhole { fx: 458.654, fy: 457.296, cx: 367.215, cy: 248.375 };
    let distortion = Distortion { k1: -0.283_408, k2: 0.073_959, p1: 0.000_194, p2: 0.000_018, k3: 0.0 };
    let model = CameraModel::Pinhole { camera, distortion };
    let (turn, size) = (SO3::exp(&Vec3::new(0.01, 0.02, 0.03)), (752, 480));
    let target = Pinhole { fx: 436.0, fy: 436.0, cx: 364.0, cy: 257.0 };
    let make = || RemapTable::rectifying(&model, &turn, &target, size, size);
    criterion.bench_function("table of a 752x480 rectification", |b| b.iter(make));
    let (table, texture) = (make(), made(0));
    let image = GrayImage::from_fn(size.0, size.1, |x, y| texture.at(x, y % 376));
    criterion.bench_function("remap 752x480", |b| b.iter(|| black_box(remap(&image, &table))));
}

fn query(frame: &Frame, i: usize) -> ProjectionQuery {
    let keypoint = frame.keypoints[i];
    ProjectionQuery {
        x: keypoint.x + 3.0,
        y: keypoint.y - 2.0,
        right_u: f32::NAN,
        radius_px: 10.0 * frame.scales.scales[usize::from(keypoint.octave)],
        min_octave: keypoint.octave.saturating_sub(1),
        max_octave: keypoint.octave + 1,
        descriptor: frame.descriptors[i],
    }
}

criterion_group!(benches, stages, rectification);
criterion_main!(benches);
