//! Reader of pose graphs in g2o's format, for tests and benches.

#![allow(dead_code, missing_docs, unreachable_pub)]

use std::path::PathBuf;

use dsslam_optim::{PoseGraphEdge, PoseGraphProblem};
use geometry::{Mat6, Quaternion, SE3, SO3, Vec3};

/// `$DSSLAM_GRAPHS`, else `$DSSLAM_DATA/graphs`, else beside the repository.
pub fn find(name: &str) -> Option<String> {
    let from_data = std::env::var_os("DSSLAM_DATA").map(|d| PathBuf::from(d).join("graphs"));
    let beside = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/graphs");
    let folders = [std::env::var_os("DSSLAM_GRAPHS").map(PathBuf::from), from_data, Some(beside)];
    folders.into_iter().flatten().find_map(|folder| std::fs::read_to_string(folder.join(name)).ok())
}

/// Nodes in the order of the file, the first one fixed.
///
/// The format holds world_from_node, and per edge (i, j) the motion i_from_j with the information of `log(measured^-1 *
/// predicted)`, translation first: an edge from j to i here.
pub fn parse(text: &str) -> PoseGraphProblem<SE3> {
    let (mut ids, mut poses, mut edges) = (Vec::new(), Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        let tag = words.next().unwrap_or_default();
        let numbers: Vec<f64> = words.map(|w| w.parse().expect("a number")).collect();
        match tag {
            "VERTEX_SE3:QUAT" => {
                ids.push(numbers[0] as u32);
                poses.push(pose(&numbers[1..8]).inverse());
            }
            "EDGE_SE3:QUAT" => edges.push((numbers[0] as u32, numbers[1] as u32, numbers[2..].to_vec())),
            _ => panic!("unknown line {line}"),
        }
    }
    let node = |id: u32| ids.iter().position(|&i| i == id).expect("a node of the file") as u32;
    let edges = edges.iter().map(|(i, j, numbers)| PoseGraphEdge {
        a: node(*j),
        b: node(*i),
        b_from_a: pose(&numbers[..7]),
        information: information(&numbers[7..]),
    });
    let mut fixed = vec![false; poses.len()];
    fixed[0] = true;
    PoseGraphProblem { edges: edges.collect(), fixed, poses }
}

fn pose(v: &[f64]) -> SE3 {
    let q = Quaternion::new_normalize(nalgebra::Quaternion::new(v[6], v[3], v[4], v[5]));
    SE3::new(SO3::from_quaternion(&q), Vec3::new(v[0], v[1], v[2]))
}

/// Upper triangle, row by row.
fn information(values: &[f64]) -> Mat6 {
    let mut matrix = Mat6::zeros();
    let mut values = values.iter();
    for r in 0..6 {
        for c in r..6 {
            matrix[(r, c)] = *values.next().expect("21 numbers");
            matrix[(c, r)] = matrix[(r, c)];
        }
    }
    matrix
}

/// Motions `b_from_a` between consecutive nodes of a graph in the plane (x ahead, y left), and the ends of all other edges.
///
/// The format holds per edge (i, j) the motion i_from_j as x, y and angle: its inverse here.
pub fn parse_plane(text: &str) -> (Vec<SE3>, Vec<(u32, u32)>) {
    let (mut motions, mut others) = (Vec::new(), Vec::new());
    for line in text.lines().filter(|line| line.starts_with("EDGE_SE2")) {
        let numbers: Vec<f64> =
            line.split_whitespace().skip(1).map(|w| w.parse().expect("a number")).collect();
        let (i, j) = (numbers[0] as u32, numbers[1] as u32);
        if j == i + 1 {
            assert_eq!(motions.len(), i as usize, "the path is in order");
            let i_from_j =
                SE3::new(SO3::exp(&Vec3::new(0.0, 0.0, numbers[4])), Vec3::new(numbers[2], numbers[3], 0.0));
            motions.push(i_from_j.inverse());
        } else {
            others.push((i, j));
        }
    }
    (motions, others)
}
