//! Why there is no run: everything that can be wrong with configuration, images, network, vocabulary and map files.

use std::path::PathBuf;

use bow::{FormatError, VocabularyError};
use io::{ConfigErrors, DatasetError, FileError, ImageError, ImageSize, Sensor, VideoError};
use map::MapFileError;
use runtime::{RunEnded, RunError, StageFailure};

use crate::CameraError;

/// Why something cannot be used. The message names the file or the key, what was found and what was expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The configuration.
    #[error(transparent)]
    Config(#[from] ConfigErrors),
    /// Nobody gives the camera.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The folder of images.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// An image.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// Every image.
    #[error("none of the sequence's images can be read: {0}")]
    NoImage(ImageError),
    /// The mask of the configuration.
    #[error("{place}: {problem}")]
    Mask {
        /// The key, and where its value comes from.
        place: String,
        /// What is wrong with the file.
        problem: ImageError,
    },
    /// The mask of the configuration has another size than the images.
    #[error("{place}: {}: found {found} pixels, expected {expected}, the size of the images", path.display())]
    MaskSize {
        /// The key, and where its value comes from.
        place: String,
        /// The file.
        path: PathBuf,
        /// Its size.
        found: ImageSize,
        /// The size of the images before they are reduced.
        expected: ImageSize,
    },
    /// The activation network or its library.
    #[error("{origin}: {problem}")]
    Network {
        /// Where the network comes from.
        origin: String,
        /// What is wrong.
        problem: dsfeat::Error,
    },
    /// A network is needed and the configuration names none.
    #[error("features.selection is response, which has no network")]
    NoNetwork,
    /// The vocabulary of a file.
    #[error(transparent)]
    Vocabulary(#[from] VocabularyError),
    /// The vocabulary that is part of the library.
    #[error("the built-in vocabulary: {0}")]
    BuiltInVocabulary(#[from] FormatError),
    /// A file that cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A map's file.
    #[error("{}: {problem}", path.display())]
    Map {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: MapFileError,
    },
    /// A map that was made with another kind of camera.
    #[error("{}: the map was made with sensor {found}, this run has {expected}", path.display())]
    MapSensor {
        /// The file.
        path: PathBuf,
        /// The sensor of the map.
        found: String,
        /// The sensor of the run.
        expected: Sensor,
    },
    /// The pose of the camera in the body, as a map's file tells it.
    #[error("body_from_left: found `{found}`, expected the 12 numbers of a 3x4 pose")]
    Body {
        /// What stands there.
        found: String,
    },
    /// A bag.
    #[error(transparent)]
    Bag(#[from] bag::BagError),
    /// The stream of a video or a camera.
    #[error(transparent)]
    Video(#[from] VideoError),
    /// Nothing can decode a video.
    #[error(
        "{}: only .y4m videos can be read without a decoder; neither {} (./install.sh --video) nor {} was found in PATH",
        path.display(), crate::video::HELPER, crate::video::FFMPEG
    )]
    NoDecoder {
        /// The video.
        path: PathBuf,
    },
    /// The program that decodes a video.
    #[error("{}: cannot be started: {reason}", program.display())]
    Decoder {
        /// The program.
        program: PathBuf,
        /// What the operating system says.
        reason: String,
    },
    /// The program that decodes a video gives no images.
    #[error("{} cannot decode it: {problem}", program.display())]
    Undecodable {
        /// The program.
        program: PathBuf,
        /// What comes instead.
        problem: VideoError,
    },
    /// The configuration's camera has no image size.
    #[error("camera.width and camera.height: found none, expected the size of the images in pixels")]
    NoImageSize,
    /// A frame that was not taken.
    #[error("the frame at {t_ns} ns: {problem}")]
    Frame {
        /// Its time, nanoseconds.
        t_ns: i64,
        /// What is wrong.
        problem: FrameProblem,
    },
    /// Ground truth is named for something whose frames are not files.
    #[error("{}: ground truth can be given for folders of images only", path.display())]
    GroundTruth {
        /// The video or camera.
        path: PathBuf,
    },
    /// A variant is wanted of something whose frames are not files.
    #[error("{}: there are variants of folders of images only", path.display())]
    Variant {
        /// The video or camera.
        path: PathBuf,
    },
    /// A run cannot be compared with its ground truth.
    #[error("{0}")]
    Evaluation(String),
    /// The run cannot begin.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A stage has failed, which is a bug.
    #[error(transparent)]
    Stage(#[from] StageFailure),
    /// A stage has ended the run; its results say why.
    #[error(transparent)]
    Ended(#[from] RunEnded),
}

/// Why a frame was not taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameProblem {
    /// An image does not have the size of the camera.
    #[error("found {found} pixels in the {image} image, expected {expected} as the camera has")]
    Size {
        /// `left`, `right`, `depth` or `mask`.
        image: &'static str,
        /// Its size.
        found: ImageSize,
        /// That of the camera.
        expected: ImageSize,
    },
    /// There are fewer values than the size says.
    #[error(
        "found {found} values in the {image} image, expected at least {expected} with a stride of {stride}"
    )]
    Short {
        /// `left`, `right`, `depth` or `mask`.
        image: &'static str,
        /// Values that are there.
        found: usize,
        /// Values that the size asks for.
        expected: usize,
        /// From a row to the next.
        stride: usize,
    },
    /// An image of the sensor is not there.
    #[error("found no {image} image, expected one with sensor {sensor}")]
    Missing {
        /// `right` or `depth`.
        image: &'static str,
        /// The sensor.
        sensor: Sensor,
    },
    /// There is an image that the sensor does not have.
    #[error("found a {image} image, expected none with sensor {sensor}")]
    Unexpected {
        /// `right` or `depth`.
        image: &'static str,
        /// The sensor.
        sensor: Sensor,
    },
    /// Time does not go on.
    #[error("expected a time after that of the last frame, {last_ns} ns")]
    Time {
        /// Time of the last frame that was taken, nanoseconds.
        last_ns: i64,
    },
}

impl Error {
    /// A file that the operating system does not let be read.
    pub(crate) fn unreadable(path: &std::path::Path, reason: &std::io::Error) -> Self {
        Self::File(FileError::Unreadable { path: path.to_path_buf(), reason: reason.to_string() })
    }
}
