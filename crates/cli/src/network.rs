//! The activation network of a run: which model, which library, how its maps choose features.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result};
use dsfeat::{Model, Network};
use features::{ActivationSource, SelectionConfig, SelectionRule, Spread};
use io::{FeatureSelection, FeatureSettings, FeatureSpread};
use runtime::{ActivationFactory, Selection};
use sha2::{Digest, Sha256};

use crate::args::NetworkArgs;

/// Opens networks for a run.
#[derive(Debug)]
struct Opener {
    model: Vec<u8>,
    /// Where the model comes from.
    origin: String,
    library: Option<PathBuf>,
    threads: usize,
}

impl Opener {
    fn network(&self) -> Result<Network> {
        Network::load(&self.model, self.library.as_deref(), self.threads).with_context(|| self.origin.clone())
    }
}

impl ActivationFactory for Opener {
    fn open(&self) -> Result<Box<dyn ActivationSource>, String> {
        let network = self.network().map_err(|error| format!("{error:#}"))?;
        Ok(Box::new(network))
    }

    fn identity(&self) -> u64 {
        let digest = Sha256::digest(&self.model);
        digest.iter().take(8).fold(0, |number, byte| number << 8 | u64::from(*byte))
    }
}

/// How the settings choose features; `None` where no network takes part. The network is opened once, so that whatever is
/// wrong with it is known before the first image.
///
/// # Errors
/// A model or a library that cannot be used.
pub(crate) fn selection(settings: &FeatureSettings, args: &NetworkArgs) -> Result<Option<Selection>> {
    let Some((config, model)) = chosen(settings) else { return Ok(None) };
    let opener = opener(model, args, settings.network_threads)?;
    opener.network()?;
    Ok(Some(Selection { config, source: Arc::new(opener) }))
}

/// The network of the settings, which must not be those of a selection without one, and how it chooses features.
///
/// # Errors
/// A model or a library that cannot be used.
pub(crate) fn open(settings: &FeatureSettings, args: &NetworkArgs) -> Result<(Network, SelectionConfig)> {
    let (config, model) = chosen(settings).context("features.selection is response, which has no network")?;
    Ok((opener(model, args, settings.network_threads)?.network()?, config))
}

/// Rule and model of the settings; `None` where no network takes part.
fn chosen(settings: &FeatureSettings) -> Option<(SelectionConfig, Model)> {
    let (rule, model) = match settings.selection {
        FeatureSelection::Response => return None,
        FeatureSelection::Semantic => (SelectionRule::Semantic, Model::Semantic),
        FeatureSelection::Activation => (SelectionRule::Activation, Model::Hybrid),
    };
    let spread = match settings.spread {
        FeatureSpread::Cells => Spread::Cells,
        FeatureSpread::Anywhere => Spread::Anywhere,
    };
    Some((SelectionConfig { rule, keep: settings.keep, spread }, model))
}

/// The network that the arguments name, else `model`.
///
/// # Errors
/// A model or a library that cannot be used.
pub(crate) fn load(model: Model, args: &NetworkArgs, threads: usize) -> Result<Network> {
    opener(model, args, threads)?.network()
}

fn opener(model: Model, args: &NetworkArgs, threads: usize) -> Result<Opener> {
    let (model, origin) = match &args.dsfeat_model {
        Some(file) => (read(file)?, file.display().to_string()),
        None => (model.bytes().to_vec(), "the network that is part of the program".to_owned()),
    };
    Ok(Opener { model, origin, library: args.onnxruntime.clone(), threads })
}

fn read(file: &Path) -> Result<Vec<u8>> {
    fs::read(file).with_context(|| format!("{}: cannot be read", file.display()))
}
