//! Real odometry of four drives of KITTI with loop candidates of which most are false, offered one after the other: none of the false
//! ones may pass, most of the true ones must, and the path must come nearer to the true one.

#![allow(clippy::print_stdout, reason = "a skipped test says so, and a passed one its figures")]

mod g2o;
mod kitti;

use kitti::{Answer, DRIFT, Drive, NEIGHBORS};

/// Offers the candidates of a drive and checks what is accepted.
fn check(name: &str, n_candidates: usize, n_true: usize, most_left: f64) {
    let Some(drive) = Drive::load(name) else {
        println!("skipped: no kitti_loops/kitti_{name}_*; set DSSLAM_GRAPHS");
        return;
    };
    assert_eq!((drive.candidates.len(), drive.are_true.len()), (n_candidates, n_true));
    let Answer { accepted, nodes, taken_back, .. } = drive.offer_all(&DRIFT, &[]);
    let wrong: Vec<_> = accepted.iter().filter(|ends| !drive.are_true.contains(ends)).collect();
    let near = |a: u32, b: u32| a.abs_diff(b) <= NEIGHBORS;
    let served = drive.are_true.iter().filter(|t| accepted.iter().any(|a| near(t.0, a.0) && near(t.1, a.1)));
    let (served, before, after) = (served.count(), drive.ate(&drive.nodes), drive.ate(&nodes));
    println!(
        "kitti_{name}: {} of {n_candidates} accepted, {} false; {served} of {n_true} true ones accepted or beside one; ATE {before:.2} -> {after:.2} m",
        accepted.len(),
        wrong.len()
    );
    assert!(wrong.is_empty(), "false loops accepted: {wrong:?}");
    assert!(taken_back.is_empty(), "loops taken back: {taken_back:?}");
    assert!(served as f64 >= 0.8 * n_true as f64, "{served} of {n_true}");
    assert!(after <= most_left * before, "{before} -> {after}");
}

#[test]
fn kitti_00() {
    check("00", 433, 117, 0.25);
}

#[test]
fn kitti_02() {
    check("02", 577, 34, 0.5);
}

#[test]
fn kitti_05() {
    check("05", 306, 62, 0.5);
}

#[test]
fn kitti_08_has_no_true_loop() {
    check("08", 409, 0, 1.0);
}
