//! The event stream of a run: what a viewer needs to show it, live or later from `events.dslog`.
//!
//! [`Record`]s are written by [`StreamWriter`] and read by [`StreamReader`]; the format is described in `format.rs`. The map
//! comes as changes ([`MapDelta`]), which a [`DeltaTracker`] makes out of snapshots. A [`Scene`] accumulates records
//! and reports which of its blocks have to be redrawn, so that a viewer sends little. Nothing here draws, and nothing
//! here is read back by a run.

mod align;
mod blocks;
mod delta;
mod error;
mod format;
mod map_delta;
mod pose;
mod reader;
mod record;
mod scene;
#[cfg(test)]
mod tests;
mod writer;

pub use align::Alignment;
pub use blocks::{Dirty, KEYFRAMES_PER_BLOCK, PATH_PER_BLOCK, POINTS_PER_BLOCK};
pub use delta::{DeltaOptions, DeltaTracker};
pub use error::{ReadError, WriteError};
pub use format::{FILE_NAME, VERSION};
pub use map_delta::{GoneKeyframe, KeyframeUpdate, MapDelta, PointUpdate};
pub use pose::Pose;
pub use reader::{Ending, StreamReader};
pub use record::{
    ActivationMap, Camera, Counts, End, FeatureState, Features, FinalPose, FramePose, FrameRecord,
    FrameState, Image, Level, Record, StageTime, Start, Text, TruePosition, Trust,
};
pub use scene::{PlacedFrame, Scene};
pub use writer::StreamWriter;
