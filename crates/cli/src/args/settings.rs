//! Command line of the configuration, for every command that has one.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use dsslam::{Chosen, Config};

use super::NetworkArgs;

/// A configuration: a file, and what is changed in it.
#[derive(Clone, Debug, Args)]
pub(crate) struct SettingsArgs {
    /// Configuration file (YAML), or the name of a built-in one: kitti, tum-rgbd, euroc, default. Keys that it leaves out have their
    /// defaults. Without this option the one that goes with the layout of the sequence is taken.
    #[arg(long, value_name = "FILE|NAME")]
    pub(crate) config: Option<PathBuf>,
    /// Overrides one key of the configuration; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) overrides: Vec<String>,
}

impl SettingsArgs {
    /// The configuration in force, without regard to any sequence.
    ///
    /// # Errors
    /// Everything that is wrong with it, at once.
    pub(crate) fn load(&self) -> Result<Config> {
        Ok(Config::load(self.config.as_deref(), &self.overrides)?)
    }

    /// The configuration in force for a sequence: without --config the one that goes with its layout.
    ///
    /// # Errors
    /// Everything that is wrong with it, at once.
    pub(crate) fn load_for(&self, sequence: &Path, network: &NetworkArgs) -> Result<Chosen> {
        Ok(Config::choose(self.config.as_deref(), Some(sequence), &self.overrides, &network.options())?)
    }
}
