//! Command line of everything that has to do with the activation network.

use std::path::PathBuf;

use clap::Args;
use dsslam::NetworkOptions;

use super::SettingsArgs;

/// Arguments about the network.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct NetworkArgs {
    /// Network (ONNX) to use instead of the built-in one: gray image in, activation map out.
    #[arg(long, value_name = "FILE", help_heading = "Network")]
    pub(crate) dsfeat_model: Option<PathBuf>,
    /// ONNX Runtime's library [default: ORT_DYLIB_PATH, else libonnxruntime.so beside the program, in
    /// ~/.local/share/dsslam or in the system folders; without it the network runs several times slower].
    #[arg(long, value_name = "FILE", help_heading = "Network")]
    pub(crate) onnxruntime: Option<PathBuf>,
}

impl NetworkArgs {
    /// The same for the library.
    pub(crate) fn options(&self) -> NetworkOptions {
        let mut options = NetworkOptions::default();
        (options.model, options.library) = (self.dsfeat_model.clone(), self.onnxruntime.clone());
        options
    }
}

/// Arguments of `dsslam inspect activation`.
#[derive(Debug, Args)]
pub(crate) struct ActivationArgs {
    /// The image, PNG or JPEG.
    #[arg(value_name = "IMAGE")]
    pub(crate) image: PathBuf,
    /// The picture to write, PNG.
    #[arg(short = 'o', long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// Maximum number of features kept.
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) keep: u32,
    /// The configuration.
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
    /// The network.
    #[command(flatten)]
    pub(crate) network: NetworkArgs,
}
