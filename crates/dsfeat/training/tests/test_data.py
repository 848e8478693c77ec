"""Label maps, augmentation, metrics."""

from pathlib import Path

import numpy as np
import pytest

from dsfeat import augment, data
from dsfeat.metrics import Tally
from dsfeat.network import HEIGHT, WIDTH


@pytest.mark.parametrize(
    "source, dynamic, static, ignored",
    [
        ("cityscapes256", [11, 13, 18], [0, 2, 8, 10], [255]),
        ("idd_lite", [2, 3], [0, 1, 4, 5, 6], [255]),
        ("camvid", [8, 9, 10], [0, 1, 3, 7], [11]),
        ("kitti_pseudo", [255], [0], [128]),
        ("town", [1, 2], [0, 3], []),
    ],
)
def test_label_maps(source, dynamic, static, ignored):
    labels = np.array([dynamic + static + ignored], np.uint8)
    expected = [data.DYNAMIC] * len(dynamic) + [data.STATIC] * len(static) + [data.IGNORED] * len(ignored)
    assert data.stability(labels, source).tolist() == [expected]


def test_evaluation_sequences_are_not_trained_on():
    assert not set(data.KITTI_TRAIN) & set(data.KITTI_VAL)


def test_a_sample_depends_on_its_key_only():
    image = np.random.default_rng(0).integers(0, 256, (187, 620), dtype=np.uint8)
    labels = (image > 128).astype(np.uint8)
    one, two = (augment.sample(np.random.default_rng((1, 2, 3)), image, labels, 3.3) for _ in range(2))
    assert np.array_equal(one[0], two[0]) and np.array_equal(one[1], two[1])
    assert one[0].shape == (HEIGHT, WIDTH) and one[1].shape == (HEIGHT // 2, WIDTH // 2)
    assert one[0].min() >= 0.0 and one[0].max() <= 1.0


@pytest.mark.parametrize("aspect", [4 / 3, 2.0, 3.3])
def test_windows_lie_within_the_frame(aspect):
    rng = np.random.default_rng(5)
    for _ in range(200):
        x, y, width, height = augment.window(rng, aspect)
        assert 0 <= x and 0 <= y and x + width <= 1 + 1e-9 and y + height <= 1 + 1e-9 and height > 0.1


@pytest.mark.parametrize("flip", [False, True])
def test_image_and_labels_are_cut_alike(flip):
    columns = np.linspace(0, 255, 640).astype(np.uint8)
    image = np.repeat(columns[None], 200, axis=0)
    labels = (image > 127).astype(np.uint8)
    shown, cut = augment.warp(image, labels, (0.2, 0.1, 0.6, 0.8), flip)
    assert ((shown[::2, ::2] > 127) == (cut == 1)).mean() > 0.985


def test_tally_of_known_values():
    tally = Tally()
    activation = np.array([[0.9, 0.8, 0.3, 0.1]])
    tally.add(activation, np.array([[True, False, True, False]]), np.array([[False, True, False, True]]))
    assert tally.auc() == 0.75
    assert tally.iou() == (1 / 3, 1 / 3)


def test_a_limit_spreads_frames_over_the_folder():
    paths = [Path(f"{i}.png") for i in range(9)]
    assert data.spread(paths, None) == data.spread(paths, 9) == paths
    assert data.spread(paths, 3) == [paths[0], paths[4], paths[8]]
