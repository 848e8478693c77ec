"""Geometry of the motion labels and of the matches."""

import numpy as np

from dsfeat import motion
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
    kinds[20:40, 20:60], kinds[20:40, 120:190] = 0, 0
    points = np.array([[40.0, 30.0], [125.0, 30.0], [70.0, 30.0]])
    labels = np.array([motion.MOVING, motion.STATIC, motion.MOVING], np.uint8)
    found = motion.refined(kinds, points, labels)
    assert (found[20:40, 20:60] == motion.MOVED).all() and found[30, 70] == motion.STILL
    assert found[30, 130] == motion.STANDING and found[30, 185] == motion.IGNORED


def test_epipolar_error_of_rectified_cameras_is_the_difference_of_rows():
    f = np.array([[0.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    one, two = np.array([[10.0, 20.0], [30.0, 40.0]]), np.array([[5.0, 20.0], [30.0, 43.0]])
    assert np.allclose(epipolar_errors(f, one, two), [0.0, 3.0])


def test_packed_matches_are_cut_scaled_and_padded():
    points = np.array([[0.0, 0.0], [99.0, 49.0]], np.float32)
    places, errors = packed(Pair(points, points, np.array([50.0, 1.0], np.float32)), (100, 50), (100, 50))
    assert places.shape == (KEPT, 4) and errors[:3].tolist() == np.float32([0.1, 1.0, -1.0]).tolist()
    assert np.allclose(to_unit(points, (100, 50))[0], [-0.99, -0.98])
