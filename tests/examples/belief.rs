//! What the map believes of the points that each frame shows, as a table to compare with labels of what moves
//! (`python -m dsfeat.points`): frame, pixel, the network's word on the feature, the belief in its point before this frame, in how
//! many earlier frames the point was matched, how many frames the map has judged it by (it learns of them with a keyframe), its
//! number, whether the match agrees with the pose, how far the feature is from where the point would be if it stood (left column,
//! right column, row; px), the feature's information (1/px²), the point and the step that the camera has made since the last frame
//! (m, in coordinates of the camera).
//!
//! With `all` before the settings features are kept by response, so that the map holds what moves too; the network still gives its word.
//!
//! `cargo run --release -p dsslam-tests --example belief -- SEQUENCE [all] [KEY=VALUE]... > points.csv`
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program for people")]

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use dsslam::{Config, Event, Observer, Session};
use features::SelectionRule;
use geometry::Vec3;
use map::PointId;

/// Prints a line for each match of a frame.
#[derive(Default)]
struct Table {
    /// Frames in which a point was matched.
    sights: BTreeMap<PointId, u32>,
    /// Where the camera was in the last frame.
    last: Option<Vec3>,
}

impl Observer for Table {
    fn event(&mut self, event: &Event) {
        let Event::Details(details) = event else { return };
        let (frame, map) = (&details.frame, &details.world.map);
        let cam_from_world = details.world_from_cam.inverse();
        let center = cam_from_world.center();
        let step = cam_from_world.rotation * (center - self.last.unwrap_or(center));
        self.last = Some(center);
        for (pair, trust) in details.matched.iter().zip(&details.trust) {
            let (index, i) = (details.answer.index, pair.0 as usize);
            let Some(point) = map.point(pair.1) else { continue };
            let at = cam_from_world * point.position;
            let (pixel, seen) = (frame.pixel(i), frame.rig.stereo.project(&at));
            let right = f64::from(frame.right_u[i]);
            let sights = self.sights.entry(pair.1).or_default();
            println!(
                "{index},{:.1},{:.1},{:.4},{trust:.4},{sights},{},{},{},{:.2},{:.2},{:.2},{:.4},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3}",
                pixel.x,
                pixel.y,
                frame.activation[i],
                point.seen,
                pair.1.0,
                u8::from(details.inliers.contains(pair)),
                pixel.x - seen.x,
                right - seen.z,
                pixel.y - seen.y,
                frame.inv_sigma_sq(i),
                at.x,
                at.y,
                at.z,
                step.x,
                step.y,
                step.z
            );
            *sights += 1;
        }
    }

    fn wants_details(&self) -> bool {
        true
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [sequence, rest @ ..] = &arguments[..] else {
        return Err("usage: belief SEQUENCE [all] [KEY=VALUE]...".into());
    };
    let (keep_all, overrides) = match rest {
        [word, overrides @ ..] if word == "all" => (true, overrides),
        _ => (false, rest),
    };
    let chosen = Config::for_sequence(Path::new(sequence), overrides)?;
    chosen.notices.iter().for_each(|notice| eprintln!("{notice}"));
    println!("frame,x,y,word,belief,sights,judged,point,inlier,du,dr,dv,information,X,Y,Z,stepX,stepY,stepZ");
    let mut session = Session::open(sequence, &chosen.config)?;
    if let Some(selection) = session.setup_mut().selection.as_mut().filter(|_| keep_all) {
        selection.config.rule = SelectionRule::Response;
    }
    session.run(&mut Table::default())?;
    Ok(())
}
