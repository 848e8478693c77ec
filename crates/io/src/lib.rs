//! Datasets, images, configuration and trajectories: everything that is read before a run and written after it.
//!
//! Start reading at [`open_sequence`] (which frames there are), [`load_frame`] (their pixels) and [`read_config`]
//! (how to process them). Every error names the file, the line or key, what was found and what was expected.

mod config;
mod dataset;
mod document;
mod file;
mod images;
mod trajectory;
mod video;

pub use config::{
    CameraSettings, ConfigErrors, ConfigSource, Explained, InputSettings, Origins, Problem, Provenance,
    explain, read_config, to_yaml,
};
pub use dataset::{
    Calibration, CameraFile, DatasetError, FrameSource, OpenOptions, Packing, RawCalibration, RawCamera,
    RectifiedView, Sequence, SequenceKind, Times, Variant, VariantError, Video, associate, layout_of,
    nanoseconds_of, open_cameras, open_sequence, open_sequence_with, open_video, read_calibration, seconds,
};
pub use file::{FileError, check_file, create_output_folder, read_file, write_atomic, write_durable};
pub use geometry::Sensor;
pub use images::{
    ImageError, ImageSize, LoadedFrame, Preview, Rgb, brightness, check_size, image_size, load_depth,
    load_frame, load_gray, load_rgb, preview, reduce_depth, reduce_gray, save_png_depth, save_png_gray,
    save_png_rgb,
};
pub use trajectory::{
    Clock, Stamp, StampedPose, Stamps, Trajectory, TrajectoryFile, TrajectoryFormat, read_trajectory,
    write_euroc, write_euroc_at, write_kitti, write_tum, write_tum_at, write_vslamlab,
};
pub use video::{VideoError, VideoFrame, VideoHeader, VideoReader};
