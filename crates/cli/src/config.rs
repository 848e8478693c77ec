//! `dsslam config`: the default configuration, the explanation of one, and what a calibration file says.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use dsslam::{Chosen, Config, NetworkOptions};
use io::{Explained, Provenance};

use crate::args::ConfigAction;
use crate::console;
use crate::exit::{Exit, Failure, OrExit};

/// Arguments of `dsslam config default`.
#[derive(Debug, Args)]
pub(crate) struct DefaultArgs {
    /// Prints all keys, also those for people who know the algorithms.
    #[arg(long)]
    expert: bool,
}

/// Arguments of `dsslam config check`.
#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// The file to check, or the name of a built-in configuration; without it the defaults, or what goes with --sequence.
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// Overrides one key, as in `dsslam run`; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// A sequence, whose calibration takes precedence over the file's camera.
    #[arg(long, value_name = "SEQUENCE")]
    sequence: Option<PathBuf>,
    /// Shows only what differs from the defaults.
    #[arg(long)]
    changed: bool,
    /// Shows all keys, also those for people who know the algorithms.
    #[arg(long, conflicts_with = "changed")]
    expert: bool,
    /// Prints the complete configuration as YAML instead, as in the results of `dsslam run`.
    #[arg(long, conflicts_with = "changed")]
    yaml: bool,
}

/// Arguments of `dsslam config calib`.
#[derive(Debug, Args)]
pub(crate) struct CalibArgs {
    /// A calibration file in any format that `--calib` reads.
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

/// Prints the default configuration, explains one, or prints what was understood of a calibration.
///
/// # Errors
/// Everything that is wrong with the file, at once.
pub(crate) fn run(action: &ConfigAction) -> Result<Exit, Failure> {
    match action {
        ConfigAction::Calib(args) => {
            console::say(io::read_calibration(&args.file).or_input()?.to_yaml().trim_end());
        }
        ConfigAction::Default(args) => console::say(default_yaml(args.expert).trim_end()),
        ConfigAction::Check(args) => {
            let (config, notices) = load(args).or_input()?;
            notices.iter().for_each(|notice| console::note(console::warning(notice)));
            let text = if args.yaml { config.to_yaml() } else { explanation(args, &config) };
            console::say(text.trim_end());
        }
    }
    Ok(Exit::Done)
}

/// The default configuration: all keys, or those of everyday use.
fn default_yaml(expert: bool) -> String {
    let config = Config::default();
    if expert {
        return config.to_yaml();
    }
    let (hidden, shown): (Vec<_>, Vec<_>) = config.explain().into_iter().partition(|key| key.entry.is_expert);
    let title = format!("Default configuration; --expert lists {} further keys.", hidden.len());
    io::to_yaml(&title, &shown)
}

/// The configuration in force, with a notice for each value that the sequence replaces.
fn load(args: &CheckArgs) -> Result<(Config, Vec<String>)> {
    let (file, sequence) = (args.file.as_deref(), args.sequence.as_deref());
    let Chosen { mut config, preset, mut notices, .. } =
        Config::choose(file, sequence, &args.overrides, &NetworkOptions::default())?;
    notices.extend(preset.map(|name| format!("configuration {name}, built in, as the layout suggests")));
    if let Some(dir) = &args.sequence {
        let sequence = io::open_sequence(dir, config.input.sensor)?;
        notices.extend(sequence.warnings);
        notices.extend(sequence.calibration.iter().flat_map(|found| config.apply_calibration(found)));
    }
    Ok((config, notices))
}

/// Keys with their values, origins and meanings: those of everyday use, and whatever somebody has set.
fn explanation(args: &CheckArgs, config: &Config) -> String {
    let all = config.explain();
    let mut text = headline(args.file.as_deref(), &all);
    let shown = all.iter().filter(|key| match key.place {
        Provenance::Default => args.expert || !(args.changed || key.entry.is_expert),
        _ => true,
    });
    let values: Vec<(String, &Explained<'_>)> = shown.map(|key| (value(key), key)).collect();
    let width = values.iter().map(|(value, _)| value.chars().count()).max().unwrap_or(0);
    let mut section = None;
    for (value, key) in values {
        if section != Some(key.entry.section()) {
            section = Some(key.entry.section());
            text.push('\n');
        }
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{value:<width$}   {}", key.place);
        let _ = writeln!(text, "    {}; {}", key.entry.help, key.entry.expectation());
    }
    text
}

/// `key = value unit`.
fn value(key: &Explained<'_>) -> String {
    let Explained { entry, value, .. } = key;
    match value {
        Some(value) if entry.unit.is_empty() => format!("{} = {value}", entry.key),
        Some(value) => format!("{} = {value} {}", entry.key, entry.unit),
        None => format!("{} absent", entry.key),
    }
}

/// How many values come from where.
fn headline(file: Option<&Path>, all: &[Explained<'_>]) -> String {
    let count = |is: fn(&Provenance) -> bool| all.iter().filter(|key| is(key.place)).count();
    let n_file = count(|place| matches!(place, Provenance::File { .. }));
    let n_set = count(|place| matches!(place, Provenance::Override(_)));
    let n_dataset = count(|place| matches!(place, Provenance::Calibration(_)));
    let n_default = count(|place| *place == Provenance::Default);
    let name = file.map_or("the defaults".to_owned(), |file| file.display().to_string());
    format!(
        "{name}: no problem found. {} keys: {n_file} from the file, {n_set} from --set, {n_dataset} from the sequence, \
         {n_default} defaults\n",
        all.len()
    )
}
