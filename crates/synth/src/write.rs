//! Writes a world in KITTI's odometry layout.

use crate::preset::Preset;
use crate::town::{LABEL_MOVING, LABEL_PARKED, LABEL_SKY, LABEL_STATIC};
use crate::world::{StereoFrame, World};
use geometry::{DepthImage, GrayImage, Raster};
use io::FileError;
use serde::Serialize;
use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::path::Path;

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

/// Writes `calib.txt`, `times.txt`, `poses.txt`, `synth.json`, `image_0/`, `image_1/` and what the options ask for into `out_dir`
/// (created if missing). `progress` hears how many frames there are after each, and may stop the writing: what is
/// written so far is a complete, shorter sequence. Returns the number of frames written.
///
/// # Errors
/// When a folder or file cannot be written; the message names it.
pub fn write_kitti(
    world: &World,
    out_dir: &Path,
    options: &WriteOptions,
    progress: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<usize, FileError> {
    let mut folders = vec!["image_0", "image_1"];
    folders.extend(options.masks.then_some("masks"));
    folders.extend(options.depth.then_some("depth"));
    for folder in &folders {
        io::create_output_folder(&out_dir.join(folder))?;
    }
    io::write_atomic(&out_dir.join("calib.txt"), calibration(world).as_bytes())?;
    let done = each_frame(world, options.max_frames, progress, |i| write_frame(world, i, out_dir, options))?;
    io::write_atomic(&out_dir.join("times.txt"), times(world, done).as_bytes())?;
    io::write_atomic(&out_dir.join("poses.txt"), poses(world, done).as_bytes())?;
    io::write_atomic(&out_dir.join("synth.json"), description(world, options, done).as_bytes())?;
    Ok(done)
}

/// Writes frame after frame; returns how many.
pub(crate) fn each_frame(
    world: &World,
    max_frames: Option<usize>,
    progress: &mut dyn FnMut(usize) -> ControlFlow<()>,
    write: impl Fn(usize) -> Result<(), FileError>,
) -> Result<usize, FileError> {
    let total = max_frames.map_or(world.n_frames(), |n| n.min(world.n_frames()));
    for i in 0..total {
        write(i)?;
        if progress(i + 1).is_break() {
            return Ok(i + 1);
        }
    }
    Ok(total)
}

fn write_frame(world: &World, i: usize, out_dir: &Path, options: &WriteOptions) -> Result<(), FileError> {
    let path = |folder: &str| out_dir.join(folder).join(format!("{i:06}.png"));
    let save = |folder: &str, image: &GrayImage| io::save_png_gray(&path(folder), image);
    if !options.masks && !options.depth {
        let images = world.images(i);
        let (left, right) = rayon::join(|| save("image_0", &images.left), || save("image_1", &images.right));
        return left.and(right);
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
    images.and(truth)
}

/// 16-bit depth; what is farther than it can say becomes 0.
fn in_units(depth_m: &Raster<f32>) -> DepthImage {
    let unit = |d: &f32| DepthImage::value(f64::from(*d) * DEPTH_UNITS_PER_METRE);
    DepthImage { width: depth_m.width, height: depth_m.height, data: depth_m.data.iter().map(unit).collect() }
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
    #[serde(skip_serializing_if = "Vec::is_empty")]
    spot_turns_deg: Vec<f64>,
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
        spot_turns_deg: world.turns().by_deg.clone(),
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
