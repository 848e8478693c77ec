//! What selects features in a run: the rule, and where its activation maps come from.

use std::fmt::Debug;
use std::sync::Arc;

use features::{ActivationSource, SelectionConfig};

/// A selection and its network.
#[derive(Clone, Debug)]
pub struct Selection {
    /// By what features are chosen, and how many are kept.
    pub config: SelectionConfig,
    /// Gives each extraction stage a network of its own.
    pub source: Arc<dyn ActivationFactory>,
}

/// Opens sources of activation maps that all give the same maps.
pub trait ActivationFactory: Debug + Send + Sync {
    /// A source.
    ///
    /// # Errors
    /// Why there is none, in words.
    fn open(&self) -> Result<Box<dyn ActivationSource>, String>;

    /// A number for what the maps depend on beside the image.
    fn identity(&self) -> u64;
}
