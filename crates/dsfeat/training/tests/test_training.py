"""The network, a step's determinism, resuming, configuration files."""

import json
from dataclasses import replace

import numpy as np
import pytest
import torch

from dsfeat import augment, config as configuration, train_two
from dsfeat.network import HEIGHT, WIDTH, DSFeat, multiply_adds, restored
from dsfeat.data import Scenes
from dsfeat.train import Labelled, step_losses
from dsfeat.triplets import Matching


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
    maps = np.stack([np.full((HEIGHT, WIDTH), v, np.uint8) for v in (0, 1, 3)])
    frames = {"images": triplets["images"], "maps": maps}
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


def test_unknown_settings_are_named(tmp_path):
    (tmp_path / "a.json").write_text(json.dumps({"epoch": 3}))
    with pytest.raises(SystemExit, match="unknown keys epoch"):
        configuration.read(tmp_path / "a.json")


def test_a_checkpoint_brings_its_own_widths(tmp_path):
    network = DSFeat((4, 8, 12), (1, 2))
    state = {"network": network.state_dict(), "widths": [4, 8, 12], "dilations": [1, 2]}
    torch.save(state, tmp_path / "last.pt")
    image = torch.rand(1, 1, HEIGHT, WIDTH)
    assert torch.equal(restored(tmp_path / "last.pt").eval()(image), network.eval()(image))


def test_a_street_sample_is_never_mirrored_and_repaints_objects_only():
    image = np.full((HEIGHT, WIDTH), 40, np.uint8)
    image[:, : WIDTH // 2] = 200
    objects = np.zeros(image.shape, bool)
    objects[20:60, 40:90] = True
    for seed in range(20):
        rng = np.random.default_rng(seed)
        shown = augment.repaint(rng, image, objects)
        assert np.array_equal(shown[~objects], image[~objects])
        sample = augment.street_sample(rng, image, objects.astype(np.uint8), np.zeros_like(objects), WIDTH / HEIGHT)[0]
        assert sample[:, :60].mean() > sample[:, -60:].mean()


@pytest.mark.parametrize("settings", [configuration.Config(hybrid=True), train_two.Config(hybrid=True, milestones=[14], steps=[20, 10])])
def test_a_trial_is_the_same_run_with_two_epochs_of_three_steps(settings):
    short = configuration.trial(settings)
    assert [short.steps_in(epoch) for epoch in range(short.epochs)] == [3, 3]
    assert replace(short, epochs=settings.epochs, steps=settings.steps) == settings
