"""What the tests of the Python module share. `./test.sh` builds the module and runs them."""

import os
import pathlib

import numpy as np
import pytest

import dsslam

ROOT = pathlib.Path(__file__).resolve().parents[3]
SETTINGS = {"features.selection": "response", "features.keep": 500}


@pytest.fixture(scope="session")
def world():
    return dsslam.World("town")


@pytest.fixture(scope="session")
def frames(world):
    """The first 12 frames of the town: (t_ns, left, right)."""
    return [(world.t_ns(i), *world.images(i)) for i in range(12)]


@pytest.fixture
def slam(world):
    return dsslam.Slam(camera=world.camera, settings=SETTINGS)


def push(slam, frames):
    return [slam.track(*frame) for frame in frames]


def poses(results):
    return np.array([result.pose for result in results])


def real(name):
    """A real sequence; without DSSLAM_DATA the test is skipped and says so."""
    data = os.environ.get("DSSLAM_DATA")
    if not data:
        pytest.skip("DSSLAM_DATA is not set: real sequences are skipped")
    folder = pathlib.Path(data) / name
    assert folder.is_dir(), f"{folder} is missing in DSSLAM_DATA"
    return folder


def png(file):
    from PIL import Image

    return np.asarray(Image.open(file))
