//! Trajectories survive writing and reading; broken files get their exact message.

use std::path::Path;

use dsslam_io::TrajectoryFormat::{self, Euroc, Kitti, Tum};
use dsslam_io::{StampedPose, Stamps, Trajectory, read_trajectory, write_euroc, write_kitti, write_tum};
use geometry::{SE3, Vec6};
use proptest::prelude::*;

use super::support::Folder;

/// A curve of `n` poses with positions up to `scale` meters.
fn curve(n: u32, scale: f64) -> Trajectory {
    let poses = (0..n).map(|i| {
        let s = f64::from(i);
        let twist =
            Vec6::new(scale * s.sin(), -scale * 1e-7, scale * (0.3 * s).cos(), 0.9 * s.cos(), 0.4 * s, -0.01);
        StampedPose { timestamp_s: 1_305_031_453.359_684 + s / 30.0, world_from_cam: SE3::exp(&twist) }
    });
    Trajectory { poses: poses.collect() }
}

fn largest_difference(a: &Trajectory, b: &Trajectory) -> f64 {
    assert_eq!(a.poses.len(), b.poses.len());
    let rows =
        a.poses.iter().zip(&b.poses).map(|(a, b)| (a.world_from_cam.rows_3x4(), b.world_from_cam.rows_3x4()));
    rows.flat_map(|(a, b)| std::iter::zip(a, b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The poses of a file that can be read.
fn read(path: &Path) -> Trajectory {
    read_trajectory(path, None).unwrap().trajectory
}

proptest! {
    #[test]
    fn round_trips(n in 1_u32..30, scale in 0.001..1000.0) {
        let folder = Folder::new();
        let curve = curve(n, scale);
        write_kitti(&folder.file("k.txt"), &curve).unwrap();
        write_tum(&folder.file("t.txt"), &curve).unwrap();
        write_euroc(&folder.file("e.csv"), &curve).unwrap();
        let kitti = read(&folder.file("k.txt"));
        let euroc = read(&folder.file("e.csv"));
        let tum = read(&folder.file("t.txt"));
        prop_assert!(largest_difference(&kitti, &curve) < 1e-9);
        prop_assert!(largest_difference(&tum, &curve) < 1e-9);
        prop_assert!(largest_difference(&euroc, &curve) < 1e-9);
        for (read, written) in tum.poses.iter().chain(&euroc.poses).zip(curve.poses.iter().cycle()) {
            prop_assert!((read.timestamp_s - written.timestamp_s).abs() < 1e-6);
        }
    }
}

#[test]
fn kitti_text() {
    let folder = Folder::new();
    let pose = StampedPose { timestamp_s: 5.0, world_from_cam: SE3::identity() };
    write_kitti(&folder.file("k.txt"), &Trajectory { poses: vec![pose] }).unwrap();
    let text = std::fs::read_to_string(folder.file("k.txt")).unwrap();
    let (one, zero) = ("1.000000000000e+00", "0.000000000000e+00");
    let row = [one, zero, zero, zero, zero, one, zero, zero, zero, zero, one, zero].join(" ");
    assert_eq!(text, row + "\n");
}

#[test]
fn euroc_text() {
    let folder = Folder::new();
    let pose = StampedPose { timestamp_s: 1.25, world_from_cam: SE3::identity() };
    write_euroc(&folder.file("e.csv"), &Trajectory { poses: vec![pose] }).unwrap();
    let text = std::fs::read_to_string(folder.file("e.csv")).unwrap();
    let zero = "0.000000000000";
    let row = format!("1250000000,{zero},{zero},{zero},1.000000000000,{zero},{zero},{zero}");
    assert!(
        text.starts_with("#timestamp [ns], p_RS_R_x [m]") && text.ends_with(&format!("\n{row}\n")),
        "{text}"
    );
}

#[test]
fn kitti_rows_have_no_times() {
    let folder = Folder::new();
    write_kitti(&folder.file("k.txt"), &curve(4, 1.0)).unwrap();
    let file = read_trajectory(&folder.file("k.txt"), None).unwrap();
    assert_eq!((file.format, file.stamps), (Kitti, Stamps::Rows));
    assert_eq!(file.trajectory.poses[3].timestamp_s, 3.0);
    let stamped = file.clone().at_frames(&[0.5, 1.5, 2.5], 0);
    assert_eq!((stamped.poses.len(), stamped.poses[2].timestamp_s), (3, 2.5));
    assert_eq!(stamped.poses[2].world_from_cam, file.trajectory.poses[2].world_from_cam);
}

/// KITTI rows at x = 1, 2, ... with these stamps in front.
fn stamped_rows(stamps: &[&str]) -> String {
    let row = |(i, stamp): (usize, &&str)| format!("{stamp} 1 0 0 {} 0 1 0 0 0 0 1 0\n", i + 1);
    stamps.iter().enumerate().map(row).collect()
}

#[test]
fn kitti_rows_may_have_frame_numbers_or_times() {
    let folder = Folder::new();
    let file = |stamps: &[&str]| read_trajectory(&folder.write("k.txt", stamped_rows(stamps)), None).unwrap();
    let found = |t: &Trajectory| -> Vec<(f64, f64)> {
        t.poses.iter().map(|p| (p.timestamp_s, p.world_from_cam.translation.x)).collect()
    };
    let numbered = file(&["0", "2", "3.0", "9"]);
    assert_eq!((numbered.format, numbered.stamps), (Kitti, Stamps::FrameNumbers));
    assert_eq!(found(&numbered.trajectory), [(0.0, 1.0), (2.0, 2.0), (3.0, 3.0), (9.0, 4.0)]);
    let times_s = [10.0, 10.1, 10.2, 10.3];
    assert_eq!(found(&numbered.at_frames(&times_s, 0)), [(10.0, 1.0), (10.2, 2.0), (10.3, 3.0)]);
    let timed = file(&["0", "0.5", "1e1"]);
    assert_eq!((timed.format, timed.stamps), (Kitti, Stamps::Times));
    assert_eq!(found(&timed.at_frames(&times_s, 0)), [(0.0, 1.0), (0.5, 2.0), (10.0, 3.0)]);
}

#[test]
fn rows_of_whole_matrices_and_rows_without_times() {
    let folder = Folder::new();
    let file = |text: &str| read_trajectory(&folder.write("t.txt", text), None).unwrap();
    let numbered = file("7 1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1\n9 1 0 0 6 0 1 0 0 0 0 1 0 0 0 0 1\n");
    assert_eq!((numbered.stamps, numbered.trajectory.poses[1].timestamp_s), (Stamps::FrameNumbers, 9.0));
    let plain = file("1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1\n");
    assert_eq!((plain.stamps, plain.trajectory.poses[0].world_from_cam.translation.x), (Stamps::Rows, 5.0));
    let untimed = file("1 2 3 0 0 0 1\n4 2 3 0 0 0 1\n");
    assert_eq!(
        (untimed.format, untimed.stamps, untimed.trajectory.poses[1].timestamp_s),
        (Tum, Stamps::Rows, 1.0)
    );
    // VSLAM-LAB's columns: w last.
    let lab = file("ts (ns),tx,ty,tz,qx,qy,qz,qw\n1403636579763555584,1,2,3,0,0,0,1\n");
    assert_eq!(lab.trajectory.poses[0].world_from_cam.rotation, geometry::SO3::identity());
    assert!(
        refused(Kitti, "1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 2\n")
            .contains("found 0 0 0 2 as last row of the matrix")
    );
}

#[test]
fn kitti_matrices_stay_as_they_are_written() {
    let folder = Folder::new();
    let path = folder.write("k.txt", "1.000001 0 0 0 0 1 0 0 0 0 1 0\n");
    assert_eq!(read(&path).poses[0].world_from_cam.rotation.matrix()[(0, 0)], 1.000001);
}

#[test]
fn tum_text() {
    let folder = Folder::new();
    let pose = StampedPose { timestamp_s: 1.25, world_from_cam: SE3::identity() };
    write_tum(&folder.file("t.txt"), &Trajectory { poses: vec![pose] }).unwrap();
    let zero = "0.000000000000";
    assert_eq!(
        std::fs::read_to_string(folder.file("t.txt")).unwrap(),
        format!(
            "# timestamp tx ty tz qx qy qz qw\n1.250000000 {zero} {zero} {zero} {zero} {zero} {zero} 1.000000000000\n"
        )
    );
}

#[test]
fn euroc_ground_truth() {
    let folder = Folder::new();
    let path = folder.write(
        "data.csv",
        "#timestamp [ns],p_RS_R_x [m],...\n1403636589663560000,4.5,-1.5,0.5,0.6,0,0,0.8,9,9,9\n\
         1403636589668560000, 4.75, -1.5, 0.5, 0.6, 0, 0, 0.8\n",
    );
    let read = read(&path);
    assert_eq!(read.poses.len(), 2);
    assert!((read.poses[0].timestamp_s - 1_403_636_589.663_56).abs() < 1e-6);
    assert_eq!(read.poses[1].world_from_cam.translation.x, 4.75);
    // w = 0.6, z = 0.8: a turn about z whose cosine is 1 - 2 * 0.64.
    assert!((read.poses[0].world_from_cam.rotation.matrix()[(0, 0)] + 0.28).abs() < 1e-12);
}

#[test]
fn nearest_in_time() {
    let poses =
        [1.0, 2.0, 4.0].map(|timestamp_s| StampedPose { timestamp_s, world_from_cam: SE3::identity() });
    let trajectory = Trajectory { poses: poses.to_vec() };
    let found = |time, tolerance| trajectory.find_nearest(time, tolerance).map(|pose| pose.timestamp_s);
    assert_eq!(found(1.4, 0.5), Some(1.0));
    assert_eq!(found(1.6, 0.5), Some(2.0));
    assert_eq!(found(3.0, 1.0), Some(2.0), "the earlier of two");
    assert_eq!(found(3.0, 0.9), None);
    assert_eq!(found(0.0, 1.0), Some(1.0));
    assert_eq!(found(9.0, 5.0), Some(4.0));
    assert_eq!(Trajectory::default().find_nearest(0.0, 1.0), None);
}

/// The message of reading a file with this content.
fn refused(format: impl Into<Option<TrajectoryFormat>>, content: &str) -> String {
    let folder = Folder::new();
    folder.hide(read_trajectory(&folder.write("file", content), format.into()).unwrap_err())
}

#[test]
fn broken_kitti_files() {
    let row = "1 0 0 0 0 1 0 0 0 0 1 0";
    assert_eq!(
        refused(Kitti, "\n"),
        "DIR/file: found no data, expected 12 numbers (the 3x4 pose, row by row)"
    );
    assert_eq!(
        refused(Kitti, &format!("{row}\n{row} 7\n")),
        "DIR/file:2: found 13 numbers, expected 12 numbers (the 3x4 pose, row by row)"
    );
    assert_eq!(
        refused(Kitti, &format!("{row}\n{row}\n{}\n", row.replacen('1', "inf", 1))),
        "DIR/file:3: found `inf`, expected a finite number"
    );
    let stamped = "13 numbers (frame number or time, and the 3x4 pose, row by row)";
    assert_eq!(
        refused(Kitti, &format!("5 {row}\n{row}\n")),
        format!("DIR/file:2: found 12 numbers, expected {stamped}")
    );
    assert_eq!(
        refused(Kitti, &format!("5 {row}\n5 {row}\n")),
        "DIR/file:2: found time 5 after 5 of the previous entry, expected strictly increasing times"
    );
    assert_eq!(
        refused(Kitti, "2 0 0 0 0 1 0 0 0 0 1 0\n"),
        "DIR/file:1: found a 3x3 matrix that is not a rotation (deviation 3.000), expected a pose whose first three \
         columns are a rotation"
    );
    assert_eq!(
        refused(Kitti, "-1 0 0 0 0 1 0 0 0 0 1 0\n"),
        "DIR/file:1: found a 3x3 matrix that is not a rotation (a mirror image), expected a pose whose first three \
         columns are a rotation"
    );
}

#[test]
fn broken_tum_files() {
    assert_eq!(
        refused(Tum, "# only a comment\n"),
        "DIR/file: found no data, expected 8 numbers (timestamp tx ty tz qx qy qz qw)"
    );
    assert_eq!(
        refused(Tum, "1 0 0 0 0 1\n"),
        "DIR/file:1: found 6 numbers, expected 8 numbers (timestamp tx ty tz qx qy qz qw)"
    );
    assert_eq!(
        refused(Tum, "1 0 0 0 0 0 0 1\n2 0 nan 0 0 0 0 1\n"),
        "DIR/file:2: found `nan`, expected a finite number"
    );
    assert_eq!(
        refused(Tum, "1 0 0 0 0 0 0 1\n\n0.5 0 0 0 0 0 0 1\n"),
        "DIR/file:3: found time 0.5 after 1 of the previous entry, expected strictly increasing times"
    );
    assert_eq!(
        refused(Tum, "1 0 0 0 0 0 0 0\n"),
        "DIR/file:1: found a quaternion of length 0.000000, expected a unit quaternion"
    );
}

#[test]
fn of_rows_with_one_time_the_first_is_kept() {
    let folder = Folder::new();
    let row = |time: f64, x: f64| format!("{time:.4} {x} 0 0 0 0 0 1\n");
    let text = row(1.0, 1.0) + &row(1.5, 2.0) + &row(1.5, 3.0) + &row(1.5, 4.0) + &row(2.0, 5.0);
    let file = read_trajectory(&folder.write("t.txt", &text), None).unwrap();
    assert_eq!((file.format, file.stamps, file.n_repeated_times), (Tum, Stamps::Times, 2));
    let found: Vec<_> = file
        .trajectory
        .poses
        .iter()
        .map(|pose| (pose.timestamp_s, pose.world_from_cam.translation.x))
        .collect();
    assert_eq!(found, [(1.0, 1.0), (1.5, 2.0), (2.0, 5.0)]);
    // What is left out is checked all the same, and a time that goes back stays an error.
    assert_eq!(
        refused(Tum, &(row(1.0, 1.0) + "1.0 0 0 0 0 0 0 9\n")),
        "DIR/file:2: found a quaternion of length 9.000000, expected a unit quaternion"
    );
    assert_eq!(
        refused(Tum, &(row(1.0, 1.0) + &row(1.0, 2.0) + &row(0.5, 3.0))),
        "DIR/file:3: found time 0.5 after 1 of the previous entry, expected strictly increasing times"
    );
}

#[test]
fn broken_euroc_files() {
    let expected = "at least 8 comma-separated numbers (ns, px, py, pz, qw, qx, qy, qz)";
    assert_eq!(refused(Euroc, "#x\n"), format!("DIR/file: found no data, expected {expected}"));
    assert_eq!(refused(Euroc, "1,2,3\n"), format!("DIR/file:1: found 3 fields, expected {expected}"));
    assert_eq!(refused(Euroc, "1.5,0,0,0,1,0,0,0\n"), "DIR/file:1: found `1.5`, expected whole nanoseconds");
    assert_eq!(refused(Euroc, "1,0,x,0,1,0,0,0\n"), "DIR/file:1: found `x`, expected a number");
}

#[test]
fn unknown_format() {
    let expected = "a trajectory (KITTI: 12 numbers a line, 13 with a frame number or time in front; TUM: 8; EuRoC: at \
                    least 8 with commas)";
    assert_eq!(refused(None, "1 2 3\n"), format!("DIR/file:1: found 3 fields, expected {expected}"));
    assert_eq!(refused(None, ""), format!("DIR/file: found no data, expected {expected}"));
    let folder = Folder::new();
    assert_eq!(
        folder.hide(read_trajectory(&folder.file("none"), None).unwrap_err()),
        format!("DIR/none: no such file, expected {expected}")
    );
}

#[test]
fn folders_that_cannot_be_written() {
    let folder = Folder::new();
    folder.write("file", "x");
    let reason = "cannot be written: Not a directory (os error 20)";
    let error = write_tum(&folder.file("file/t.txt"), &curve(1, 1.0)).unwrap_err();
    assert_eq!(folder.hide(error), format!("DIR/file/t.txt: {reason}"));
    let error = dsslam_io::create_output_folder(&folder.file("file/results")).unwrap_err();
    assert_eq!(folder.hide(error), format!("DIR/file/results: {reason}"));
    let error = write_kitti(&folder.file("none/k.txt"), &curve(1, 1.0)).unwrap_err();
    assert_eq!(
        folder.hide(error),
        "DIR/none/k.txt: cannot be written: No such file or directory (os error 2)"
    );
}

#[test]
fn writing_replaces_the_whole_file_and_leaves_nothing_else() {
    let folder = Folder::new();
    dsslam_io::create_output_folder(&folder.file("a/b")).unwrap();
    assert!(folder.file("a/b").is_dir());
    write_tum(&folder.file("t.txt"), &curve(20, 1.0)).unwrap();
    write_tum(&folder.file("t.txt"), &curve(2, 1.0)).unwrap();
    assert_eq!(read(&folder.file("t.txt")).poses.len(), 2);
    assert_eq!(folder.names(), ["a", "t.txt"]);
    // A folder in the way: nothing is renamed over it and no temporary file stays.
    assert!(write_tum(&folder.file("a"), &curve(2, 1.0)).is_err());
    assert_eq!(folder.names(), ["a", "t.txt"]);
}
