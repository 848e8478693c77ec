"""The network, a step's determinism, resuming, configuration files."""

import json

import numpy as np
import pytest
import torch

from dsfeat import config as configuration
from dsfeat.network import HEIGHT, WIDTH, DSFeat, multiply_adds
from dsfeat.data import Scenes
from dsfeat.train import Labelled, step_losses
from dsfeat.triplets import Matching, windowed


def scenes() -> Scenes:
    rng = np.random.default_rng(1)
    images = rng.integers(0, 256, (4, 96, 320), dtype=np.uint8)
    maps = rng.integers(0, 3, images.shape, dtype=np.uint8)
    return Scenes("noise", images, maps, maps, WIDTH / HEIGHT)


def matching() -> Matching:
    rng = np.random.default_rng(2)
    triplets = {
        "images": rng.integers(0, 256, (3, HEIGHT, WIDTH), dtype=np.uint8),
        "descriptors": rng.standard_normal((3, 12, 40, 64)).astype(np.float16),
        "index": np.array([[0, 1, 2]]), "source": np.array([0]),
        "points": rng.uniform(-1, 1, (1, 2, 16, 4)).astype(np.float32),
        "errors": rng.uniform(-0.2, 1, (1, 2, 16)).astype(np.float32),
    }
    frames = {
        "images": triplets["images"], "points": rng.uniform(-1, 1, (3, 20, 2)).astype(np.float32),
        "labels": np.array([[0] * 10 + [1] * 10, [1] * 20, [2] * 20], np.uint8),
    }
    return Matching(triplets, frames)


def one_step() -> dict[str, torch.Tensor]:
    """Parameters after one hybrid step from fixed seeds."""
    torch.manual_seed(3)
    settings = configuration.Config(hybrid=True, hybrid_batch=2, motion_frames=2)
    network = DSFeat()
    optimiser = torch.optim.Adam(network.parameters(), lr=1e-3)
    labelled = Labelled({"a": [scenes()]}, {"a": 1.0})
    total = step_losses(network, labelled, matching(), settings, 5, 0)[0]
    total.backward()
    optimiser.step()
    return network.state_dict()


def test_a_step_is_deterministic_and_changes_the_network():
    one, two = one_step(), one_step()
    assert all(torch.equal(one[k], two[k]) for k in one)
    torch.manual_seed(3)
    assert not torch.equal(one["head.weight"], DSFeat().state_dict()["head.weight"])


def test_network_size():
    network = DSFeat()
    assert network(torch.rand(1, 1, HEIGHT, WIDTH)).shape == (1, 1, HEIGHT // 2, WIDTH // 2)
    assert 2 * multiply_adds(network) < 0.3e9


def test_mirrored_triplets_mirror_images_descriptors_and_points():
    source = matching()
    for seed in range(20):
        batch = source.triplet_batch(np.random.default_rng(seed), 1)
        mirrored = not np.array_equal(batch.images[0, 0], source.triplets["images"][0])
        sign = -1.0 if mirrored else 1.0
        assert np.allclose(batch.positive.points_1[0, :, 0], sign * source.triplets["points"][0, 0, :, 0])
        assert np.allclose(batch.positive.points_1[0, :, 1], source.triplets["points"][0, 0, :, 1])
        first = batch.descriptors[0, 0, :, 0, -1 if mirrored else 0]
        assert np.allclose(first, source.triplets["descriptors"][0, 0, 0].astype(np.float32))


def test_points_stay_on_the_image_in_a_window():
    image = np.zeros((188, 620), np.uint8)
    image[90:98, 300:308] = 255
    point = np.array([[2 * 304 / 620 - 1, 2 * 94 / 188 - 1]], np.float32)
    checked = 0
    for seed in range(30):
        shown, placed = windowed(np.random.default_rng(seed), image, point)
        if np.abs(placed).max() < 0.95:
            column, row = (placed[0] + 1) * np.array([WIDTH, HEIGHT]) / 2
            assert shown[int(row), int(column)] > 128
            checked += 1
    assert checked > 10


def test_unknown_settings_are_named(tmp_path):
    (tmp_path / "a.json").write_text(json.dumps({"epoch": 3}))
    with pytest.raises(SystemExit, match="unknown keys epoch"):
        configuration.read(tmp_path / "a.json")
