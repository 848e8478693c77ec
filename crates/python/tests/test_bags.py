"""Bags of independent writers have the bits of the folders that they were made from."""

import numpy as np
import pytest
from conftest import SETTINGS, png, real

import dsslam

rosbags = pytest.importorskip("rosbags")
from rosbags.rosbag1 import Writer as Ros1  # noqa: E402
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin  # noqa: E402
from rosbags.rosbag2 import Writer as Ros2  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

SECOND = 1_000_000_000


class Bag:
    """Writes messages of images, calibrations and poses into a bag of some kind."""

    def __init__(self, path, kind):
        self.is_ros1 = kind.startswith("ros1")
        self.store = get_typestore(Stores.ROS1_NOETIC if self.is_ros1 else Stores.ROS2_HUMBLE)
        if self.is_ros1:
            self.writer = Ros1(path)
            if kind != "ros1":
                self.writer.set_compression(getattr(Ros1.CompressionFormat, kind.split("_")[1].upper()))
        else:
            plugin = StoragePlugin.MCAP if "mcap" in kind else StoragePlugin.SQLITE3
            self.writer = Ros2(path, version=9, storage_plugin=plugin)
            for word, mode in [("file", CompressionMode.FILE), ("message", CompressionMode.MESSAGE), ("storage", CompressionMode.STORAGE)]:
                if word in kind:
                    self.writer.set_compression(mode, CompressionFormat.ZSTD)
        self.connections = {}
        self.n = 0

    def __enter__(self):
        self.writer.open()
        return self

    def __exit__(self, *_):
        self.writer.close()

    def type(self, name):
        return self.store.types[name]

    def header(self, t_ns):
        stamp = self.type("builtin_interfaces/msg/Time")(sec=t_ns // SECOND, nanosec=t_ns % SECOND)
        extra = {"seq": self.n} if self.is_ros1 else {}
        return self.type("std_msgs/msg/Header")(stamp=stamp, frame_id="cam", **extra)

    def write(self, topic, t_ns, kind, **fields):
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, kind, typestore=self.store)
        message = self.type(kind)(header=self.header(t_ns), **fields)
        serialize = self.store.serialize_ros1 if self.is_ros1 else self.store.serialize_cdr
        self.n += 1
        # Recorded a little later than exposed.
        self.writer.write(self.connections[topic], t_ns + 3_000_000, bytes(serialize(message, kind)))

    def image(self, topic, t_ns, image, encoding):
        data = np.ascontiguousarray(image)
        step = data.strides[0]
        self.write(
            topic,
            t_ns,
            "sensor_msgs/msg/Image",
            height=data.shape[0],
            width=data.shape[1],
            encoding=encoding,
            is_bigendian=0,
            step=step,
            data=data.view(np.uint8).reshape(-1),
        )

    def packed(self, topic, t_ns, file):
        data = np.frombuffer(file.read_bytes(), np.uint8)
        self.write(topic, t_ns, "sensor_msgs/msg/CompressedImage", format="png", data=data)

    def camera_info(self, topic, t_ns, size, k, p):
        roi = self.type("sensor_msgs/msg/RegionOfInterest")(x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
        matrices = {"d": np.zeros(5), "k": np.array(k, float), "r": np.eye(3).reshape(-1), "p": np.array(p, float)}
        if self.is_ros1:
            matrices = {name.upper(): value for name, value in matrices.items()}
        self.write(
            topic,
            t_ns,
            "sensor_msgs/msg/CameraInfo",
            width=size[0],
            height=size[1],
            distortion_model="plumb_bob",
            binning_x=0,
            binning_y=0,
            roi=roi,
            **matrices,
        )


def trajectory(done, tmp_path):
    done.save_trajectory(tmp_path / "t.txt", "tum")
    return (tmp_path / "t.txt").read_bytes()


def kitti(folder, n):
    """Times, images and projection matrices of a folder in KITTI's layout."""
    times = [round(float(line) * 1e9) for line in (folder / "times.txt").read_text().split()][:n]
    images = [sorted((folder / name).glob("*.png"))[:n] for name in ("image_0", "image_1")]
    rows = [line.split() for line in (folder / "calib.txt").read_text().splitlines()[:2]]
    return times, images, [[float(v) for v in row[1:]] for row in rows]


def write_kitti(bag, folder, n, form):
    times, images, projections = kitti(folder, n)
    for i, t_ns in enumerate(times):
        for camera, (files, p) in enumerate(zip(images, projections)):
            topic = f"/cam{camera}"
            image = png(files[i])
            size = (image.shape[1], image.shape[0])
            if i == 0:
                bag.camera_info(f"{topic}/camera_info", t_ns, size, [*p[0:3], *p[4:7], *p[8:11]], p)
            if form == "packed":
                bag.packed(f"{topic}/image_rect/compressed", t_ns, files[i])
            else:
                bag.image(f"{topic}/image_rect", t_ns, image, "mono8")


KINDS = ["ros1", "ros1_bz2", "ros1_lz4", "sqlite", "sqlite_file", "sqlite_message", "mcap", "mcap_storage", "mcap_file"]


@pytest.fixture(scope="session")
def small(tmp_path_factory):
    """Eight rendered frames in KITTI's layout, with the trajectory of the folder."""
    from test_run import program

    folder = tmp_path_factory.mktemp("bags") / "town"
    assert program("synth", folder, "--frames", 8).returncode == 0
    return folder, trajectory(dsslam.run(folder, "kitti", settings=SETTINGS), folder.parent)


@pytest.mark.parametrize("kind", KINDS)
def test_a_bag_of_every_kind_has_the_bits_of_its_folder(small, kind, tmp_path):
    folder, expected = small
    path = tmp_path / ("drive.bag" if kind.startswith("ros1") else "drive")
    with Bag(path, kind) as bag:
        write_kitti(bag, folder, 8, "packed" if kind in ("ros1_lz4", "mcap") else "raw")
    assert trajectory(dsslam.run(path, "kitti", settings=SETTINGS), tmp_path) == expected


def test_topics_can_be_named(small, tmp_path):
    folder, expected = small
    path = tmp_path / "drive"
    with Bag(path, "mcap") as bag:
        write_kitti(bag, folder, 8, "raw")
    topics = "left=/cam0/image_rect,right=/cam1/image_rect"
    assert trajectory(dsslam.run(path, "kitti", settings=SETTINGS, topics=topics), tmp_path) == expected
    with pytest.raises(dsslam.Error, match="found no topic /cam7 for left in .*; its image topics are /cam0/image_rect, /cam1/image_rect"):
        dsslam.run(path, topics="left=/cam7")


def test_real_stereo(tmp_path):
    folder = real("kitti06_first51")
    path = tmp_path / "drive"
    with Bag(path, "mcap_storage") as bag:
        write_kitti(bag, folder, 51, "raw")
    expected = trajectory(dsslam.run(folder, "kitti"), tmp_path)
    assert trajectory(dsslam.run(path, "kitti"), tmp_path) == expected


def test_real_rgbd(tmp_path):
    folder = real("tum_fr1_desk")
    n = 60

    def rows(name):
        lines = (folder / name).read_text().splitlines()
        return [line.split()[:2] for line in lines if not line.startswith("#")]

    def nanoseconds(text):
        seconds, decimals = text.split(".")
        return int(seconds) * SECOND + int(decimals.ljust(9, "0"))

    path = tmp_path / "desk.bag"
    with Bag(path, "ros1_bz2") as bag:
        for topic, encoding, name in [("/camera/rgb/image_color", "rgb8", "rgb.txt"), ("/camera/depth/image", "32FC1", "depth.txt")]:
            for time, file in rows(name)[: n + 40]:
                image = png(folder / file)
                image = image if encoding == "rgb8" else (image.astype(np.float64) / 5000).astype(np.float32)
                bag.image(topic, nanoseconds(time), image, encoding)
    expected = dsslam.run(folder, "tum-rgbd", max_frames=n)
    done = dsslam.run(path, "tum-rgbd", max_frames=n)
    assert trajectory(done, tmp_path) == trajectory(expected, tmp_path)


def test_real_raw_stereo_with_the_calibration_of_its_folder(tmp_path):
    folder = real("euroc_MH01_200")
    path, n = tmp_path / "MH_01_easy.bag", 60
    with Bag(path, "ros1") as bag:
        for camera in range(2):
            for file in sorted((folder / f"mav0/cam{camera}/data").glob("*.png"))[:n]:
                bag.image(f"/cam{camera}/image_raw", int(file.stem), png(file), "mono8")
    expected = trajectory(dsslam.run(folder, "euroc", max_frames=n), tmp_path)
    done = dsslam.run(path, "euroc", calibration=folder)
    assert trajectory(done, tmp_path) == expected and done.n_frames == n
    # The stamps are those of the images, to the nanosecond.
    first = sorted((folder / "mav0/cam0/data").glob("*.png"))[0].stem
    assert done.n_tracked > n // 2 and first[:10].encode() in expected


def test_a_bag_cut_short_is_read_as_far_as_it_goes(small, tmp_path):
    folder, _ = small
    path = tmp_path / "drive"
    with Bag(path, "mcap") as bag:
        write_kitti(bag, folder, 8, "raw")
    file = next(path.glob("*.mcap"))
    file.write_bytes(file.read_bytes()[: file.stat().st_size * 6 // 10])
    done = dsslam.run(file, "kitti", settings=SETTINGS)
    assert 3 <= done.n_frames < 8
