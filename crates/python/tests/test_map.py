"""Maps as arrays, evaluation, activation."""

import numpy as np
import pytest
from conftest import push

import dsslam


@pytest.fixture(scope="module")
def done(world, frames):
    slam = dsslam.Slam(camera=world.camera, settings={"features.selection": "response", "features.keep": 500})
    push(slam, frames)
    return slam.finish()


def test_the_arrays_of_a_map_belong_together(done):
    town = done.map
    n, k, seen = town.n_points, town.n_keyframes, town.observations
    assert town.points.shape == town.point_normals.shape == (n, 3) and town.descriptors.shape == (n, 32)
    assert town.point_ids.shape == town.activation.shape == (n,) and len(set(town.point_ids)) == n
    assert town.keyframe_poses.shape == (k, 4, 4) and len(set(town.keyframe_ids)) == k
    assert (np.diff(town.keyframe_times) > 0).all() and (np.diff(town.keyframe_frames.astype(int)) > 0).all()
    assert len(set(town.keyframe_submaps)) == 1
    assert seen["point"].max() < n and seen["keyframe"].max() < k
    assert set(seen["point"]) == set(range(n)), "every point is seen"


def test_points_lie_where_they_are_seen(done, world):
    town, seen = done.map, done.map.observations
    cam_from_world = np.linalg.inv(town.keyframe_poses)[seen["keyframe"]]
    points = np.einsum("nij,nj->ni", cam_from_world[:, :3, :3], town.points[seen["point"]]) + cam_from_world[:, :3, 3]
    assert (points[:, 2] > 0).all()
    # The focal length and the center that fit best, so that the test needs no camera.
    for axis in (0, 1):
        ratio = points[:, axis] / points[:, 2]
        design = np.stack([ratio, np.ones_like(ratio)], axis=1)
        (focal, center), *_ = np.linalg.lstsq(design, seen["pixel"][:, axis].astype(float), rcond=None)
        error = np.abs(design @ [focal, center] - seen["pixel"][:, axis])
        assert np.median(error) < 1 and focal > 100


def test_a_trajectory_is_evaluated_from_arrays_files_and_results(done, world, frames, tmp_path):
    times, poses = done.trajectory()
    truth = np.array([world.pose(i) for i in range(len(frames))])
    errors = dsslam.evaluate((times, poses), (times, truth), lengths_m=[5.0])
    assert errors["ate_m"]["rmse"] < 0.05 and errors["n_used"] == len(frames)
    file = tmp_path / "estimate.txt"
    done.save_trajectory(file)
    assert np.isclose(dsslam.evaluate(file, (times, truth))["ate_m"]["rmse"], errors["ate_m"]["rmse"], rtol=1e-5)
    assert dsslam.evaluate(done, (times, truth))["ate_m"] == errors["ate_m"]
    same = dsslam.evaluate((times, 2 * poses * [[1, 1, 1, 1]] / 2), (times, poses), alignment="none")
    assert same["ate_m"]["rmse"] == 0


def test_results_tell_of_each_frame(done, frames):
    rows = done.frames
    assert [row["index"] for row in rows] == list(range(len(frames)))
    assert all(row["state"] == "tracked" and row["pose"].shape == (4, 4) for row in rows)
    assert done.loops == [] and done.failure is None and not done.interrupted
    assert "12 of 12 frames with a pose" in repr(done)


def test_activation_is_a_map_between_0_and_1(frames):
    _, left, _ = frames[0]
    activation = dsslam.activation(left)
    assert activation.ndim == 2 and activation.min() >= 0 and activation.max() <= 1
    assert np.array_equal(activation, dsslam.activation(np.repeat(left[..., None], 3, axis=2)))
