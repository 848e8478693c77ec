//! What `--help` says below the options: examples that work as they stand, and the exit codes.

use crate::exit::EXIT_CODES;

/// Below `dsslam --help`.
pub(crate) fn top() -> String {
    with_codes(
        "\
Examples:
  dsslam demo                             render a town and drive through it; needs no data
  dsslam run path/to/sequence             run on a KITTI or TUM RGB-D folder
  dsslam help run                         all options of a run",
    )
}

/// Below `dsslam run --help`.
pub(crate) fn run() -> String {
    with_codes(
        "\
Examples:
  dsslam run kitti/sequences/06 --config configs/kitti.yaml
  dsslam run kitti/sequences/06 --set features.keep=500 --max-frames 200
  dsslam run rgbd_dataset_freiburg1_desk --config configs/tum-rgbd.yaml
  dsslam run morning --save-map campus.dsmap
  dsslam run evening --load-map campus.dsmap --localize
  dsslam run kitti/sequences/06 --schedule live --realtime --journal run.json
  dsslam run kitti/sequences/06 --rerun

Layouts:
  KITTI odometry   calib.txt, times.txt, image_0 and image_1 (or image_2 and image_3),
                   poses.txt if there
  TUM RGB-D        rgb.txt, depth.txt, groundtruth.txt if there; the camera comes from the
                   configuration

Results: trajectory.kitti.txt, trajectory.tum.txt, ground_truth.tum.txt, trajectory.png, frames.csv,
loops.csv, config.yaml, timings.csv, summary.json (README.md explains them); results/latest points to the newest run.",
    )
}

/// Below `dsslam demo --help`.
pub(crate) fn demo() -> String {
    with_codes(
        "\
Examples:
  dsslam demo
  dsslam demo --frames 60 --out /tmp/demo",
    )
}

/// Below `dsslam view --help`.
pub(crate) fn view() -> String {
    with_codes(
        "\
Examples:
  dsslam view                                             the newest run
  dsslam view results/latest --save run.rrd
  dsslam view results/latest --map campus.dsmap",
    )
}

/// Below `dsslam synth --help`.
pub(crate) fn synth() -> String {
    with_codes(
        "\
Examples:
  dsslam synth /tmp/town --preset town --frames 60
  dsslam run /tmp/town",
    )
}

/// Below `dsslam config --help`.
pub(crate) fn config() -> String {
    with_codes(
        "\
Examples:
  dsslam config default > my.yaml
  dsslam config check my.yaml",
    )
}

/// Below `dsslam vocab --help`.
pub(crate) fn vocab() -> String {
    with_codes(
        "\
Examples:
  dsslam vocab info                                       the vocabulary that is part of the program
  dsslam vocab train images/ more/*.png -o my.dbow
  dsslam vocab convert ORBvoc.txt orbvoc.dbow",
    )
}

fn with_codes(examples: &str) -> String {
    format!("{examples}\n\n{EXIT_CODES}")
}
