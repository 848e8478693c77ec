//! `dsslam demo`: renders a course and runs SLAM on it in one go; nothing is written but the results.

use std::path::Path;

use dsslam::Config;
use dsslam::{Session, SessionOptions};
use eval::KITTI_LENGTHS_M;

use crate::args::DemoArgs;
use crate::clock::StopWatch;
use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use crate::figures;
use crate::job::{self, Extras, Job};
use crate::render;
use crate::results::ResultsFolder;
use crate::show;
use crate::stop;

/// Renders, runs and reports.
///
/// # Errors
/// A configuration or an output folder that cannot be used.
pub(crate) fn run(args: &DemoArgs) -> Result<Exit, Failure> {
    let watch = StopWatch::start();
    let config = Config::load(None, &args.overrides).or_input()?;
    let world = render::world(&args.world).or_input()?;
    let (name, course) = (world.preset().name(), render::describe(&world));
    let n_frames = render::n_frames(&args.world, &world);
    let mut options = SessionOptions::default();
    options.input.max_frames = Some(n_frames);
    let session = Session::rendered(world, &config, &options).or_input()?;
    let viewer = show::viewer(&args.show)?;
    let stop = stop::on_signal();
    let folder = ResultsFolder::create(args.out.as_deref(), Path::new(""), name).or_output()?;
    let sensor = session.input().sequence().sensor;
    console::note(format!("rendering {n_frames} {sensor} frames of {course} and processing them"));
    let (show, json) = (args.show.clone(), args.json);
    let (lengths_m, extras, notices) = (KITTI_LENGTHS_M.to_vec(), Extras::default(), Vec::new());
    let (preset, replay, is_strict) = (None, None, false);
    let figures = figures::show(&session, is_strict)?;
    let job = Job {
        session,
        figures,
        is_strict,
        preset,
        notices,
        replay,
        lengths_m,
        folder,
        extras,
        show,
        viewer,
        json,
        watch,
    };
    job::execute(&job, &stop)
}
