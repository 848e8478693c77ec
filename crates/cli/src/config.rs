//! `dsslam config`: the default configuration, and the check of a file.

use io::Config;

use crate::args::ConfigAction;
use crate::console;
use crate::exit::{Exit, Failure, OrExit};

/// Prints the complete configuration that the defaults, or a file, give.
///
/// # Errors
/// Everything that is wrong with the file, at once.
pub(crate) fn run(action: &ConfigAction) -> Result<Exit, Failure> {
    let file = match action {
        ConfigAction::Default => None,
        ConfigAction::Check { file } => Some(file.as_path()),
    };
    let config = Config::load(file, &[]).or_input()?;
    console::say(config.to_yaml().trim_end());
    Ok(Exit::Done)
}
