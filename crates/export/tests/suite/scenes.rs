//! What of a map becomes a scene.

use dsslam_export::{ExportError, Scene, Tint};
use geometry::Distortion;
use map::Parent;

use super::world::*;

#[test]
fn the_error_is_that_of_the_features_in_pixels() {
    let scene = Scene::of(&street(), 0).unwrap();
    assert_eq!((scene.views.len(), scene.points.len()), (3, N_POINTS as usize - 1));
    assert_eq!((scene.n_single, scene.n_behind, scene.n_submaps), (1, 0, 1));
    let error = scene.reprojection();
    assert_eq!(error.n_observations, 3 * (N_POINTS as usize - 1));
    // One observation of three is 0.5 px off; features are 32-bit.
    assert!((error.mean_px - 0.5 / 3.0).abs() < 1e-5, "{error:?}");
    assert!((error.mean_of_points_px - 0.5 / 3.0).abs() < 1e-5, "{error:?}");
}

#[test]
fn views_and_points_name_each_other() {
    let scene = Scene::of(&street(), 0).unwrap();
    let mut n_links = 0;
    for (v, view) in scene.views.iter().enumerate() {
        for (f, point) in view.points.iter().enumerate() {
            let Some(point) = point else { continue };
            n_links += 1;
            assert!(scene.points[*point].track.contains(&(v, f)));
            let pixel = scene.project(v, &scene.points[*point].position).unwrap();
            assert!((pixel - view.pixels[f]).norm() < 0.51);
        }
    }
    assert_eq!(n_links, scene.reprojection().n_observations);
}

#[test]
fn the_largest_submap_is_the_first() {
    let mut map = street();
    let rig = rig(Distortion::default());
    insert(&mut map, &rig, 9, Parent::NewSubmap, Vec::new());
    for index in 10..13 {
        let newest = map.newest_keyframe().unwrap();
        insert(&mut map, &rig, index, Parent::Under(newest), Vec::new());
    }
    let frames = |submap: usize| -> Vec<u32> {
        Scene::of(&map, submap).unwrap().views.iter().map(|view| view.frame).collect()
    };
    assert_eq!((frames(0), frames(1)), (vec![9, 10, 11, 12], vec![0, 4, 8]));
    let scene = Scene::of(&map, 1).unwrap();
    assert_eq!((scene.points.len(), scene.n_submaps), (N_POINTS as usize - 1, 2));
    let error = Scene::of(&map, 2).unwrap_err();
    assert_eq!(error, ExportError::NoSuchSubmap { wanted: 2, n_submaps: 2 });
    assert_eq!(
        error.to_string(),
        "found no sub-map 2: the map has 2, numbered from 0 by their number of keyframes"
    );
}

#[test]
fn image_names_are_those_of_the_frames_unless_two_are_the_same() {
    let names = |map: &map::Map| -> Vec<String> {
        Scene::of(map, 0).unwrap().views.into_iter().map(|view| view.name).collect()
    };
    let mut map = street();
    assert_eq!(names(&map), ["000000.png", "000004.png", "000008.png"]);
    insert(&mut map, &rig(Distortion::default()), 4, Parent::Closest, Vec::new());
    assert_eq!(names(&map), (0..4).map(|k| format!("keyframe_{k:06}.png")).collect::<Vec<_>>());
}

#[test]
fn cameras_are_shared() {
    let mut map = street();
    let mut other = (*rig(Distortion::default())).clone();
    other.width += 10;
    insert(&mut map, &other.into(), 20, Parent::Closest, Vec::new());
    let scene = Scene::of(&map, 0).unwrap();
    assert_eq!(scene.cameras.len(), 2);
    assert_eq!(scene.views.iter().map(|view| view.camera).collect::<Vec<_>>(), [0, 0, 0, 1]);
}

#[test]
fn tints_span_the_whole_gradient() {
    let mut scene = Scene::of(&street(), 0).unwrap();
    for (i, point) in scene.points.iter_mut().enumerate() {
        point.created_by = i as u32;
        point.track.truncate(2 + i % 2);
    }
    let (age, observations) = (Tint::Age.colors(&scene), Tint::Observations.colors(&scene));
    let ends = [draw::gradient(0.0), draw::gradient(1.0)];
    assert_eq!([age[0], age[age.len() - 1]], ends);
    assert_eq!([observations[0], observations[1]], ends);
    // All alike: no division by zero.
    scene.points.iter_mut().for_each(|point| point.created_by = 7);
    assert!(Tint::Age.colors(&scene).iter().all(|color| *color == ends[0]));
}
