"""Geometry of the motion labels and of the matches."""

import argparse

import cv2
import numpy as np
import pytest

from dsfeat import motion, prepare
from dsfeat.matching import KEPT, Pair, epipolar_errors, packed, to_unit

RIG = motion.Rig(700.0, (600.0, 180.0), 0.54)


def test_projection_inverts_backprojection():
    points, d = np.array([[100.0, 50.0], [900.0, 300.0]]), np.array([5.0, 40.0])
    assert np.allclose(motion.project(RIG, motion.backproject(RIG, points, d)), np.column_stack([points, d]))


def street(n: int = 200):
    """Random points before the camera, the camera's motion, and their places before and after it."""
    rng = np.random.default_rng(2)
    xyz = np.column_stack([rng.uniform(-8, 8, n), rng.uniform(-3, 1.5, n), rng.uniform(6, 25, n)])
    pose = (np.eye(3), np.array([0.0, 0.0, -3.0]))
    return xyz, pose


def test_static_points_are_static_and_movers_move():
    xyz, pose = street()
    before = motion.project(RIG, xyz)
    moved = xyz + np.where(np.arange(len(xyz)) < 40, 1.0, 0.0)[:, None] * np.array([0.0, 0.0, 3.0])
    after = motion.project(RIG, moved @ pose[0].T + pose[1])
    labels = motion.classify(RIG, pose, before[:, :2], before[:, 2], after[:, :2], after[:, 2], 0.4)
    assert (labels[:40] != motion.STATIC).all() and (labels[:40] == motion.MOVING).mean() > 0.5
    assert (labels[40:] != motion.MOVING).all() and (labels[40:] == motion.STATIC).mean() > 0.8


def test_camera_motion_survives_a_large_vehicle():
    xyz, pose = street(300)
    # A bus before us with many points keeps its place in the camera.
    rng = np.random.default_rng(3)
    bus = np.column_stack([rng.uniform(-1.2, 1.2, 400), rng.uniform(-1.5, 1.0, 400), np.full(400, 8.0)])
    every = np.vstack([xyz, bus])
    before = motion.project(RIG, every)
    later = np.vstack([xyz @ pose[0].T + pose[1], bus])
    seen = (before[:, 0] > 0) & (before[:, 0] < 1240) & (before[:, 1] > 0) & (before[:, 1] < 375)
    after = motion.project(RIG, later)[:, :2].astype(np.float32)
    found = motion.camera_motion(RIG, every[seen], before[seen, :2], after[seen], (1241, 376))
    assert found is not None and np.abs(found[1] - pose[1]).max() < 0.05


def test_lonely_movers_are_dropped():
    points = np.array([[0.0, 0.0], [10.0, 0.0], [0.0, 10.0], [500.0, 0.0]])
    labels = np.full(4, motion.MOVING, np.uint8)
    assert motion.supported(points, labels).tolist() == [motion.MOVING] * 3 + [motion.UNKNOWN]


def test_refined_maps_follow_the_nearest_labelled_point_on_a_vehicle():
    kinds = np.ones((60, 200), np.uint8)
    kinds[20:40, 20:60], kinds[20:40, 110:200] = 0, 0
    points = np.array([[40.0, 30.0], [120.0, 30.0], [65.0, 30.0], [141.0, 30.0]])
    labels = np.array([motion.MOVING, motion.STATIC, motion.MOVING, motion.MOVING], np.uint8)
    found = motion.refined(kinds, points, labels)
    assert (found[20:40, 20:60] == motion.MOVED).all() and found[30, 65] == motion.STILL
    # The right vehicle has points of both kinds: what is far from them stays open.
    assert found[30, 120] == motion.STANDING and found[30, 141] == motion.MOVED and found[30, 199] == motion.IGNORED


def test_a_region_labelled_alike_is_completed():
    labels = np.full((30, 120), motion.STILL, np.uint8)
    labels[5:25, 10:50], labels[5:25, 60:110] = motion.IGNORED, motion.IGNORED
    labels[5:25, 10:30], labels[5:25, 60:65] = motion.MOVED, motion.STANDING
    found = motion.completed(labels)
    assert (found[5:25, 10:50] == motion.MOVED).all() and found[10, 100] == motion.IGNORED
    assert (found == motion.STILL).sum() == (labels == motion.STILL).sum()


def test_exact_maps_say_what_moves():
    found = motion.exact(np.array([[0, 1, 2, 3]], np.uint8))
    assert found.tolist() == [[motion.STILL, motion.MOVED, motion.STANDING, motion.STILL]]


def test_points_off_vehicles_decide_where_a_truck_fills_the_view():
    xyz, pose = street(400)
    rng = np.random.default_rng(5)
    # The truck is all the camera sees but for a strip at the left; it keeps its place in the camera.
    truck = np.column_stack([rng.uniform(-5, 8, 900), rng.uniform(-2, 1.5, 900), np.full(900, 7.0)])
    before = motion.project(RIG, np.vstack([xyz[xyz[:, 0] < -3], truck]))
    later = np.vstack([xyz[xyz[:, 0] < -3] @ pose[0].T + pose[1], truck])
    after = motion.project(RIG, later)
    kinds = np.ones((376, 1241), np.uint8)
    on = np.arange(len(before)) >= len(before) - 900
    seen = (before[:, 0] > 0) & (before[:, 0] < 1240) & (before[:, 1] > 0) & (before[:, 1] < 375)
    column, row = np.rint(before[seen & on, :2]).astype(int).T
    kinds[row, column] = 0
    tracks = np.column_stack([before, after])[seen].astype(np.float32)
    found = motion.judged(RIG, tracks, 0.4, (1241, 376), kinds)
    assert found is not None and (found[1][on[seen]] == motion.MOVING).mean() > 0.9


def test_epipolar_error_of_rectified_cameras_is_the_difference_of_rows():
    f = np.array([[0.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    one, two = np.array([[10.0, 20.0], [30.0, 40.0]]), np.array([[5.0, 20.0], [30.0, 43.0]])
    assert np.allclose(epipolar_errors(f, one, two), [0.0, 3.0])


def test_packed_matches_are_cut_scaled_and_padded():
    points = np.array([[0.0, 0.0], [99.0, 49.0]], np.float32)
    places, errors = packed(Pair(points, points, np.array([50.0, 1.0], np.float32)), (100, 50), (100, 50))
    assert places.shape == (KEPT, 4) and errors[:3].tolist() == np.float32([0.1, 1.0, -1.0]).tolist()
    assert np.allclose(to_unit(points, (100, 50))[0], [-0.99, -0.98])


def test_motion_labels_need_frames_enough(tmp_path):
    towns = {}
    for name, count in (("short", max(prepare.SPANS)), ("long", max(prepare.SPANS) + 4)):
        towns[name] = tmp_path / name
        for part, value in (("image_0", 90), ("masks", 1)):
            (towns[name] / part).mkdir(parents=True)
            for i in range(count):
                cv2.imwrite(str(towns[name] / part / f"{i:06}.png"), np.full((94, 310), value, np.uint8))

    def made(*names):
        entries = [f"{towns[name]}:2" for name in names]
        prepare.motion(argparse.Namespace(sequence=entries, labels="masks", cache=tmp_path))
        with np.load(tmp_path / "motion.npz") as file:
            return file["source"].tolist()

    with pytest.raises(SystemExit, match="more than 8 frames"):
        made("short")
    assert not (tmp_path / "motion.npz").exists()
    assert made("short", "long") == [1, 1], "frames 0 and 2 of 12, each with 8 after it"
