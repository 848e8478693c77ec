//! What the map believes of the points that each frame shows, as a table to compare with labels of what moves
//! (`python -m dsfeat.points`): frame, pixel, the network's word on the feature, the belief in its point before this frame, and in how
//! many earlier frames the point was matched.
//!
//! `cargo run --release -p dsslam-tests --example belief -- SEQUENCE [KEY=VALUE]... > points.csv`
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program for people")]

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use dsslam::{Config, Event, Observer, Session};
use map::PointId;

/// Prints a line for each match of a frame.
#[derive(Default)]
struct Table {
    /// Frames in which a point was matched.
    sights: BTreeMap<PointId, u32>,
}

impl Observer for Table {
    fn event(&mut self, event: &Event) {
        let Event::Details(details) = event else { return };
        for (&(feature, point), trust) in details.matched.iter().zip(&details.trust) {
            let (index, i) = (details.info.index, feature as usize);
            let pixel = details.frame.pixel(i);
            let sights = self.sights.entry(point).or_default();
            let word = details.frame.activation[i];
            println!("{index},{:.1},{:.1},{word:.4},{trust:.4},{sights}", pixel.x, pixel.y);
            *sights += 1;
        }
    }

    fn wants_details(&self) -> bool {
        true
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [sequence, overrides @ ..] = &arguments[..] else {
        return Err("usage: belief SEQUENCE [KEY=VALUE]...".into());
    };
    let chosen = Config::for_sequence(Path::new(sequence), overrides)?;
    chosen.notices.iter().for_each(|notice| eprintln!("{notice}"));
    println!("frame,x,y,word,belief,sights");
    Session::open(sequence, &chosen.config)?.run(&mut Table::default())?;
    Ok(())
}
