//! `dsslam run`: SLAM on a dataset, a video or a camera. Everything that can be checked is checked before the first image is processed.

use anyhow::{Context, Result, anyhow};
use dsslam::{Chosen, Session, SessionOptions};
use runtime::{Journal, Schedule};

use crate::args::{RunArgs, ScheduleArg};
use crate::clock::StopWatch;
use crate::exit::{Exit, Failure, OrExit};
use crate::job::{self, Wishes};

/// Runs SLAM on the sequence that the arguments name.
///
/// # Errors
/// A configuration, a dataset or an output folder that cannot be used.
pub(crate) fn run(args: &RunArgs) -> Result<Exit, Failure> {
    let watch = StopWatch::start();
    let chosen = chosen(args).or_input()?;
    let options = options(args).or_input()?;
    let mut session = Session::open_with(&args.sequence, &chosen.config, &options).or_input()?;
    session.setup_mut().faults.delays = args.delays;
    let replay = journal(args).or_input()?;
    let opening = chosen.preset.map(|name| {
        format!("configuration {name}, built in, as the layout suggests; --config takes another")
    });
    let wishes = Wishes {
        opening,
        out: args.out.clone(),
        is_strict: args.strict,
        preset: chosen.preset,
        notices: chosen.notices,
        replay,
        lengths_m: args.lengths.clone(),
        save_map: args.save_map.clone(),
        journal: args.journal.clone(),
        show: args.show.clone(),
        json: args.json,
    };
    job::run(session, wishes, watch)
}

/// The configuration. Images that are opened by a calibration file of their own have no layout.
fn chosen(args: &RunArgs) -> Result<Chosen> {
    let mut settings = args.settings.clone();
    settings.overrides.extend(args.no_loops.then(|| "loops.enabled=false".to_owned()));
    if args.calib.is_some() && settings.config.is_none() {
        settings.config = Some("default".into());
    }
    settings.load_for(&args.sequence, &args.network)
}

/// What the arguments say beside the configuration.
fn options(args: &RunArgs) -> Result<SessionOptions> {
    let mut options = SessionOptions::default();
    options.input.sensor = args.sensor;
    options.input.calibration = args.calib.clone();
    options.input.topics = args.topics.clone();
    options.input.ground_truth = args.ground_truth.clone();
    options.input.max_frames = args.max_frames.map(|n| n as usize);
    options.input.variant = args.variant;
    options.slam.network = args.network.options();
    options.slam.vocabulary = args.vocab.clone();
    options.slam.start_map = args.load_map.clone();
    options.slam.localize_only = args.localize;
    options.slam.schedule = match args.schedule {
        Some(ScheduleArg::Live) => Some(Schedule::Live { realtime: args.realtime }),
        // Of a camera it is live and at its pace in any case.
        None if !args.realtime || dsslam::is_camera(&args.sequence) => None,
        _ if args.realtime => return Err(anyhow!("--realtime needs --schedule live")),
        Some(ScheduleArg::Sequential) => Some(Schedule::Sequential),
        None | Some(ScheduleArg::Lockstep) => Some(Schedule::Lockstep),
    };
    Ok(options)
}

/// The journal to replay, if there is one to replay.
fn journal(args: &RunArgs) -> Result<Option<Journal>> {
    let Some(file) = &args.replay else { return Ok(None) };
    let bytes = io::read_file(file).with_context(|| format!("{}: cannot be read", file.display()))?;
    let journal = Journal::from_json(&bytes).with_context(|| file.display().to_string())?;
    Ok(Some(journal))
}
