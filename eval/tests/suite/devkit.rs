//! KITTI drift agrees with `devkit_reference.py` (numpy, written from the definition) to 1e-9, and reproduces what public
//! tools print for published trajectories.

use std::path::Path;
use std::process::Command;

use super::support::{fixture, pairs, published};
use dsslam_eval::{Alignment, Drift, KITTI_LENGTHS_M, apply_alignment, ate, kitti_drift, kitti_drift_sparse};
use geometry::{SE3, SO3};

const TOLERANCE: f64 = 1e-9;

/// t_rel, r_rel, RMS, standard deviation, segments, ATE: a line of `devkit_reference.py`.
type Line = [f64; 6];

fn line(drift: &Drift, ate_m: f64) -> Line {
    let value = |v: Option<f64>| v.unwrap_or(f64::NAN);
    [
        value(drift.t_rel_percent),
        value(drift.r_rel_deg_per_100m),
        value(drift.rms),
        value(drift.std),
        drift.n_segments as f64,
        ate_m,
    ]
}

fn plain(gt: &Path, est: &Path, lengths: &[f64]) -> Line {
    let pairs = pairs(gt, est);
    let drift = if pairs.est.len() == pairs.n_gt {
        kitti_drift(&pairs.est, &pairs.gt, lengths).unwrap()
    } else {
        let truth = io::read_trajectory(gt, None).unwrap().trajectory;
        let all: Vec<SE3> = truth.poses.iter().map(|p| p.world_from_cam).collect();
        let mut sparse = vec![None; all.len()];
        for (&i, pose) in pairs.gt_indices.iter().zip(&pairs.est) {
            sparse[i] = Some(*pose);
        }
        kitti_drift_sparse(&sparse, &all, lengths).unwrap()
    };
    line(&drift, ate(&pairs.est, &pairs.gt, Alignment::None).unwrap().error_m.rmse)
}

/// As monocular tables do: both trajectories seen from their first common frame, then Sim3, then the drift.
fn after_sim3(gt: &Path, est: &Path) -> Line {
    let pairs = pairs(gt, est);
    let truth = io::read_trajectory(gt, None).unwrap().trajectory;
    let all: Vec<SE3> = truth.poses.iter().map(|p| p.world_from_cam).collect();
    let all = seen_from(&pairs.gt[0], &all);
    let est = seen_from(&pairs.est[0], &pairs.est);
    let matched: Vec<SE3> = pairs.gt_indices.iter().map(|&i| all[i]).collect();
    let report = ate(&est, &matched, Alignment::Sim3).unwrap();
    let mut sparse = vec![None; all.len()];
    for (&i, pose) in pairs.gt_indices.iter().zip(apply_alignment(&report.gt_from_est, &est)) {
        sparse[i] = Some(pose);
    }
    line(&kitti_drift_sparse(&sparse, &all, &KITTI_LENGTHS_M).unwrap(), report.error_m.rmse)
}

/// With the general inverse: the files' matrices are rounded.
fn seen_from(first: &SE3, poses: &[SE3]) -> Vec<SE3> {
    let inverse = first.matrix().try_inverse().unwrap();
    poses
        .iter()
        .map(|p| {
            let m = inverse * p.matrix();
            let rotation = SO3::from_matrix_unchecked(m.fixed_view::<3, 3>(0, 0).into_owned());
            SE3::new(rotation, m.fixed_view::<3, 1>(0, 3).into_owned())
        })
        .collect()
}

fn check(found: Line, expected: Line) {
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() < TOLERANCE, "found {found:?}, expected {expected:?}");
    }
}

#[test]
fn fixtures_agree_with_recorded_values() {
    let (gt, est) = (fixture("kitti_gt.txt"), fixture("kitti_est.txt"));
    check(
        plain(&gt, &est, &KITTI_LENGTHS_M),
        [
            0.7467501390881228,
            0.4432947240583244,
            0.7820939273609727,
            0.23245459984001138,
            36.0,
            1.6295734152481112,
        ],
    );
    check(
        plain(&gt, &est, &[10.0, 25.0, 50.0]),
        [
            0.6888431781732098,
            1.023280222865384,
            0.7225965588066355,
            0.21826786910450832,
            83.0,
            1.6295734152481112,
        ],
    );
    check(
        plain(&gt, &fixture("kitti_est_numbered.txt"), &KITTI_LENGTHS_M),
        [
            0.7388383511395787,
            0.43763847971766184,
            0.7775511274474708,
            0.2422883544047907,
            31.0,
            1.6395113940058437,
        ],
    );
    check(
        after_sim3(&gt, &est),
        [
            0.5588271804949575,
            0.4432947240582564,
            0.6113312249678619,
            0.24786699853099223,
            36.0,
            0.1793063085749401,
        ],
    );
}

/// The digits that the DF-VO toolbox printed for these files; its ATE by evo.
#[test]
fn published_orb_slam2_on_kitti_00() {
    let (Some(gt), Some(est)) = (published("KITTI_00_gt.txt"), published("KITTI_00_ORB.txt")) else { return };
    let found = plain(&gt, &est, &KITTI_LENGTHS_M);
    assert!((found[0] - 0.6997286638583283).abs() < 1e-13, "{found:?}");
    assert!((found[1] - 0.2533302348330208).abs() < 1e-13, "{found:?}");
    check(
        found,
        [
            0.699728663858329,
            0.2533302348329914,
            0.9297731709328105,
            0.6122564383993776,
            3283.0,
            7.790288882656827,
        ],
    );
    let sim3 = after_sim3(&gt, &est);
    assert!((sim3[0] - 0.627707845528897).abs() < 1e-13, "{sim3:?}");
    assert!((sim3[1] - 0.2533302348330).abs() < 1e-12, "{sim3:?}");
    assert_eq!(format!("{:.2} {:.2}", found[0], found[1]), "0.70 0.25");
}

#[test]
fn published_sptam_on_kitti_00() {
    let (Some(gt), Some(est)) = (published("KITTI_00_gt.txt"), published("KITTI_00_SPTAM.txt")) else {
        return;
    };
    let found = plain(&gt, &est, &KITTI_LENGTHS_M);
    assert!((found[0] - 1.4869606574252654).abs() < 1e-13, "{found:?}");
    assert!((found[1] - 0.5577059247660341).abs() < 1e-13, "{found:?}");
}

#[test]
fn published_monocular_runs_with_missing_frames() {
    for (sequence, printed, recorded) in [
        (
            "09",
            "2.88 0.25 8.39",
            [
                2.88411251140712,
                0.24905618674613003,
                3.567598303284203,
                2.099917301976732,
                950.0,
                8.386619228786047,
            ],
        ),
        (
            "10",
            "3.30 0.30 6.63",
            [
                3.297839536933305,
                0.3045899519453065,
                3.974517763058737,
                2.218343038736109,
                456.0,
                6.630158107185034,
            ],
        ),
    ] {
        let gt = published(&format!("KITTI_{sequence}_gt.txt"));
        let est = published(&format!("KITTI_{sequence}_mono_example0.txt"));
        let (Some(gt), Some(est)) = (gt, est) else { return };
        let found = after_sim3(&gt, &est);
        assert_eq!(format!("{:.2} {:.2} {:.2}", found[0], found[1], found[5]), printed);
        check(found, recorded);
    }
}

/// The script itself, where Python with numpy is at hand (`DSSLAM_PYTHON`, else `python3`).
#[test]
fn the_script_agrees() {
    let python = std::env::var("DSSLAM_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/devkit_reference.py");
    let has_numpy =
        Command::new(&python).args(["-c", "import numpy"]).output().is_ok_and(|o| o.status.success());
    if !has_numpy {
        eprintln!("SKIPPED: {python} with numpy is absent (set DSSLAM_PYTHON)");
        return;
    }
    let (gt, est) = (fixture("kitti_gt.txt"), fixture("kitti_est.txt"));
    let run = |options: &[&str]| -> Line {
        let output = Command::new(&python).arg(&script).arg(&gt).arg(&est).args(options).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let values: Vec<f64> =
            String::from_utf8_lossy(&output.stdout).split_whitespace().map(|v| v.parse().unwrap()).collect();
        values.try_into().unwrap()
    };
    check(plain(&gt, &est, &KITTI_LENGTHS_M), run(&[]));
    check(plain(&gt, &est, &[20.0, 60.0]), run(&["--lengths", "20,60"]));
    check(after_sim3(&gt, &est), run(&["--sim3"]));
}
