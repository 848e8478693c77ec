//! SLAM on images that your own program has in memory: push them one by one, get a pose for each.
//!
//!     cargo run -p dsslam --release --example 02_push_images -- cameras.yaml path/to/left path/to/right
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program for people")]

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use dsslam::{Camera, Config, FrameStatus, Images, Slam, io};

/// The files of a folder in the order of their names.
fn files(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut files =
        fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>, std::io::Error>>()?;
    files.sort();
    Ok(files)
}

/// Pushes the images of one camera, or of two; the calibration file says how many there are. Returns how many have a pose.
pub(crate) fn run(calibration: &Path, left: &Path, right: Option<&Path>) -> Result<usize, Box<dyn Error>> {
    let config = Config::load(None, &["camera.fps=10".to_owned()])?;
    let mut slam = Slam::new(&config, Camera::from_file(calibration, None)?)?;
    let right_files = right.map_or(Ok(Vec::new()), files)?;
    for (i, left_file) in files(left)?.iter().enumerate() {
        let left = io::load_gray(left_file)?;
        let right = right_files.get(i).map(|file| io::load_gray(file)).transpose()?;
        let images = match &right {
            Some(right) => Images::from((&left, right)),
            None => Images::from(&left),
        };
        let t_ns = i as i64 * 100_000_000;
        let seen = slam.track(t_ns, images)?;
        match (&seen.status, seen.world_from_cam) {
            (FrameStatus::Tracked { inliers }, Some(pose)) => {
                let [x, y, z]: [f64; 3] = pose.translation.into();
                println!("frame {i}: {x:.3} {y:.3} {z:.3} m, {inliers} of {} features", seen.features);
            }
            (status, _) => println!("frame {i}: {}", status.reason().unwrap_or_default()),
        }
    }
    let done = slam.finish()?;
    println!("{} keyframes, {} points", done.outcome.map.n_keyframes(), done.outcome.map.n_points());
    Ok(done.trajectory().poses.len())
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    match &args[..] {
        [calibration, left] => run(calibration, left, None)?,
        [calibration, left, right] => run(calibration, left, Some(right))?,
        _ => return Err("expected a calibration file and one or two folders of images".into()),
    };
    Ok(())
}
