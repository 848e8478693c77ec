//! `dsslam export`: a map for other programs.

use std::path::{Path, PathBuf};

use ::export::{ColmapFiles, PlyFrame, Scene, SceneImages, Tint};
use anyhow::{Context, anyhow, ensure};
use clap::{Args, ValueEnum};
use dsslam::trajectories::{body_of_text, of_body};
use geometry::SE3;
use io::{OpenOptions, Sensor};
use map::MapFileInfo;

use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use crate::files::folder_of;
use crate::mcap_export;

/// Arguments of `dsslam export`.
#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// Map file, as `dsslam run --save-map` writes it; with --to mcap also the results folder of a run, for the poses of all frames.
    #[arg(value_name = "MAP")]
    pub(crate) map: PathBuf,
    /// What to write.
    #[arg(long, value_enum, value_name = "FORMAT")]
    to: Format,
    /// The file to write; for colmap and nerfstudio a folder.
    #[arg(short, long, value_name = "OUT")]
    pub(crate) out: PathBuf,
    /// The map of the run whose results folder is exported: adds its points.
    #[arg(long = "map", value_name = "FILE.dsmap")]
    pub(crate) with_map: Option<PathBuf>,
    /// The sequence that the map was made from: its left images are written beside the model (without the lens's distortion, rectified)
    /// and give the points their colors.
    #[arg(long, value_name = "SEQUENCE")]
    pub(crate) images: Option<PathBuf>,
    /// What the colors of the points show [default: the images if --images is given, else the number of observations].
    #[arg(long, value_enum)]
    color: Option<ColorArg>,
    /// Which sub-map, numbered from 0 by descending number of keyframes: different sub-maps are in unrelated coordinate frames.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) submap: usize,
}

/// Formats of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Colored points, for point cloud viewers.
    Ply,
    /// Sparse model: sparse/0 (binary), text/ (the same as text), images/.
    Colmap,
    /// transforms.json, sparse_pc.ply, images/.
    Nerfstudio,
    /// Poses of the left camera at the keyframes: seconds, position, quaternion.
    Tum,
    /// Poses of the left camera at the keyframes: a 3x4 matrix per row.
    Kitti,
    /// Poses at the keyframes, of the body as in EuRoC's ground truth where the map tells its place (stereo maps of EuRoC
    /// folders), else of the left camera: nanoseconds, position, quaternion, with commas.
    Euroc,
    /// Poses at the keyframes as VSLAM-LAB's results have them: nanoseconds, position, quaternion x y z w, with commas.
    Vslamlab,
    /// Poses, transforms, path and points as ROS 2 messages, for Foxglove and ROS 2.
    Mcap,
}

/// What the colors of points show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ColorArg {
    /// How the point looks in the images.
    Image,
    /// When it was made.
    Age,
    /// How many keyframes see it.
    Observations,
}

impl Format {
    fn is_trajectory(self) -> bool {
        matches!(self, Self::Tum | Self::Kitti | Self::Euroc | Self::Vslamlab)
    }
}

/// Reads the map, writes what is wanted and prints what that is.
///
/// # Errors
/// A map or a sequence that cannot be used is a fault of the input, a file that cannot be written one of the output.
pub(crate) fn run(args: &ExportArgs) -> Result<Exit, Failure> {
    check(args).or_input()?;
    if args.to == Format::Mcap {
        return mcap_export::run(args);
    }
    let (map, info) = read(&args.map).or_input()?;
    let scene = Scene::of(&map, args.submap).with_context(|| args.map.display().to_string()).or_input()?;
    let images = args.images.as_deref().map(|dir| find_images(&scene, &info, dir)).transpose().or_input()?;
    describe(args, &info, &scene);
    match args.to {
        Format::Ply => write_ply(args, &scene, images.as_ref())?,
        Format::Colmap => write_colmap(args, &scene, images.as_ref())?,
        Format::Nerfstudio => write_nerfstudio(args, &scene, images.as_ref())?,
        Format::Tum | Format::Kitti => write_trajectory(args, &scene, &info, None)?,
        Format::Euroc | Format::Vslamlab => {
            let body_from_left = body_of_text(&info.body_from_left);
            let body_from_left = body_from_left.with_context(|| args.map.display().to_string()).or_input()?;
            write_trajectory(args, &scene, &info, body_from_left)?;
        }
        Format::Mcap => {}
    }
    Ok(Exit::Done)
}

/// What does not fit together.
fn check(args: &ExportArgs) -> anyhow::Result<()> {
    let name = args.to.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned());
    let has_colors = args.images.is_some() || args.color.is_some();
    ensure!(!(args.to.is_trajectory() && has_colors), "--images and --color have no effect with --to {name}");
    let is_run = args.to == Format::Mcap && args.map.is_dir();
    ensure!(
        args.with_map.is_none() || is_run,
        "--map needs --to mcap and the results folder of a run in the place of MAP"
    );
    let hint = "found a folder, expected a map's file; --to mcap takes the results folder of a run, too";
    ensure!(is_run || !args.map.is_dir(), "{}: {hint}", args.map.display());
    let wants_image = args.color == Some(ColorArg::Image);
    ensure!(args.images.is_some() || !wants_image, "--color image needs --images SEQUENCE");
    Ok(())
}

pub(crate) fn read(file: &Path) -> anyhow::Result<(map::Map, MapFileInfo)> {
    let bytes = io::read_file(file).with_context(|| format!("{}: cannot be read", file.display()))?;
    map::file::decode(&bytes).with_context(|| file.display().to_string())
}

/// The images of the scene; depth images are not needed, and without them no frame is left out.
pub(crate) fn find_images(scene: &Scene, info: &MapFileInfo, dir: &Path) -> anyhow::Result<SceneImages> {
    let sensor = if info.sensor == Some(Sensor::Stereo) { Sensor::Stereo } else { Sensor::Mono };
    let options = OpenOptions { sensor: Some(sensor), ..OpenOptions::default() };
    let sequence = io::open_sequence_with(dir, &options)?;
    Ok(SceneImages::find(scene, &sequence, dir)?)
}

pub(crate) fn describe(args: &ExportArgs, info: &MapFileInfo, scene: &Scene) {
    let map = args.with_map.as_ref().unwrap_or(&args.map).display();
    let kind = info.sensor.map_or("a map".to_owned(), |sensor| format!("{sensor} map"));
    console::say(format!("map          {map}: {kind} of {}", info.sequence));
    let submap = if scene.n_submaps > 1 {
        format!(" (sub-map {} of {})", args.submap, scene.n_submaps)
    } else {
        String::new()
    };
    console::say(format!("keyframes    {}{submap}", scene.views.len()));
    if args.to.is_trajectory() {
        return;
    }
    let left_out = match scene.n_single {
        0 => String::new(),
        n => format!(", {n} with a single observation skipped"),
    };
    console::say(format!("points       {}{left_out}", scene.points.len()));
    let error = scene.reprojection();
    console::say(format!(
        "reprojection {:.6} px mean of {} observations in left images; {:.6} px mean of the points' means",
        error.mean_px, error.n_observations, error.mean_of_points_px
    ));
    if scene.n_behind > 0 {
        console::note(console::warning(format!(
            "{} observations of points behind their camera were skipped",
            scene.n_behind
        )));
    }
}

/// The colors of the points; the images are written into `folder` where there is one.
pub(crate) fn colors(
    args: &ExportArgs,
    scene: &Scene,
    images: Option<&SceneImages>,
    folder: Option<&Path>,
) -> Result<Vec<[u8; 3]>, Failure> {
    let of_images = match (images, folder) {
        (Some(images), Some(folder)) => {
            io::create_output_folder(folder).or_output()?;
            Some(images.write(scene, folder).map_err(failure)?)
        }
        (Some(images), None) => Some(images.point_colors(scene).map_err(failure)?),
        (None, _) => None,
    };
    Ok(match (args.color, of_images) {
        (Some(ColorArg::Age), _) => Tint::Age.colors(scene),
        (Some(ColorArg::Observations), _) | (None | Some(ColorArg::Image), None) => {
            Tint::Observations.colors(scene)
        }
        (None | Some(ColorArg::Image), Some(colors)) => colors,
    })
}

/// An image that cannot be read is a fault of the input, the rest of the output.
fn failure(error: ::export::ExportError) -> Failure {
    let exit = if matches!(error, ::export::ExportError::File(_)) { Exit::Output } else { Exit::Input };
    Failure { exit, error: anyhow!(error) }
}

pub(crate) fn written(what: &str, place: &Path) {
    console::say(format!("written      {} ({what})", place.display()));
}

fn write_ply(args: &ExportArgs, scene: &Scene, images: Option<&SceneImages>) -> Result<(), Failure> {
    let colors = colors(args, scene, images, None)?;
    let bytes = ::export::ply(scene, &colors, PlyFrame::Map);
    io::create_output_folder(folder_of(&args.out)).or_output()?;
    io::write_atomic(&args.out, &bytes).or_output()?;
    written("PLY", &args.out);
    Ok(())
}

fn write_colmap(args: &ExportArgs, scene: &Scene, images: Option<&SceneImages>) -> Result<(), Failure> {
    let [binary, text, folder] = ["sparse/0", "text", "images"].map(|part| args.out.join(part));
    io::create_output_folder(&args.out).or_output()?;
    let colors = colors(args, scene, images, Some(&folder))?;
    let write = |folder: &Path, files: &ColmapFiles, extension: &str| {
        io::create_output_folder(folder)?;
        io::write_atomic(&folder.join(format!("cameras.{extension}")), &files.cameras)?;
        io::write_atomic(&folder.join(format!("images.{extension}")), &files.images)?;
        io::write_atomic(&folder.join(format!("points3D.{extension}")), &files.points)
    };
    write(&binary, &::export::colmap_binary(scene, &colors), "bin").or_output()?;
    write(&text, &::export::colmap_text(scene, &colors), "txt").or_output()?;
    written("COLMAP, binary", &binary);
    written("COLMAP, text", &text);
    tell_of_images(images, &folder);
    Ok(())
}

fn write_nerfstudio(args: &ExportArgs, scene: &Scene, images: Option<&SceneImages>) -> Result<(), Failure> {
    /// nerfstudio's own name for it.
    const POINTS: &str = "sparse_pc.ply";
    let folder = args.out.join("images");
    io::create_output_folder(&args.out).or_output()?;
    let colors = colors(args, scene, images, Some(&folder))?;
    let json = ::export::nerfstudio_json(scene, "images", POINTS);
    io::write_atomic(&args.out.join(POINTS), &::export::ply(scene, &colors, PlyFrame::ZUp)).or_output()?;
    io::write_atomic(&args.out.join("transforms.json"), json.as_bytes()).or_output()?;
    written("nerfstudio", &args.out.join("transforms.json"));
    tell_of_images(images, &folder);
    Ok(())
}

fn tell_of_images(images: Option<&SceneImages>, folder: &Path) {
    match images {
        Some(images) if images.are_redrawn() => written("images, rectified", folder),
        Some(_) => written("images, copied", folder),
        None => console::note(console::warning(
            "no images written: --images SEQUENCE adds the images that the model refers to",
        )),
    }
}

/// Poses of the body where it is given, else of the left camera.
fn write_trajectory(
    args: &ExportArgs,
    scene: &Scene,
    info: &MapFileInfo,
    body_from_left: Option<SE3>,
) -> Result<(), Failure> {
    let clock = io::Clock::of_stamps(info.stamps_ns.iter().copied());
    let left = ::export::trajectory(scene);
    let (trajectory, whose) = match body_from_left {
        Some(body_from_left) => (of_body(&left, &body_from_left), "body"),
        None => (left, "left camera"),
    };
    io::create_output_folder(folder_of(&args.out)).or_output()?;
    match args.to {
        Format::Kitti => io::write_kitti(&args.out, &trajectory),
        Format::Euroc => io::write_euroc_at(&args.out, &trajectory, &clock),
        Format::Vslamlab => io::write_vslamlab(&args.out, &trajectory, &clock),
        _ => io::write_tum_at(&args.out, &trajectory, &clock),
    }
    .or_output()?;
    written(&format!("{} poses of the {whose}", trajectory.poses.len()), &args.out);
    Ok(())
}
