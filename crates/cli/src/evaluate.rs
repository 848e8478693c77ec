//! `dsslam eval`: lends the evaluation what this program knows.

use std::cell::OnceCell;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use dsfeat::Network;
use dsslam::{Config, NetworkOptions};
use eval::command::EvalCommand;
use eval::{Host, Settings};
use features::ExtractorConfig;
use io::FileError;

use crate::console;
use crate::exit::{Exit, Failure};

/// Does what the arguments say.
///
/// # Errors
/// Wrong input, or an output that cannot be written.
pub(crate) fn run(command: EvalCommand) -> Result<Exit, Failure> {
    let bar = OnceCell::new();
    let progress = |done: usize, total: usize| {
        let bar = bar.get_or_init(|| console::bar(Some(total as u64), "{bar:24} {pos}/{len} frames"));
        bar.set_position(done as u64);
        if done == total {
            bar.finish_and_clear();
        }
    };
    let host = Host {
        settings: &settings,
        network: &network,
        vocabulary: &|file| Ok(dsslam::vocabulary(file)?),
        progress: &progress,
    };
    match command.run(&host) {
        Ok(()) => Ok(Exit::Done),
        Err(error) => {
            let is_output = matches!(error.downcast_ref(), Some(FileError::Unwritable { .. }))
                || error.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == ErrorKind::StorageFull);
            Err(Failure { exit: if is_output { Exit::Output } else { Exit::Input }, error })
        }
    }
}

fn settings(file: Option<&Path>, overrides: &[String]) -> anyhow::Result<Settings> {
    let config = Config::load(file, overrides)?;
    Ok(Settings { features: config.features, weighs_words: config.weights.words })
}

fn network(
    file: Option<&Path>,
    library: Option<&Path>,
    features: &ExtractorConfig,
) -> anyhow::Result<Network> {
    let mut options = NetworkOptions::default();
    options.model = file.map(PathBuf::from);
    options.library = library.map(PathBuf::from);
    Ok(dsslam::load_network(&options, features)?)
}
