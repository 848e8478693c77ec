//! `dsslam export --to mcap`: trajectory and map for ROS 2 and Foxglove.

use anyhow::{Context, ensure};
use dsslam::mcap::{FinalFrame, McapResults, cloud_point, write_results};
use map::{KeyframeId, Map, MapFileInfo, PointId};

use crate::console;
use crate::exit::{Exit, Failure, OrExit};
use crate::export::{ExportArgs, colors, describe, find_images, read, written};
use crate::files::folder_of;
use crate::recorded_frames::Recorded;

/// Writes the file: of a map its keyframes, of a results folder all frames, with the points of its map where one is given.
pub(crate) fn run(args: &ExportArgs) -> Result<Exit, Failure> {
    let mut results = McapResults::default();
    let map = if args.map.is_dir() {
        let recorded = Recorded::read(&args.map, args.submap).or_input()?;
        let whole = if recorded.n_submaps > 1 {
            format!(", sub-map {} of {}", args.submap, recorded.n_submaps)
        } else {
            String::new()
        };
        console::say(format!("run          {}{whole}", args.map.display()));
        console::say(format!("frames       {}", recorded.frames.len()));
        let map =
            args.with_map.as_deref().map(|file| of_root(file, &recorded.submap)).transpose().or_input()?;
        (results.frames, results.has_motion) = (recorded.frames, true);
        map
    } else {
        let (map, info) = read(&args.map).or_input()?;
        Some((map, info, args.submap))
    };
    if let Some((map, info, submap)) = map {
        add_map(args, &mut results, (&map, &info, submap))?;
    }
    io::create_output_folder(folder_of(&args.out)).or_output()?;
    write_results(&args.out, &results).or_output()?;
    let what = format!("{} poses, {} points", results.frames.len(), results.points.len());
    written(&what, &args.out);
    Ok(Exit::Done)
}

/// The map of a file, and which of its sub-maps has this root.
fn of_root(file: &std::path::Path, root: &str) -> anyhow::Result<(Map, MapFileInfo, usize)> {
    let (map, info) = read(file)?;
    let mut submap = 0;
    while let Ok(scene) = ::export::Scene::of(&map, submap) {
        let first = scene.views.first().and_then(|view| map.submap_of(KeyframeId(view.keyframe)));
        if first.is_some_and(|first| first.to_string() == root) {
            return Ok((map, info, submap));
        }
        submap += 1;
    }
    ensure!(submap > 0, "{}: found no keyframes", file.display());
    Err(anyhow::anyhow!("{}: found no sub-map {root}: the map is of another run", file.display()))
}

/// Points and camera of a map, and its keyframes where there are no frames.
fn add_map(
    args: &ExportArgs,
    results: &mut McapResults,
    (map, info, submap): (&Map, &MapFileInfo, usize),
) -> Result<(), Failure> {
    let scene =
        ::export::Scene::of(map, submap).with_context(|| args.map.display().to_string()).or_input()?;
    let images = args.images.as_deref().map(|dir| find_images(&scene, info, dir)).transpose().or_input()?;
    describe(args, info, &scene);
    let colors = colors(args, &scene, images.as_ref(), None)?;
    let points = scene.points.iter().zip(&colors);
    let points =
        points.filter_map(|(point, &color)| Some(cloud_point(map, map.point(PointId(point.id))?, color)));
    results.points = points.collect();
    if let (Some(sensor), Some(view)) = (info.sensor, scene.views.first()) {
        let rig = map.keyframe(KeyframeId(view.keyframe)).map(|keyframe| (*keyframe.frame.rig).clone());
        results.camera = rig.map(|rig| (sensor, rig));
    }
    if results.frames.is_empty() {
        let clock = io::Clock::default();
        let frame = |pose: io::StampedPose| FinalFrame {
            t_ns: clock.nanoseconds(pose.timestamp_s),
            world_from_cam: pose.world_from_cam,
            covariance: None,
        };
        results.frames = ::export::trajectory(&scene).poses.into_iter().map(frame).collect();
    }
    Ok(())
}
