//! What `--help` says below the options: examples that work as they stand, and the exit codes.

use crate::exit::EXIT_CODES;

/// Below `dsslam --help`.
pub(crate) const TOP: &str = "\
Examples:
  dsslam demo                  # renders a town and drives through it; needs no data
  dsslam run path/to/sequence  # KITTI, TUM RGB-D and EuRoC folders
  dsslam help run              # all options of a run
  dsslam doctor                # what is missing on this machine";

/// Below `dsslam run --help`.
pub(crate) const RUN: &str = "\
Examples:
  dsslam run kitti/sequences/06
  dsslam run kitti/sequences/06 --set features.keep=500 --max-frames 200
  dsslam run rgbd_dataset_freiburg1_desk
  dsslam run MH_01_easy --config euroc
  dsslam run images --calib camera.yaml
  dsslam run kitti/sequences/06 --json --quiet > summary.json
  dsslam run morning --save-map campus.dsmap
  dsslam run evening --load-map campus.dsmap --localize
  dsslam run kitti/sequences/06 --schedule live --realtime --journal run.json
  dsslam run kitti/sequences/06 --rerun

Layouts:
  KITTI odometry   calib.txt, times.txt, image_0 and image_1 (or image_2 and image_3),
                   poses.txt if there
  TUM RGB-D        rgb.txt, depth.txt, groundtruth.txt if there; the camera comes from the
                   configuration, and for fr1 sequences from the built-in one
  EuRoC (ASL)      mav0/cam0 and mav0/cam1, each with data.csv, data/ and sensor.yaml
  Images           in the folder (one camera, left_* and right_*, or left and right side by
                   side in each), in left/ and right/, or in rgb/ and depth/
  Others           KITTI raw, KITTI-360, TUM-VI, TartanAir, 7-Scenes, Replica, OpenLORIS,
                   VSLAM-LAB (docs/inputs.md)
  --calib FILE, or calibration.yaml in the folder, replaces the camera and nothing else;
  `dsslam config calib FILE` prints what is read of it.

Results: trajectory.kitti.txt, trajectory.tum.txt, ground_truth.tum.txt, trajectory.png, frames.csv,
loops.csv, config.yaml, timings.csv, summary.json (docs/results.md explains them); results/latest points to the newest run.";

/// Below `dsslam demo --help`.
pub(crate) const DEMO: &str = "\
Examples:
  dsslam demo
  dsslam demo --frames 60 --out /tmp/demo";

/// Below `dsslam view --help`.
pub(crate) const VIEW: &str = "\
Examples:
  dsslam view  # the newest run
  dsslam view results/latest --save run.rrd
  dsslam view results/latest --map campus.dsmap";

/// Below `dsslam synth --help`.
pub(crate) const SYNTH: &str = "\
Examples:
  dsslam synth /tmp/town --preset town --frames 60
  dsslam run /tmp/town
  dsslam synth /tmp/raw --layout euroc --lens fisheye --frames 100
  dsslam synth /tmp/twice --rounds 2 --relight";

/// Below `dsslam inspect activation --help`.
pub(crate) const ACTIVATION: &str = "\
Examples:
  dsslam inspect activation image_0/000000.png -o heat.png
  dsslam inspect activation image.jpg -o heat.png --keep 1000 --set features.selection=semantic";

/// Below `dsslam eval --help`.
pub(crate) const EVAL: &str = "\
Examples:
  dsslam eval traj results/latest/trajectory.kitti.txt kitti/poses/06.txt
  dsslam help eval run";

/// Below `dsslam config --help`.
pub(crate) const CONFIG: &str = "\
Examples:
  dsslam config default > my.yaml
  dsslam config default --expert
  dsslam config check my.yaml
  dsslam config check my.yaml --sequence kitti/sequences/06 --changed
  dsslam config calib camera.yaml > calibration.yaml";

/// Below `dsslam inspect vocab --help`.
pub(crate) const VOCAB: &str = "\
Examples:
  dsslam inspect vocab info  # the built-in vocabulary
  dsslam inspect vocab train images/ more/*.png -o my.dbow
  dsslam inspect vocab convert ORBvoc.txt orbvoc.dbow";

/// Below `dsslam inspect bag --help`.
pub(crate) const BAG: &str = "\
Examples:
  dsslam inspect bag drive.bag";

/// Below `dsslam export --help`.
pub(crate) const EXPORT: &str = "\
Examples:
  dsslam run kitti/sequences/06 --save-map street.dsmap
  dsslam export street.dsmap --to ply -o street.ply
  dsslam export street.dsmap --to colmap --images kitti/sequences/06 -o colmap
  dsslam export street.dsmap --to tum -o keyframes.txt
  dsslam run MH_01_easy --save-map hall.dsmap
  dsslam export hall.dsmap --to euroc -o body.csv  # poses of the body, as the ground truth's
  dsslam run kitti/sequences/06 --out street --save-map street.dsmap
  dsslam export street --map street.dsmap --to mcap -o street.mcap";

/// Below `dsslam inspect --help`.
pub(crate) const INSPECT: &str = "\
Examples:
  dsslam inspect features kitti/sequences/06 -o features.png
  dsslam help inspect match";

/// Below `dsslam shell --help`.
pub(crate) const SHELL: &str = "\
Examples:
  dsslam shell completions bash > dsslam.bash
  dsslam shell man > dsslam.1";

/// Below `dsslam inspect features --help`.
pub(crate) const FEATURES: &str = "\
Examples:
  dsslam inspect features kitti/sequences/06/image_0/000000.png -o features.png
  dsslam inspect features kitti/sequences/06 --frame 2 --set features.keep=500 -o features.png";

/// Below `dsslam inspect match --help`.
pub(crate) const MATCHING: &str = "\
Examples:
  dsslam inspect match image_0/000000.png image_0/000002.png -o matches.png
  dsslam inspect match kitti/sequences/06 --frames 0 3 --guided -o matches.png";

/// Below `dsslam inspect stereo --help`.
pub(crate) const STEREO: &str = "\
Examples:
  dsslam inspect stereo kitti/sequences/06 -o disparities.png
  dsslam inspect stereo kitti/sequences/06 --frame 2 --config kitti -o disparities.png";

/// Below `dsslam doctor --help`.
pub(crate) const DOCTOR: &str = "\
Examples:
  dsslam doctor
  dsslam doctor --json";

/// Below `dsslam shell completions --help`.
pub(crate) const COMPLETIONS: &str = "\
Examples:
  dsslam shell completions bash > dsslam.bash  # ~/.local/share/bash-completion/completions/dsslam
  dsslam shell completions zsh > _dsslam       # a folder of $fpath
  dsslam shell completions fish > dsslam.fish  # ~/.config/fish/completions";

/// Below `dsslam shell man --help`.
pub(crate) const MAN: &str = "\
Examples:
  dsslam shell man > dsslam.1
  dsslam shell man share/man/man1";

pub(crate) fn with_codes(examples: &str) -> String {
    format!("{examples}\n\n{EXIT_CODES}")
}
