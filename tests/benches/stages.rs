//! Each stage alone on real frames, on one thread, beside OpenCV's ORB of one image in the same process (the unit U).
//!
//! `DSSLAM_DATA=... cargo bench -p dsslam-tests --bench stages`. Without real sequences there is nothing to measure.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark stops at the first problem")]

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use features::{
    DepthConfig, Extractor, ExtractorConfig, Frame, FrameBuilder, InTurn, ProjectionQuery, Rig,
    SelectionConfig, SelectionRule, Spread, StereoConfig, search_windows,
};
use geometry::{GrayImage, SE3, Vec3, Vec6};
use optim::{
    BundleObservation, BundleOptions, BundleProblem, PoseObservation, PoseOptions, refine_bundle, refine_pose,
};

/// Two successive stereo pairs with their camera.
struct Input {
    rig: Arc<Rig>,
    pairs: Vec<[GrayImage; 2]>,
}

impl Input {
    /// The first two pairs of kitti06_first51, if `DSSLAM_DATA` is set.
    fn load() -> Option<Self> {
        let folder = Path::new(&std::env::var_os("DSSLAM_DATA")?).join("kitti06_first51");
        let sequence = io::open_sequence(&folder, Some(io::Sensor::Stereo)).unwrap();
        let calibration = sequence.calibration.clone().unwrap();
        let load = |frame: &io::FrameSource| {
            let loaded = io::load_frame(frame).unwrap();
            [loaded.left, loaded.right.unwrap()]
        };
        let pairs: Vec<_> = sequence.frames.iter().take(2).map(load).collect();
        let (width, height) = (pairs[0][0].width, pairs[0][0].height);
        let rig = Rig { stereo: calibration.rig, distortion: calibration.distortion, width, height };
        Some(Self { rig: Arc::new(rig), pairs })
    }

    fn builder(&self) -> FrameBuilder {
        let stereo = StereoConfig::default();
        FrameBuilder::new(self.rig.clone(), ExtractorConfig::default(), stereo, DepthConfig::default())
    }

    fn frames(&self) -> [Frame; 2] {
        let mut builder = self.builder();
        [0, 1].map(|i| {
            builder.stereo(i as u32, i as f64 * 0.1, &self.pairs[i][0], &self.pairs[i][1]).unwrap().0
        })
    }
}

/// Features of `from` with depth, looked for where they would be if the camera had not moved.
fn queries(from: &Frame) -> Vec<(usize, ProjectionQuery)> {
    let query = |i: usize| {
        let octave = from.keypoints[i].octave;
        ProjectionQuery {
            x: from.keypoints[i].x,
            y: from.keypoints[i].y,
            right_u: f32::NAN,
            radius_px: 15.0 * from.scales.scales[usize::from(octave)],
            min_octave: octave.saturating_sub(1),
            max_octave: octave + 1,
            descriptor: from.descriptors[i],
        }
    };
    (0..from.len()).filter(|&i| from.has_depth(i)).map(|i| (i, query(i))).collect()
}

/// Measurements in the second frame of points of the first.
fn pose_observations([first, second]: &[Frame; 2]) -> Vec<PoseObservation> {
    let (indices, queries): (Vec<usize>, Vec<ProjectionQuery>) = queries(first).into_iter().unzip();
    let matches = search_windows(second, &queries, &vec![true; second.len()]);
    let observation = |(i, found): (usize, Option<features::WindowMatch>)| {
        let best = found.filter(|m| m.best.distance <= 50)?.best.feature as usize;
        Some(PoseObservation {
            point_world: first.unproject(i)?,
            pixel: second.pixel(best),
            right_u: f64::from(second.right_u[best]),
            inv_sigma_sq: second.inv_sigma_sq(best),
        })
    };
    indices.into_iter().zip(matches).filter_map(observation).collect()
}

/// A window of keyframes that drive forward through the points of a real frame, measured to a tenth of a pixel and
/// displaced by some centimeters.
fn bundle_problem(frame: &Frame) -> BundleProblem {
    const N_CAMERAS: usize = 12;
    let rig = frame.rig.stereo;
    let points: Vec<Vec3> = (0..frame.len()).filter_map(|i| frame.unproject(i)).collect();
    let truth: Vec<SE3> = (0..N_CAMERAS)
        .map(|i| SE3::exp(&Vec6::new(0.0, 0.0, -0.6 * i as f64, 0.0, 0.002 * i as f64, 0.0)))
        .collect();
    // A cheap repeatable disturbance in [-0.5, 0.5).
    let disturb = |a: usize, b: usize| ((a * 7919 + b * 104_729) % 1000) as f64 / 1000.0 - 0.5;
    let mut observations = Vec::new();
    for (camera, cam_from_world) in truth.iter().enumerate() {
        for (point, position) in points.iter().enumerate() {
            let point_cam = *cam_from_world * *position;
            let seen = rig.project(&point_cam);
            let inside = (0.0..frame.rig.width as f64).contains(&seen.x)
                && (0.0..frame.rig.height as f64).contains(&seen.y);
            if point_cam.z > 1.0 && inside {
                observations.push(BundleObservation {
                    camera: camera as u32,
                    point: point as u32,
                    pixel: seen.xy().map(|c| c + 0.2 * disturb(point, camera)),
                    right_u: seen.z,
                    inv_sigma_sq: 1.0,
                });
            }
        }
    }
    let moved = |i: usize| {
        SE3::exp(&Vec6::new(disturb(i, 1), disturb(i, 2), disturb(i, 3), 0.0, 0.0, 0.0).scale(0.1))
    };
    BundleProblem {
        rig,
        cameras: truth
            .iter()
            .enumerate()
            .map(|(i, pose)| if i < 2 { *pose } else { moved(i) * *pose })
            .collect(),
        fixed: (0..N_CAMERAS).map(|i| i < 2).collect(),
        points: points.iter().enumerate().map(|(i, p)| p * (1.0 + 0.02 * disturb(i, 9))).collect(),
        observations,
    }
}

fn stages(criterion: &mut Criterion) {
    let Some(input) = Input::load() else {
        println!("skipped: DSSLAM_DATA is not set");
        return;
    };
    let left = &input.pairs[0][0];
    let mut orb = cv::Orb::new(2000).unwrap();
    criterion.bench_function("opencv_orb_2000 (U)", |b| {
        b.iter(|| orb.detect_and_compute(black_box(left)).unwrap())
    });
    match dsfeat::Network::load(dsfeat::BUILT_IN, None, 1) {
        Ok(network) => selection(criterion, &input, network),
        Err(error) => println!("skipped: the activation network: {error}"),
    }
    let mut extractor = Extractor::new(ExtractorConfig::default());
    criterion.bench_function("extract_2000", |b| b.iter(|| extractor.extract(black_box(left))));
    let mut builder = input.builder();
    criterion.bench_function("mono_frame", |b| b.iter(|| builder.mono(0, 0.0, black_box(left)).unwrap()));
    criterion.bench_function("stereo_frame (extract and associate)", |b| {
        b.iter(|| builder.stereo(0, 0.0, black_box(left), &input.pairs[0][1]).unwrap());
    });
    let frames = input.frames();
    let queries: Vec<ProjectionQuery> = queries(&frames[0]).into_iter().map(|(_, query)| query).collect();
    let free = vec![true; frames[1].len()];
    criterion.bench_function(&format!("search_windows ({} queries)", queries.len()), |b| {
        b.iter(|| search_windows(&frames[1], black_box(&queries), &free));
    });
    let observations = pose_observations(&frames);
    criterion.bench_function(&format!("refine_pose ({} observations)", observations.len()), |b| {
        b.iter(|| {
            refine_pose(&input.rig.stereo, SE3::identity(), black_box(&observations), &PoseOptions::default())
        });
    });
    let problem = bundle_problem(&frames[0]);
    let name = format!(
        "refine_bundle ({} cameras, {} observations)",
        problem.cameras.len(),
        problem.observations.len()
    );
    criterion
        .bench_function(&name, |b| b.iter(|| refine_bundle(black_box(&problem), &BundleOptions::default())));
}

/// The activation map of an image, and a frame of the 500 features that it selects.
fn selection(criterion: &mut Criterion, input: &Input, network: dsfeat::Network) {
    let [left, right] = &input.pairs[0];
    let (width, height) = network.input_size(left.width, left.height);
    criterion.bench_function(&format!("activation ({width} x {height})"), |b| {
        b.iter(|| network.answers(black_box(left)).unwrap());
    });
    let config = SelectionConfig { rule: SelectionRule::Activation, keep: 500, spread: Spread::Cells };
    let mut builder = input.builder().with_selection(config, Box::new(InTurn::new(Arc::new(network))));
    criterion.bench_function("stereo_frame of 500 by activation", |b| {
        b.iter(|| builder.stereo(0, 0.0, black_box(left), right).unwrap());
    });
}

/// All of it on one thread.
fn on_one_thread(criterion: &mut Criterion) {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().unwrap();
    stages(criterion);
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = on_one_thread
}
criterion_main!(benches);
