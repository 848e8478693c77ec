"""Pushing images."""

import threading

import numpy as np
import pytest
from conftest import SETTINGS, poses, push

import dsslam


def test_each_frame_gets_an_answer(slam, frames):
    results = push(slam, frames)
    assert [result.state for result in results] == ["tracked"] * len(frames)
    assert [result.index for result in results] == list(range(len(frames)))
    assert [result.t_ns for result in results] == [t_ns for t_ns, _, _ in frames]
    assert np.array_equal(results[0].pose, np.eye(4)) and results[0].keyframe
    last = results[-1]
    assert last.reason is None and last.inliers > 50 and last.features > 300 and last.track_ms > 0
    rotation = last.pose[:3, :3]
    x, y, z, w = last.quaternion
    assert np.isclose(np.trace(rotation), 4 * w * w - 1) and np.array_equal(last.position, last.pose[:3, 3])


def test_the_drive_is_followed(slam, world, frames):
    results = push(slam, frames)
    first = np.linalg.inv(world.pose(0))
    truth = np.array([first @ world.pose(i) for i in range(len(frames))])
    assert np.abs(poses(results)[:, :3, 3] - truth[:, :3, 3]).max() < 0.05


def test_arrays_of_any_stride_give_the_same_bits(world, frames):
    def padded(image):
        wide = np.zeros((image.shape[0], image.shape[1] + 7), np.uint8)
        wide[:, : image.shape[1]] = image
        return wide[:, : image.shape[1]]

    def every_second(image):
        return np.repeat(image, 2, axis=1)[:, ::2]

    forms = [lambda i: i, padded, every_second, np.asfortranarray, lambda i: i[::-1][::-1], lambda i: i[..., None]]
    runs = []
    for form in forms:
        slam = dsslam.Slam(camera=world.camera, settings=SETTINGS)
        runs.append(poses([slam.track(t, form(left), form(right)) for t, left, right in frames[:5]]))
    for run in runs[1:]:
        assert np.array_equal(runs[0], run)


def test_the_order_of_colors_is_told_or_seen(world, frames):
    def colored(image):
        return np.stack([image, np.roll(image, 1, 0), np.roll(image, 1, 1)], axis=-1)

    def run(color, form):
        slam = dsslam.Slam(camera=world.camera, settings=SETTINGS, color=color)
        return poses([slam.track(t, form(colored(left)), form(colored(right))) for t, left, right in frames[:5]])

    rgb = run("rgb", lambda image: image)
    assert np.array_equal(rgb, run("bgr", lambda image: np.ascontiguousarray(image[:, :, ::-1])))
    assert np.array_equal(rgb, run("bgr", lambda image: image[:, :, ::-1])), "a view that is turned round"
    assert np.array_equal(rgb, run("rgb", lambda image: np.asfortranarray(image)))
    assert not np.array_equal(rgb, run("bgr", lambda image: image))


def test_a_mask_keeps_features_away(world, frames):
    t_ns, left, right = frames[0]
    half = np.ones(left.shape, bool)
    half[:, : left.shape[1] // 2] = False
    settings = SETTINGS | {"features.keep": 9000}
    counts = []
    for mask in [None, half, half.astype(np.uint8) * 255]:
        slam = dsslam.Slam(camera=world.camera, settings=settings)
        counts.append(slam.track(t_ns, left, right, mask=mask).features)
    assert counts[1] == counts[2] < 0.9 * counts[0]


def test_depth_in_meters_and_in_units(world):
    fx, fy, cx, cy = 718.856, 718.856, 607.1928, 185.2157
    width, height = world.camera.size
    camera = dsslam.Camera.rgbd(fx, fy, cx, cy, width=width, height=height, baseline=0.5)
    settings = SETTINGS | {"camera.depth_units_per_metre": 500}
    runs = []
    for form in [np.float32, np.float64, lambda meters: np.round(meters * 500).astype(np.uint16)]:
        slam = dsslam.Slam(camera=camera, settings=settings)
        results = []
        for frame in dsslam.render(frames=3):
            depth = np.where(np.isfinite(frame["depth"]) & (frame["depth"] < 100), frame["depth"], 0)
            results.append(slam.track(frame["t_ns"], frame["left"], depth=form(depth)))
        assert [result.state for result in results] == ["tracked"] * 3 and results[0].with_depth > 100
        runs.append(poses(results))
    assert np.array_equal(runs[0], runs[1]) and np.array_equal(runs[0], runs[2])


def test_finish_gives_the_same_results_again_and_takes_no_more_frames(slam, frames):
    push(slam, frames)
    done = slam.finish()
    times, trajectory = done.trajectory()
    assert len(times) == len(frames) and trajectory.shape == (len(frames), 4, 4)
    assert np.array_equal(slam.finish().trajectory()[1], trajectory) and slam.is_finished
    with pytest.raises(dsslam.Error, match=r"^this Slam is finished; reset\(\) starts again$"):
        slam.track(*frames[0])
    slam.reset()
    push(slam, frames)
    assert np.array_equal(slam.finish().trajectory()[1], trajectory), "after a reset the bits are those of a new run"


def test_a_saved_map_is_found_again(slam, frames, tmp_path):
    push(slam, frames)
    file = tmp_path / "town.dsmap"
    digest = slam.save(file)
    assert len(digest) == 64
    slam.localize(file)
    t_ns, left, right = frames[6]
    seen = slam.track(t_ns, left, right)
    assert seen.relocalized and seen.state == "tracked"
    before = dsslam.Map.load(file)
    assert slam.finish().map.n_keyframes == before.n_keyframes
    slam.load(file)
    push(slam, frames[3:])
    assert slam.finish().n_tracked == len(frames) - 3


def test_two_at_once_in_two_threads_have_the_bits_of_one(world, frames):
    found = [None, None]

    def work(i):
        with dsslam.Slam(camera=world.camera, settings=SETTINGS) as slam:
            found[i] = poses(push(slam, frames))

    threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    alone = poses(push(dsslam.Slam(camera=world.camera, settings=SETTINGS), frames))
    assert np.array_equal(found[0], alone) and np.array_equal(found[1], alone)


def test_memory_is_flat_over_a_thousand_frames(world, frames):
    def resident_mb():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * 4096 / 1e6

    # There and back again, so that the map need not grow.
    course = frames + frames[-2:0:-1]
    slam = dsslam.Slam(camera=world.camera, settings=SETTINGS | {"input.scale": 0.25, "features.keep": 150})
    memory = []
    for i in range(1000):
        _, left, right = course[i % len(course)]
        slam.track(i * 100_000_000, left, right)
        if i % 100 == 99:
            memory.append(resident_mb())
    assert memory[-1] - memory[3] < 25, memory
