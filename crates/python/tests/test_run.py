"""Runs over folders, and the program."""

import _thread
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import SETTINGS, png, real

import dsslam

PROGRAM = [sys.executable, "-c", "import sys, dsslam; sys.exit(dsslam.main())"]


def program(*arguments):
    return subprocess.run(PROGRAM + [str(a) for a in arguments], capture_output=True, text=True)


@pytest.fixture(scope="session")
def town(tmp_path_factory):
    """A folder of 40 rendered frames in KITTI's layout."""
    folder = tmp_path_factory.mktemp("data") / "town"
    made = program("synth", folder, "--frames", 40)
    assert made.returncode == 0, made.stderr
    return folder


def trajectory_of_program(folder, tmp_path, *arguments):
    out = tmp_path / "of_program"
    ran = program("run", folder, "--quiet", "--out", out, *arguments)
    assert ran.returncode == 0, ran.stderr
    return (out / "trajectory.kitti.txt").read_bytes()


def trajectory_of(done, tmp_path):
    file = tmp_path / "of_module.txt"
    done.save_trajectory(file, "kitti")
    return file.read_bytes()


def test_a_run_has_the_bits_of_the_program(town, tmp_path):
    done = dsslam.run(town)
    assert done.n_tracked == 40 and done.evaluation["ate_m"]["rmse"] < 0.05
    assert trajectory_of(done, tmp_path) == trajectory_of_program(town, tmp_path)


def test_a_run_says_which_configuration_was_chosen_as_the_program_does(town, tmp_path):
    seen = []
    done = dsslam.run(town, max_frames=2, observer=lambda kind, what: seen.append((kind, what)))
    said = program("run", town, "--max-frames", 2, "--out", tmp_path / "out").stderr
    assert "configuration kitti, built in, as the layout suggests" in done.notices
    assert all(notice in said for notice in done.notices), said
    assert seen[: len(done.notices)] == [("notice", notice) for notice in done.notices]
    assert not any("configuration" in notice for notice in dsslam.run(town, "kitti", max_frames=2).notices)


def pushed(folder, left, right=None, depth=None, config="kitti"):
    """The frames of a folder pushed one by one: lists of files and times in nanoseconds."""
    slam = dsslam.Slam(config, dsslam.Camera.of_dataset(folder, config))
    for i, (t_ns, file) in enumerate(left):
        second = {}
        if right:
            second = {"right": png(right[i])}
        if depth:
            second = {"depth": png(depth[i]).astype(np.uint16)}
        slam.track(t_ns, png(file), **second)
    return slam.finish()


def kitti_frames(folder):
    times = [float(line) for line in (folder / "times.txt").read_text().split()]
    left, right = (sorted((folder / name).glob("*.png")) for name in ("image_0", "image_1"))
    return [(round(t * 1e9), file) for t, file in zip(times, left)], right


def test_pushed_frames_have_the_bits_of_the_program(town, tmp_path):
    left, right = kitti_frames(town)
    done = pushed(town, left, right)
    alike = ["--config", "kitti", "--set", "mapping.refine_calibration=true"]
    assert trajectory_of(done, tmp_path) == trajectory_of_program(town, tmp_path, *alike)


def test_pushed_real_frames_have_the_bits_of_the_program(tmp_path):
    folder = real("kitti06_first51")
    left, right = kitti_frames(folder)
    done = pushed(folder, left, right)
    alike = ["--config", "kitti", "--set", "mapping.refine_calibration=true"]
    assert trajectory_of(done, tmp_path) == trajectory_of_program(folder, tmp_path, *alike)


def test_a_real_rgbd_run_has_the_bits_of_the_program(tmp_path):
    folder = real("tum_fr1_desk")
    done = dsslam.run(folder, "tum-rgbd", max_frames=60)
    alike = ["--config", "tum-rgbd", "--max-frames", 60]
    assert trajectory_of(done, tmp_path) == trajectory_of_program(folder, tmp_path, *alike)


def test_an_observer_sees_each_frame_and_may_end_the_run(town):
    seen = []
    done = dsslam.run(town, settings=SETTINGS, observer=lambda kind, what: seen.append((kind, what)))
    frames = [what for kind, what in seen if kind == "frame"]
    assert [frame.index for frame in frames] == list(range(40)) and done.n_frames == 40

    def stubborn(kind, what):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="^enough$"):
        dsslam.run(town, settings=SETTINGS, observer=stubborn)


def test_ctrl_c_ends_a_run_with_its_results(town):
    def interrupt(kind, what):
        # Slow enough for the signal to arrive.
        time.sleep(0.02)
        if kind == "frame" and what.index == 5:
            _thread.interrupt_main()

    # A shell that runs the tests in the background has them ignore Ctrl-C.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        done = dsslam.run(town, settings=SETTINGS | {"input.scale": 1.0}, observer=interrupt, schedule="sequential")
    finally:
        signal.signal(signal.SIGINT, before)
    assert done.interrupted and 5 < done.n_frames < 40


def test_the_program_has_its_exit_codes(tmp_path):
    assert program("run", tmp_path / "missing").returncode == 2
    assert program("--version").stdout.split() == ["dsslam", dsslam.__version__]
