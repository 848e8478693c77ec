//! The activation network of a run: which model, which library, how its maps choose features.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use dsfeat::{BUILT_IN, Network};
use features::{ExtractorConfig, NetworkSize, SelectionConfig};
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

/// Opens networks for a run.
#[derive(Debug)]
struct Opener {
    model: Vec<u8>,
    /// Where the model comes from.
    origin: String,
    library: Option<PathBuf>,
    threads: usize,
    size: NetworkSize,
}

impl Opener {
    fn new(options: &NetworkOptions, settings: &ExtractorConfig) -> Result<Self, Error> {
        let (model, origin) = match &options.model {
            Some(file) => (read(file)?, file.display().to_string()),
            None => (BUILT_IN.to_vec(), "the built-in network".to_owned()),
        };
        let (threads, size) = (settings.network_threads, settings.network_size);
        Ok(Opener { model, origin, library: options.library.clone(), threads, size })
    }

    /// A number for the model, which the maps depend on beside the image and the settings.
    fn identity(&self) -> u64 {
        let digest = Sha256::digest(&self.model);
        digest.iter().take(8).fold(0, |number, byte| number << 8 | u64::from(*byte))
    }

    fn network(&self) -> Result<Network, Error> {
        Network::load(&self.model, self.library.as_deref(), self.threads)
            .map(|network| network.with_size(self.size))
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
    let opener = Opener::new(options, settings)?;
    let (source, identity) = (Arc::new(opener.network()?), opener.identity());
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
    Opener::new(options, settings)?.network()
}

fn read(file: &Path) -> Result<Vec<u8>, Error> {
    io::read_file(file).map_err(|reason| Error::unreadable(file, &reason))
}
