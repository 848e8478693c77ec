//! `dsslam demo`: renders a course and runs SLAM on it in one go; nothing is written but the results.

use std::path::Path;

use geometry::{Distortion, SE3};
use io::{Calibration, Config, ImageSize, LoadedFrame, Sensor, StampedPose, Trajectory};
use runtime::{FrameFeed, FrameInfo};
use synth::World;

use crate::args::{DemoArgs, NetworkArgs};
use crate::clock::StopWatch;
use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use crate::job::{self, Job};
use crate::network;
use crate::places::{self, Extras};
use crate::render;
use crate::results::ResultsFolder;
use crate::setup;
use crate::show;
use crate::stop;
use crate::summary::Context;

/// The first frames of a rendered world, rendered when they are asked for.
struct RenderedFeed<'a> {
    world: &'a World,
    len: usize,
}

impl FrameFeed for RenderedFeed<'_> {
    fn len(&self) -> usize {
        self.len
    }

    fn info(&self, i: usize) -> FrameInfo {
        FrameInfo { index: i as u32, timestamp_s: self.world.timestamp_s(i) }
    }

    fn load(&self, i: usize) -> Result<LoadedFrame, String> {
        let images = self.world.images(i);
        Ok(LoadedFrame { left: images.left, right: Some(images.right), depth: None })
    }
}

/// Renders, runs and reports.
///
/// # Errors
/// A configuration or an output folder that cannot be used.
pub(crate) fn run(args: &DemoArgs) -> Result<Exit, Failure> {
    let watch = StopWatch::start();
    let mut config = Config::load(None, &args.overrides).or_input()?;
    let world = render::world(&args.world).or_input()?;
    let viewer = show::viewer(&args.show)?;
    let stop = stop::on_signal();
    let name = args.world.preset.name();
    let folder = ResultsFolder::create(args.out.as_deref(), Path::new(""), name).or_output()?;
    let feed = RenderedFeed { world: &world, len: render::n_frames(&args.world, &world) };
    let notices = config.apply_calibration(&calibration(&world));
    let (width, height) = world.image_size();
    let size = ImageSize { width, height };
    let mut setup = setup::from_config(&config, Sensor::Stereo, size, Path::new(name)).or_input()?;
    setup.selection = network::selection(&config.features, &NetworkArgs::default()).or_input()?;
    setup.vocabulary = Some(places::vocabulary(None).or_input()?);
    console::note(format!(
        "rendering {} stereo frames of {} and running on them",
        feed.len,
        render::describe(&world)
    ));
    for notice in &notices {
        console::note(console::warning(notice));
    }
    let job = Job {
        feed: &feed,
        config_yaml: config.to_yaml(),
        ground_truth: Some(&ground_truth(&world, feed.len)),
        body_from_left: SE3::identity(),
        context: Context {
            sequence: name.to_owned(),
            sensor: Sensor::Stereo,
            seed: setup.slam.seed,
            schedule: job::schedule_name(&setup, false),
            notices,
        },
        setup,
        replay: None,
        folder,
        extras: Extras::default(),
        show: args.show.clone(),
        viewer,
        json: args.json,
        watch,
    };
    job::execute(job, &stop).map(|(_, exit)| exit)
}

fn calibration(world: &World) -> Calibration {
    Calibration { rig: world.rig(), distortion: Distortion::default(), source: "the renderer".to_owned() }
}

/// The exact poses of the first `n` frames.
fn ground_truth(world: &World, n: usize) -> Trajectory {
    let pose =
        |i: usize| StampedPose { timestamp_s: world.timestamp_s(i), world_from_cam: world.world_from_cam(i) };
    Trajectory { poses: (0..n).map(pose).collect() }
}
