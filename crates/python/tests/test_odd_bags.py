"""Damaged and odd bags: what can be read is used, and the rest is named."""

import re

import numpy as np
import pytest
from conftest import png
from test_bags import Bag, kitti, write_kitti
from test_run import program

QUICK = ["--config", "kitti", "--set", "features.selection=response", "--set", "features.keep=500"]
FRAMES = 8
ZSTD = b"\x28\xb5\x2f\xfd"


@pytest.fixture(scope="module")
def town(tmp_path_factory):
    folder = tmp_path_factory.mktemp("odd") / "town"
    assert program("synth", folder, "--frames", FRAMES).returncode == 0
    return folder


def sound(town, path, kind):
    """A bag of the town; of a rosbag2 folder, its file."""
    with Bag(path, kind) as bag:
        write_kitti(bag, town, FRAMES, "raw")
    return path if path.is_file() else next(file for file in path.iterdir() if file.suffix in (".mcap", ".db3"))


def edited(file, change):
    file.write_bytes(bytes(change(bytearray(file.read_bytes()))))
    return file


def cut(data):
    return data[: len(data) * 6 // 10]


def flipped(data):
    middle = len(data) // 2
    data[middle : middle + 64] = bytes(byte ^ 0xFF for byte in data[middle : middle + 64])
    return data


def unpackable(data):
    """The second chunk does not begin as zstd does."""
    at = data.find(ZSTD, data.find(ZSTD) + 1)
    data[at : at + 4] = bytes(4)
    return data


def footless(data):
    """Without data end, summary and footer, as after a power cut."""
    return data[: data.rfind(b"\x0f" + (4).to_bytes(8, "little"))]


def text(data):
    return b"not a bag\n"


def nothing(data):
    return b""


# Kind, what happens to the file, frames that are left (None: the run is refused), what is said.
FILES = {
    "mcap cut": ("mcap", cut, 4, r"the file ends within a record of \d+ bytes; what follows is left out"),
    "ros1 cut": ("ros1", cut, 4, r"drive.bag: byte \d+: the file ends within a record of \d+ bytes; what follows is left out"),
    "sqlite cut": ("sqlite", cut, 4, r"\.db3: byte \d+: (database disk image is malformed|disk I/O error); what follows is left out"),
    "mcap without footer": ("mcap", footless, 8, r"ends without a footer: it was cut short"),
    "mcap chunk changed": ("mcap_storage", unpackable, 6, r"1 damaged chunk is left out, the first: .*drive.mcap: byte \d+: "),
    "ros1 chunk changed": ("ros1_bz2", flipped, 3, r"byte \d+: bzip2: .*; what follows is left out"),
    "empty": ("mcap", nothing, None, r"found an empty file, expected a bag: an MCAP file, a ROS 1 bag"),
    "text": ("mcap", text, None, r'found a file that begins with "not a bag\\n", expected a bag'),
}


def check(path, n_frames, message):
    ran = program("run", path, "--out", path.parent / "results", *QUICK)
    assert re.search(message, ran.stderr), ran.stderr
    if n_frames is None:
        assert ran.returncode == 2, ran.stderr
    else:
        assert f"of {n_frames} with a pose" in ran.stdout, ran.stdout + ran.stderr


@pytest.mark.parametrize("name", FILES)
def test_damaged_files(town, tmp_path, name):
    kind, change, n_frames, message = FILES[name]
    file = sound(town, tmp_path / ("drive.bag" if kind.startswith("ros1") else "drive"), kind)
    check(edited(file, change), n_frames, message)


def test_messages_packed_in_a_file_without_its_metadata(town, tmp_path):
    file = sound(town, tmp_path / "drive", "sqlite_message")
    check(file.rename(tmp_path / "alone.db3"), FRAMES, "8 of 8 images of /cam0/image_rect have a partner")


def test_a_folder_whose_file_is_missing(town, tmp_path):
    sound(town, tmp_path / "drive", "sqlite").unlink()
    check(tmp_path / "drive", None, r"drive: found no file that can be read \(.*\.db3: missing, although metadata.yaml names it\)")


def test_a_folder_with_broken_metadata(town, tmp_path):
    sound(town, tmp_path / "drive", "mcap")
    (tmp_path / "drive" / "metadata.yaml").write_text(": : broken [")
    check(tmp_path / "drive", FRAMES, r"metadata.yaml: .*the files are taken by name")


def images(town, path, change, info=True):
    """A bag of the town's images, each changed: (camera, number, time, pixels) -> (time, pixels, encoding)."""
    times, files, projections = kitti(town, FRAMES)
    with Bag(path, "mcap") as bag:
        for camera, p in enumerate(projections):
            if info:
                height, width = png(files[0][0]).shape
                bag.camera_info(f"/cam{camera}/camera_info", 0, (width, height), [*p[0:3], *p[4:7], *p[8:11]], p)
        for i, t_ns in enumerate(times):
            for camera in range(2):
                t, pixels, encoding = change(camera, i, t_ns, png(files[camera][i]))
                bag.image(f"/cam{camera}/image_rect", t, pixels, encoding)
    return path


def test_an_encoding_that_is_not_read(town, tmp_path):
    wide = lambda camera, i, t, pixels: (t, np.repeat(pixels, 2, axis=1), "yuv422")  # noqa: E731
    ran = program("run", "--out", tmp_path / "out", images(town, tmp_path / "drive", wide), *QUICK)
    assert ran.returncode in (1, 2) and "encoding yuv422, expected" in ran.stderr, ran.stderr


def test_left_and_right_that_are_too_far_apart(town, tmp_path):
    late = lambda camera, i, t, pixels: (t + camera * 45_000_000, pixels, "mono8")  # noqa: E731
    check(images(town, tmp_path / "drive", late), None, "0 of 8 images of /cam0/image_rect have a partner in /cam1/image_rect, the nearest are 45.000 ms apart")


def test_an_image_of_another_size_costs_its_frame(town, tmp_path):
    narrow = lambda camera, i, t, pixels: (t, pixels[:, : 600 if (camera, i) == (0, 4) else None], "mono8")  # noqa: E731
    ran = program("run", "--out", tmp_path / "out", images(town, tmp_path / "drive", narrow), *QUICK)
    assert "7 of 8 with a pose" in ran.stdout and "600" in ran.stderr + ran.stdout, ran.stdout + ran.stderr


def test_a_stamp_that_is_repeated_costs_its_frame(town, tmp_path):
    stuck = lambda camera, i, t, pixels: (t if i != 3 else t - 100_000_000, pixels, "mono8")  # noqa: E731
    ran = program("run", "--out", tmp_path / "out", images(town, tmp_path / "drive", stuck), *QUICK)
    assert re.search(r"of [78] with a pose", ran.stdout), ran.stdout + ran.stderr


def test_no_calibration_at_all(town, tmp_path):
    plain = lambda camera, i, t, pixels: (t, pixels, "mono8")  # noqa: E731
    check(images(town, tmp_path / "drive", plain, info=False), None, r"no camera_info beside /cam0/image_rect|lacks camera.fx")


def test_a_bag_without_images(town, tmp_path):
    with Bag(tmp_path / "drive", "mcap") as bag:
        bag.camera_info("/cam0/camera_info", 0, (640, 240), [1.0] * 9, [1.0] * 12)
    check(tmp_path / "drive", None, "found no topic with images, expected sensor_msgs/Image or CompressedImage; it holds /cam0/camera_info")
