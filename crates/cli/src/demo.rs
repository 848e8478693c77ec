//! `dsslam demo`: renders a course and runs SLAM on it in one go; nothing is written but the results.

use dsslam::{Config, Session, SessionOptions};
use eval::KITTI_LENGTHS_M;

use crate::args::DemoArgs;
use crate::clock::StopWatch;
use crate::exit::{Exit, Failure, OrExit};
use crate::job::{self, Wishes};
use crate::render;

/// Renders, runs and reports.
///
/// # Errors
/// A configuration or an output folder that cannot be used.
pub(crate) fn run(args: &DemoArgs) -> Result<Exit, Failure> {
    let watch = StopWatch::start();
    let config = Config::load(None, &args.overrides).or_input()?;
    let world = render::world(&args.world).or_input()?;
    let course = render::describe(&world);
    let n_frames = render::n_frames(&args.world, &world);
    let mut options = SessionOptions::default();
    options.input.max_frames = Some(n_frames);
    let session = Session::rendered(world, &config, &options).or_input()?;
    let sensor = session.input().sequence().sensor;
    let wishes = Wishes {
        opening: Some(format!("rendering {n_frames} {sensor} frames of {course} and processing them")),
        out: args.out.clone(),
        lengths_m: KITTI_LENGTHS_M.to_vec(),
        show: args.show.clone(),
        json: args.json,
        ..Wishes::default()
    };
    job::run(session, wishes, watch)
}
