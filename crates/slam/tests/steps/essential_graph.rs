//! The essential graph: spanning tree, loops, strong covisibility, each pair once.

use map::Correction;

use super::*;
use crate::scene::{Scene, add, add_under, at, chain, gap, line};

fn edges(map: &Map, member: u32, min_weight: u32) -> Vec<(u32, u32, bool)> {
    let graph = EssentialGraph::new(map, KeyframeId(member), min_weight);
    graph.edges.iter().map(|e| (graph.nodes[e.a].0, graph.nodes[e.b].0, e.is_loop)).collect()
}

/// A chain of four, and a fifth keyframe under the first that shares ten points with the second.
fn world() -> Map {
    let mut map = chain(&line(4, 1.0), 16);
    let scene = Scene::wall(20);
    let matches: Vec<(u32, u32)> = (0..10).map(|i| (i, 16 + i)).collect();
    let pose = at(0.5, 0.0, 0.0);
    add_under(&mut map, scene.whole(4, &pose), &pose, &matches, &[], map::Parent::Under(KeyframeId(0)));
    map
}

#[test]
fn the_spanning_tree_is_always_there_and_covisibility_from_its_weight_on() {
    let map = world();
    let tree = [(0, 1, false), (0, 4, false), (1, 2, false), (2, 3, false)];
    assert_eq!(edges(&map, 0, 100), tree);
    // The points that 1 made are shown by 2 and by 4.
    let with_covisible = |weight| edges(&map, 0, weight).len() - tree.len();
    assert_eq!([with_covisible(11), with_covisible(10)], [0, 2]);
    assert!(edges(&map, 3, 10).contains(&(1, 4, false)) && edges(&map, 3, 10).contains(&(2, 4, false)));
}

#[test]
fn a_loop_is_an_edge_of_its_own_kind_and_replaces_the_other() {
    let mut map = world();
    let loop_edges = vec![(KeyframeId(3), KeyframeId(0)), (KeyframeId(1), KeyframeId(2))];
    let correction = Correction { loop_edges, seen_revision: map.revision(), ..Correction::default() };
    map.apply_correction(&correction).unwrap();
    assert_eq!(
        edges(&map, 0, 100),
        [(0, 1, false), (0, 4, false), (2, 3, false), (0, 3, true), (1, 2, true)]
    );
}

#[test]
fn only_one_sub_map_is_in_it() {
    let mut map = world();
    let scene = Scene::wall(4);
    let pose = at(0.0, 0.0, 0.0);
    let other = add_under(&mut map, scene.whole(5, &pose), &pose, &[], &[], map::Parent::NewSubmap);
    let graph = EssentialGraph::new(&map, KeyframeId(2), 10);
    assert_eq!(graph.index(other), None);
    assert_eq!(graph.nodes, [0, 1, 2, 3, 4].map(KeyframeId));
    assert_eq!(graph.cam_from_world.len(), 5);
}

#[test]
fn the_motion_of_an_edge_leads_from_a_to_b() {
    let map = world();
    let graph = EssentialGraph::new(&map, KeyframeId(0), 100);
    let edge = graph.edges[2];
    assert_eq!((edge.a, edge.b), (1, 2));
    let expected = map.keyframe(KeyframeId(2)).unwrap().cam_from_world
        * map.keyframe(KeyframeId(1)).unwrap().cam_from_world.inverse();
    assert!(gap(&graph.b_from_a(&edge), &expected) < 1e-12);
    // The camera moves by 1 m along x, so points move the other way.
    assert!((graph.b_from_a(&edge).translation.x + 1.0).abs() < 1e-12);
}

#[test]
fn the_way_up_ends_at_the_root() {
    let map = world();
    let graph = EssentialGraph::new(&map, KeyframeId(0), 100);
    assert_eq!(graph.ancestors(&map, 3), vec![3, 2, 1, 0]);
    assert_eq!(graph.ancestors(&map, 4), vec![4, 0]);
    let mut map = map;
    let pose = at(9.0, 0.0, 0.0);
    add(&mut map, Scene::wall(4).whole(5, &pose), &pose, &[], &[]);
    let graph = EssentialGraph::new(&map, KeyframeId(0), 100);
    assert_eq!(graph.ancestors(&map, 5), vec![5, 4, 0], "under the newest, since it shares nothing");
}
