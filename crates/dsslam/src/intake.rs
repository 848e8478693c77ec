//! From the images of a camera to those that SLAM sees, and from a configuration to the parameters of a run. There is no other way
//! to either: datasets, videos, cameras, rendered worlds and pushed images all take this one.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use features::{Extractor, ExtractorConfig, FeatureMask, Rig};
use io::{ImageSize, Sequence, Variant};
use runtime::{Preparation, Setup};

use crate::{Config, Error, NetworkOptions, network, setup};

/// A camera with the configuration that it leaves in force.
#[derive(Clone, Debug)]
pub(crate) struct Intake {
    /// What messages call the images.
    pub(crate) path: PathBuf,
    /// Sensor, calibration, ground truth; its list of files may be empty.
    pub(crate) sequence: Sequence,
    /// With the camera and the frame rate of the sequence.
    pub(crate) config: Config,
    /// Size of the raw images of one camera.
    pub(crate) size: ImageSize,
    /// Reduces and rectifies.
    pub(crate) preparation: Preparation,
    /// What the user should know before the run.
    pub(crate) notices: Vec<String>,
}

impl Intake {
    /// The intake of a sequence whose raw images have this size; `None`: that of its files.
    ///
    /// # Errors
    /// Images of another size than the configuration's camera, or none that can be read.
    pub(crate) fn new(
        path: &Path,
        sequence: Sequence,
        size: Option<ImageSize>,
        config: &Config,
    ) -> Result<Self, Error> {
        let (config, notices) = in_force(config, &sequence);
        let size = match size {
            None => setup::image_size(&sequence, &config)?,
            Some(size) => {
                setup::check_size(size, path, &config)?;
                size
            }
        };
        let preparation = Preparation::new(&sequence, config.input.scale);
        Ok(Self { path: path.to_path_buf(), sequence, config, size, preparation, notices })
    }

    /// The intake of a variant of the same images.
    pub(crate) fn varied(mut self, variant: Variant) -> Self {
        self.sequence = variant.of(self.sequence, self.config.camera.baseline_m.unwrap_or(0.0));
        self.preparation = self.preparation.varied(variant);
        self.config.camera.fps /= variant.every as f64;
        self
    }

    /// Where features may be taken: not where the configuration's mask is 0, nor in a border that rectification leaves; `None`:
    /// everywhere.
    ///
    /// # Errors
    /// A mask that is not an image, or has another size than the images.
    pub(crate) fn mask(&self, extractor: &ExtractorConfig) -> Result<Option<FeatureMask>, Error> {
        let wanted = setup::wanted_mask(&self.config, self.size)?;
        Ok(self.preparation.mask(extractor, wanted.as_ref()))
    }

    /// The settings of features in force, those of the sensor.
    pub(crate) fn features(&self) -> ExtractorConfig {
        self.config.features.with_sensor(self.sequence.sensor)
    }

    /// What extracts features of the left image; with a network that selects among them, its candidates.
    ///
    /// # Errors
    /// As [`Intake::mask`].
    pub(crate) fn extractor(&self) -> Result<Extractor, Error> {
        let config = self.features();
        let mask = self.mask(&config)?;
        Ok(Extractor::new(config).with_mask(mask.map(Arc::new)))
    }

    /// The camera after reduction and rectification.
    ///
    /// # Errors
    /// A missing camera.
    pub(crate) fn rig(&self) -> Result<Rig, Error> {
        let rig = setup::rig(&self.config, self.sequence.sensor, self.size, &self.path)?;
        Ok(if self.preparation.is_mirrored() { rig.mirrored() } else { rig })
    }

    /// Camera, parameters, mask and network of a run, without vocabulary.
    ///
    /// # Errors
    /// A camera that nobody gives, a mask or a network that cannot be used.
    pub(crate) fn setup(&self, options: &NetworkOptions) -> Result<Setup, Error> {
        let mut setup = setup::from_config(&self.config, self.sequence.sensor, self.rig()?);
        setup.mask = self.mask(&setup.extractor)?.map(Arc::new);
        setup.selection = network::selection(&self.features(), options)?;
        Ok(setup)
    }
}

/// The configuration with what the sequence knows better, its camera and its frame rate; and what the user should know of it.
fn in_force(config: &Config, sequence: &Sequence) -> (Config, Vec<String>) {
    let mut config = config.clone();
    let mut notices = config.renamed_keys().to_vec();
    notices.extend(sequence.warnings.iter().cloned());
    if let Some(calibration) = &sequence.calibration {
        notices.extend(config.apply_calibration(calibration));
    }
    let source = sequence.calibration.as_ref().map_or(&sequence.name, |calibration| &calibration.source);
    notices.extend(sequence.frame_rate_hz.and_then(|rate| config.apply_frame_rate(rate, source)));
    notices.extend(sequence.depth_units_per_metre.and_then(|units| config.apply_depth_units(units, source)));
    (config, notices)
}
