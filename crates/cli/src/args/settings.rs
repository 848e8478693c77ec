//! Command line of the configuration, for every command that has one.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use dsslam::Config;

/// A configuration: a file, and what is changed in it.
#[derive(Clone, Debug, Args)]
pub(crate) struct SettingsArgs {
    /// Configuration file (YAML); what it leaves out has its default.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Overrides one key of the configuration; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) overrides: Vec<String>,
}

impl SettingsArgs {
    /// The configuration in force.
    ///
    /// # Errors
    /// Everything that is wrong with it, at once.
    pub(crate) fn load(&self) -> Result<Config> {
        self.load_with(&[])
    }

    /// The configuration in force when more keys are overridden.
    ///
    /// # Errors
    /// Everything that is wrong with it, at once.
    pub(crate) fn load_with(&self, more: &[String]) -> Result<Config> {
        Ok(Config::load(self.config.as_deref(), &[&self.overrides, more].concat())?)
    }
}
