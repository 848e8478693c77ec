//! The whole tracking step (decoded images to pose, mapping running) in units of U, OpenCV's ORB of one image timed in the
//! same process. `DSSLAM_DATA=... cargo bench -p dsslam-tests --bench tracking`
#![allow(
    clippy::disallowed_methods,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a benchmark: it measures and prints"
)]

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use features::{Rig, SelectionConfig, SelectionRule, Spread};
use geometry::GrayImage;
use runtime::{Preparation, Schedule, Selection, SequenceFeed, Setup, Silent};

/// Calls of OpenCV's ORB before and after the run; the median of all is U.
const N_UNIT: usize = 20;

/// Milliseconds of each of `N_UNIT` calls.
fn unit(image: &GrayImage) -> Vec<f64> {
    let mut orb = cv::Orb::new(2000).unwrap();
    let mut call = || {
        let start = Instant::now();
        assert!(orb.detect_and_compute(image).unwrap() > 1000);
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..N_UNIT).map(|_| call()).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    let Some(data) = std::env::var_os("DSSLAM_DATA") else {
        println!("skipped: DSSLAM_DATA is not set");
        return;
    };
    let sequence =
        io::open_sequence(&Path::new(&data).join("kitti06_first51"), Some(io::Sensor::Stereo)).unwrap();
    let calibration = sequence.calibration.clone().unwrap();
    let image = io::load_gray(&sequence.frames[0].left).unwrap();
    let close_depth_m = 40.0 * calibration.rig.baseline_m;
    let rig = Rig {
        stereo: calibration.rig,
        distortion: calibration.distortion,
        width: image.width,
        height: image.height,
    };
    let params = slam::Params::of(slam::CameraParams::stereo(close_depth_m, 10.0));
    let all = Setup {
        schedule: Schedule::Sequential,
        ..Setup::new(runtime::Sensor::Stereo, Arc::new(rig), params)
    };
    let feed = SequenceFeed::prepared(&sequence, Preparation::new(&sequence, 1.0), None);
    let threads = rayon::current_num_threads();
    println!("{threads} threads, U: OpenCV ORB, 2000 features, one thread");
    measure("response, 2000 features", &image, &feed, &all);
    let network = match dsfeat::Network::load(dsfeat::BUILT_IN, None, 1) {
        Ok(network) => Arc::new(network),
        Err(error) => {
            println!("skipped: activation, 500 features: {error}");
            return;
        }
    };
    let config = SelectionConfig { rule: SelectionRule::Activation, keep: 500, spread: Spread::Cells };
    let selection = Some(Selection { config, source: network, identity: 0 });
    measure("activation, 500 features", &image, &feed, &Setup { selection, ..all });
}

/// Runs and prints the tracking step in units of U, which is measured before and after.
fn measure(name: &str, image: &GrayImage, feed: &SequenceFeed, setup: &Setup) {
    let mut units = unit(image);
    let outcome = runtime::run(feed, setup, &mut Silent, &AtomicBool::new(false)).unwrap();
    units.extend(unit(image));
    let (unit_ms, track) = (median(units), outcome.timings.summary("track").unwrap());
    println!(
        "{name}: U = {unit_ms:.2} ms, track median {:.2} ms = {:.2} U, p95 {:.2} ms",
        track.median,
        track.median / unit_ms,
        track.p95
    );
}
