//! A map made of one drive, saved, loaded, and used to find the camera in another drive along the same streets.
//!
//!     cargo run -p dsslam --release --example 03_save_load_localize -- morning evening town.dsmap
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program for people")]

use std::error::Error;
use std::path::Path;

use dsslam::{Config, Session, SessionOptions, Silent};

/// Maps the first sequence and finds the camera of the second one in that map. Returns how many of its frames have a pose.
pub(crate) fn run(first: &Path, second: &Path, map: &Path) -> Result<usize, Box<dyn Error>> {
    let config = Config::for_sequence(first, &[])?.config;
    let done = Session::open(first, &config)?.run(&mut Silent)?;
    done.save_map(map)?;
    println!("{} keyframes in {}", done.outcome.map.n_keyframes(), map.display());

    let mut options = SessionOptions::default();
    options.slam.start_map = Some(map.to_path_buf());
    // Without this line the map grows with what is new.
    options.slam.localize_only = true;
    let found = Session::open_with(second, &config, &options)?.run(&mut Silent)?;
    let poses = found.trajectory().poses;
    println!("found in {} of {} frames", poses.len(), found.outcome.frames.len());
    for pose in &poses {
        let [x, y, z]: [f64; 3] = pose.world_from_cam.translation.into();
        println!("{:.3} s: {x:.3} {y:.3} {z:.3} m", pose.timestamp_s);
    }
    Ok(poses.len())
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().collect();
    match &args[..] {
        [_, first, second, map] => run(first.as_ref(), second.as_ref(), map.as_ref()).map(|_| ()),
        _ => Err("expected two folders of images and the file of the map".into()),
    }
}
