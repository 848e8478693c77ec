//! Writes a world in EuRoC's layout: raw, unrectified images of two cameras with lenses, and the poses of a body.

use crate::lens::{Lens, LensCamera};
use crate::world::{FRAME_RATE_HZ, World};
use crate::write::each_frame;
use geometry::{CameraModel, Distortion, KannalaBrandt, Rational, SE3, SO3, Vec3};
use io::{FileError, StampedPose, Trajectory};
use std::ops::ControlFlow;
use std::path::Path;

/// Time of the first frame, nanoseconds since 1970.
const START_NS: u64 = 1_400_000_000_000_000_000;

/// Pose of the drive's left camera in the body: the body's x points forward, y to the left, z up.
fn body_from_rig() -> SE3 {
    let axes = geometry::Mat3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    SE3::new(SO3::from_matrix(&axes), Vec3::new(0.12, 0.25, -0.04))
}

/// Writes `mav0/cam0`, `mav0/cam1` (each with `data.csv`, `sensor.yaml` and `data/`) and `mav0/state_groundtruth_estimate0/data.csv` into
/// `out_dir` (created if missing), at most `max_frames` frames. `progress` hears how many there are after each, and may stop the writing. Returns
/// the number of frames written.
///
/// # Errors
/// When a folder or file cannot be written; the message names it.
pub fn write_euroc(
    world: &World,
    out_dir: &Path,
    lens: Lens,
    max_frames: Option<usize>,
    progress: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<usize, FileError> {
    let root = out_dir.join("mav0");
    let folders = ["cam0", "cam1"].map(|name| root.join(name));
    let truth = root.join("state_groundtruth_estimate0");
    for path in folders.iter().map(|folder| folder.join("data")).chain([truth.clone()]) {
        io::create_output_folder(&path)?;
    }
    let cameras = lens.cameras();
    for (camera, folder) in cameras.iter().zip(&folders) {
        io::write_atomic(&folder.join("sensor.yaml"), sensor_yaml(camera).as_bytes())?;
    }
    let rig = world.lens_rig(&cameras);
    let done = each_frame(world, max_frames, progress, |frame| {
        let (images, name) = (rig.images(frame), format!("{}.png", stamp(frame)));
        let save = |i: usize| io::save_png_gray(&folders[i].join("data").join(&name), &images[i]);
        let (left, right) = rayon::join(|| save(0), || save(1));
        left.and(right)
    })?;
    for folder in &folders {
        io::write_atomic(&folder.join("data.csv"), image_list(done).as_bytes())?;
    }
    io::write_euroc(&truth.join("data.csv"), &poses(world, done))?;
    Ok(done)
}

/// Nanoseconds of a frame.
fn stamp(i: usize) -> u64 {
    START_NS + i as u64 * (1e9 / FRAME_RATE_HZ) as u64
}

fn image_list(n: usize) -> String {
    let rows: Vec<String> = (0..n).map(stamp).map(|ns| format!("{ns},{ns}.png\n")).collect();
    format!("#timestamp [ns],filename\n{}", rows.concat())
}

/// Poses of the body.
fn poses(world: &World, n: usize) -> Trajectory {
    let rig_from_body = body_from_rig().inverse();
    let pose = |i: usize| StampedPose {
        timestamp_s: stamp(i) as f64 / 1e9,
        world_from_cam: world.world_from_cam(i) * rig_from_body,
    };
    Trajectory { poses: (0..n).map(pose).collect() }
}

fn sensor_yaml(camera: &LensCamera) -> String {
    let m = (body_from_rig() * camera.rig_from_cam).matrix();
    let rows: Vec<String> =
        (0..4).map(|r| (0..4).map(|c| format!("{:.12}", m[(r, c)])).collect::<Vec<_>>().join(", ")).collect();
    let pinhole = camera.model.pinhole();
    let (model, coefficients) = match camera.model {
        CameraModel::Pinhole { distortion: Distortion { k1, k2, p1, p2, .. }, .. } => {
            ("radial-tangential", vec![k1, k2, p1, p2])
        }
        CameraModel::Rational(Rational {
            upper: Distortion { k1, k2, p1, p2, k3 },
            lower: [k4, k5, k6],
            ..
        }) => ("rational-polynomial", vec![k1, k2, p1, p2, k3, k4, k5, k6]),
        CameraModel::KannalaBrandt(KannalaBrandt { k1, k2, k3, k4, .. }) => {
            ("equidistant", vec![k1, k2, k3, k4])
        }
    };
    format!(
        "# a rendered camera\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [{}]\nrate_hz: {FRAME_RATE_HZ}\n\
         resolution: [{}, {}]\ncamera_model: pinhole\nintrinsics: [{}, {}, {}, {}]\ndistortion_model: {model}\n\
         distortion_coefficients: {coefficients:?}\n",
        rows.join(",\n         "),
        camera.size.0,
        camera.size.1,
        pinhole.fx,
        pinhole.fy,
        pinhole.cx,
        pinhole.cy
    )
}
