//! The activation network of a run: which model, which library, how its maps choose features.

use std::path::PathBuf;
use std::sync::Arc;

use dsfeat::{BUILT_IN, Network};
use features::{ExtractorConfig, SelectionConfig};
use runtime::Selection;
use sha2::{Digest, Sha256};

use crate::Error;

/// Which activation network is taken.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct NetworkOptions {
    /// File of a network (ONNX: gray image in, activation map out); `None`: the one that is part of the library.
    pub model: Option<PathBuf>,
    /// ONNX Runtime's library; `None`: the one of `ORT_DYLIB_PATH`, beside the program, in `~/.local/share/dsslam` or of the system.
    /// Without one the network runs on the built-in engine, several times slower.
    pub library: Option<PathBuf>,
}

/// A model, and where it comes from.
struct Model {
    bytes: Vec<u8>,
    origin: String,
}

impl Model {
    fn of(options: &NetworkOptions) -> Result<Self, Error> {
        let Some(file) = &options.model else {
            return Ok(Model { bytes: BUILT_IN.to_vec(), origin: "the built-in network".to_owned() });
        };
        let bytes = io::read_file(file).map_err(|reason| Error::unreadable(file, &reason))?;
        Ok(Model { bytes, origin: file.display().to_string() })
    }

    /// A number for the model, which the maps depend on beside the image and the settings.
    fn identity(&self) -> u64 {
        let digest = Sha256::digest(&self.bytes);
        digest.iter().take(8).fold(0, |number, byte| number << 8 | u64::from(*byte))
    }

    fn network(&self, options: &NetworkOptions, settings: &ExtractorConfig) -> Result<Network, Error> {
        Network::load(&self.bytes, options.library.as_deref(), settings.network_threads)
            .map(|network| network.with_size(settings.network_size))
            .map_err(|problem| Error::Network { origin: self.origin.clone(), problem })
    }
}

/// How the settings choose features; `None` without a network. The network is opened here, so that whatever
/// is wrong with it is known before the first image.
///
/// # Errors
/// A model or a library that cannot be used.
pub(crate) fn selection(
    settings: &ExtractorConfig,
    options: &NetworkOptions,
) -> Result<Option<Selection>, Error> {
    let Some(config) = settings.choice() else { return Ok(None) };
    let model = Model::of(options)?;
    let (source, identity) = (Arc::new(model.network(options, settings)?), model.identity());
    Ok(Some(Selection { config, source, identity }))
}

/// The network of the settings, which must not be those of a selection without one, and how it chooses features.
///
/// # Errors
/// A model or a library that cannot be used.
pub fn open(
    settings: &ExtractorConfig,
    options: &NetworkOptions,
) -> Result<(Network, SelectionConfig), Error> {
    let config = settings.choice().ok_or(Error::NoNetwork)?;
    Ok((load(options, settings)?, config))
}

/// The network that the options name, else the built-in one.
///
/// # Errors
/// A model or a library that cannot be used.
pub fn load(options: &NetworkOptions, settings: &ExtractorConfig) -> Result<Network, Error> {
    Model::of(options)?.network(options, settings)
}
