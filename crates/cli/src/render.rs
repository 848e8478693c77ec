//! `dsslam synth`: a rendered course as a dataset.

use std::ops::ControlFlow;
use std::sync::atomic::Ordering;

use anyhow::{Result, anyhow, ensure};
use synth::{SpotTurns, World, WriteOptions, write_euroc, write_kitti};

use crate::args::{LayoutArg, SynthArgs, WorldArgs};
use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use crate::stop;

/// Where the camera turns on the spot, meters.
const TURN_AFTER_M: f64 = 40.0;

/// Renders the world and writes it.
///
/// # Errors
/// A folder that cannot be written.
pub(crate) fn run(args: &SynthArgs) -> Result<Exit, Failure> {
    if args.layout == LayoutArg::Euroc && (args.masks || args.depth) {
        return Err(anyhow!("--masks and --depth need --layout kitti")).or_input();
    }
    let world = world(&args.world).or_input()?;
    let stop = stop::on_signal();
    io::create_output_folder(&args.out).or_output()?;
    let n_frames = n_frames(&args.world, &world);
    let bar = console::bar(Some(n_frames as u64), "{bar:24} {pos}/{len} frames");
    let options = WriteOptions { max_frames: Some(n_frames), masks: args.masks, depth: args.depth };
    let mut progress = |done: usize| {
        bar.set_position(done as u64);
        if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let written = match args.layout {
        LayoutArg::Kitti => write_kitti(&world, &args.out, &options, &mut progress),
        LayoutArg::Euroc => {
            write_euroc(&world, &args.out, args.lens.into(), options.max_frames, &mut progress)
        }
    };
    let written = written.or_output()?;
    bar.finish_and_clear();
    console::say(format!("{written} stereo frames of {} in {}", describe(&world), args.out.display()));
    Ok(if written < n_frames { Exit::Interrupted } else { Exit::Done })
}

/// The world that the arguments describe.
///
/// # Errors
/// Other light for rounds that there are not.
pub(crate) fn world(args: &WorldArgs) -> Result<World> {
    if args.relight {
        ensure!(
            args.rounds > 1,
            "--relight changes the light from the second round on, but found --rounds 1"
        );
        ensure!(
            !args.preset.is_open(),
            "--relight changes the light from round to round, but the street of --preset {} is driven once",
            args.preset
        );
    }
    let turns = SpotTurns { after_m: TURN_AFTER_M, by_deg: args.turns.clone() };
    let world = World::turning(args.preset, args.seed, args.rounds, turns);
    Ok(if args.relight { world.relit() } else { world })
}

/// How many frames are wanted, at most the whole drive.
pub(crate) fn n_frames(args: &WorldArgs, world: &World) -> usize {
    args.frames.map_or(world.n_frames(), |n| world.n_frames().min(n as usize))
}

/// Preset, seed and length as text.
pub(crate) fn describe(world: &World) -> String {
    let course = if world.is_closed() { "closed course" } else { "street" };
    format!("{} (seed {}, {course} of {:.0} m)", world.preset(), world.seed(), world.course_length_m())
}
