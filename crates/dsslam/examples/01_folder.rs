//! SLAM on a folder of images, a video or a camera, with what the program tells while it runs.
//!
//!     cargo run -p dsslam --release --example 01_folder -- path/to/kitti/sequences/06 trajectory.txt
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program for people")]

use std::error::Error;
use std::path::Path;

use dsslam::runtime::{Narrator, Weight};
use dsslam::{Config, Event, Observer, Session, io};

/// Prints in words what happens: keyframes, loops, losses.
#[derive(Default)]
struct Console(Narrator);

impl Observer for Console {
    fn event(&mut self, event: &Event) {
        for words in self.0.tell(event) {
            if words.weight <= Weight::Detail {
                println!("{}", words.text);
            }
        }
    }
}

/// Runs over all frames of `sequence` and writes the poses of the left camera in TUM's format.
pub(crate) fn run(sequence: &Path, trajectory: &Path) -> Result<(), Box<dyn Error>> {
    // The built-in configuration that goes with the layout of the folder; `Config::load` reads a file.
    let chosen = Config::for_sequence(sequence, &[])?;
    let session = Session::open(sequence, &chosen.config)?;
    for notice in chosen.notices.iter().chain(session.notices()) {
        eprintln!("{notice}");
    }
    let done = session.run(&mut Console::default())?;
    let (map, poses) = (&done.outcome.map, done.trajectory());
    println!("{} poses, {} keyframes, {} points", poses.poses.len(), map.n_keyframes(), map.n_points());
    io::write_tum(trajectory, &poses)?;
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().collect();
    match &args[..] {
        [_, sequence, trajectory] => run(sequence.as_ref(), trajectory.as_ref()),
        _ => Err("expected a folder of images and the file to write".into()),
    }
}
