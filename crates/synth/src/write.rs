//! Writes a world in KITTI's odometry layout.

use crate::preset::Preset;
use crate::town::{LABEL_MOVING, LABEL_PARKED, LABEL_SKY, LABEL_STATIC};
use crate::world::{StereoFrame, World};
use geometry::{DepthImage, GrayImage, Raster};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Depth images hold meters times this; 0 where there is none or it is too far.
pub const DEPTH_UNITS_PER_METRE: f64 = 256.0;

/// What is written besides images, calibration, times and poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Only this many frames from the start.
    pub max_frames: Option<usize>,
    /// `masks/NNNNNN.png` with the label of each pixel of the left image.
    pub masks: bool,
    /// `depth/NNNNNN.png`, 16 bits, [`DEPTH_UNITS_PER_METRE`] units per meter.
    pub depth: bool,
}

/// What can go wrong while writing.
#[derive(Debug, Error)]
pub enum WriteError {
    /// A folder cannot be made.
    #[error("{}: cannot create folder: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error("{}: cannot write: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// An image cannot be written; the message names the file.
    #[error(transparent)]
    Image(#[from] io::FileError),
}

/// How far the writing is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Frames written so far.
    pub done: usize,
    /// Frames in all.
    pub total: usize,
}

/// Whether to go on after a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Continue {
    /// Write the next frame.
    Yes,
    /// Stop here; what is written so far is a complete, shorter sequence.
    No,
}

/// Writes `calib.txt`, `times.txt`, `poses.txt`, `synth.json`, `image_0/`, `image_1/` and what the options ask for into `out_dir`
/// (created if missing). `progress` hears of every frame and may stop the writing. Returns the number of frames written.
///
/// # Errors
/// When a folder or file cannot be written; the message names it.
pub fn write_kitti(
    world: &World,
    out_dir: &Path,
    options: &WriteOptions,
    progress: &mut dyn FnMut(Progress) -> Continue,
) -> Result<usize, WriteError> {
    let total = options.max_frames.map_or(world.n_frames(), |n| n.min(world.n_frames()));
    let mut folders = vec!["image_0", "image_1"];
    folders.extend(options.masks.then_some("masks"));
    folders.extend(options.depth.then_some("depth"));
    for folder in &folders {
        let path = out_dir.join(folder);
        std::fs::create_dir_all(&path).map_err(|source| WriteError::Folder { path, source })?;
    }
    write_text(&out_dir.join("calib.txt"), &calibration(world))?;
    let mut done = 0;
    while done < total {
        write_frame(world, done, out_dir, options)?;
        done += 1;
        if progress(Progress { done, total }) == Continue::No {
            break;
        }
    }
    write_text(&out_dir.join("times.txt"), &times(world, done))?;
    write_text(&out_dir.join("poses.txt"), &poses(world, done))?;
    write_text(&out_dir.join("synth.json"), &description(world, options, done))?;
    Ok(done)
}

fn write_frame(world: &World, i: usize, out_dir: &Path, options: &WriteOptions) -> Result<(), WriteError> {
    let path = |folder: &str| out_dir.join(folder).join(format!("{i:06}.png"));
    let save = |folder: &str, image: &GrayImage| io::save_png_gray(&path(folder), image);
    if !options.masks && !options.depth {
        let images = world.images(i);
        let (left, right) = rayon::join(|| save("image_0", &images.left), || save("image_1", &images.right));
        return Ok(left.and(right)?);
    }
    let StereoFrame { left, right, depth_m, labels, .. } = world.frame(i);
    let (images, truth) = rayon::join(
        || save("image_0", &left).and_then(|()| save("image_1", &right)),
        || {
            if options.masks {
                save("masks", &labels)?;
            }
            if options.depth { io::save_png_depth(&path("depth"), &in_units(&depth_m)) } else { Ok(()) }
        },
    );
    Ok(images.and(truth)?)
}

/// 16-bit depth; what is farther than it can say becomes 0.
fn in_units(depth_m: &Raster<f32>) -> DepthImage {
    let unit = |d: &f32| {
        let units = (f64::from(*d) * DEPTH_UNITS_PER_METRE).round();
        if units <= f64::from(u16::MAX) { units as u16 } else { 0 }
    };
    DepthImage { width: depth_m.width, height: depth_m.height, data: depth_m.data.iter().map(unit).collect() }
}

pub(crate) fn write_text(path: &Path, text: &str) -> Result<(), WriteError> {
    std::fs::write(path, text).map_err(|source| WriteError::File { path: path.to_path_buf(), source })
}

/// `P0` and `P1`, 3x4 row by row; P1's fourth number is -fx times the baseline.
fn calibration(world: &World) -> String {
    let rig = world.rig();
    let c = rig.camera;
    let line = |name: &str, shift: f64| {
        let rows = [[c.fx, 0.0, c.cx, shift], [0.0, c.fy, c.cy, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let numbers: Vec<String> = rows.concat().iter().map(|v| format!("{v:.12e}")).collect();
        format!("{name}: {}\n", numbers.join(" "))
    };
    line("P0", 0.0) + &line("P1", -c.fx * rig.baseline_m)
}

fn times(world: &World, n: usize) -> String {
    let mut text = String::new();
    for i in 0..n {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:.6e}", world.timestamp_s(i));
    }
    text
}

fn poses(world: &World, n: usize) -> String {
    let mut text = String::new();
    for i in 0..n {
        let row = world.world_from_cam(i).rows_3x4().map(|v| format!("{v:.12e}")).join(" ");
        let _ = writeln!(text, "{row}");
    }
    text
}

/// Contents of `synth.json`.
#[derive(Serialize)]
struct Description {
    generator: &'static str,
    version: &'static str,
    preset: Preset,
    seed: u64,
    rounds: u32,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    relit: bool,
    frames: usize,
    frame_rate_hz: f64,
    course_length_m: f64,
    closed: bool,
    width: usize,
    height: usize,
    baseline_m: f64,
    masks: Option<Masks>,
    depth_units_per_metre: Option<f64>,
}

#[derive(Serialize)]
struct Masks {
    r#static: u8,
    moving: u8,
    parked: u8,
    sky: u8,
}

fn description(world: &World, options: &WriteOptions, frames: usize) -> String {
    let (width, height) = world.image_size();
    let labels = Masks { r#static: LABEL_STATIC, moving: LABEL_MOVING, parked: LABEL_PARKED, sky: LABEL_SKY };
    let description = Description {
        generator: "dsslam synth",
        version: env!("CARGO_PKG_VERSION"),
        preset: world.preset(),
        seed: world.seed(),
        rounds: world.rounds(),
        relit: world.is_relit(),
        frames,
        frame_rate_hz: crate::world::FRAME_RATE_HZ,
        course_length_m: world.course_length_m(),
        closed: world.is_closed(),
        width,
        height,
        baseline_m: world.rig().baseline_m,
        masks: options.masks.then_some(labels),
        depth_units_per_metre: options.depth.then_some(DEPTH_UNITS_PER_METRE),
    };
    // Plain numbers and names always have a JSON form.
    serde_json::to_string_pretty(&description).unwrap_or_default() + "\n"
}
