"""MCAP files are read by the packages `mcap` and `mcap-ros2-support`: every message decodes, and says what the trajectory says."""

import csv
import io
import signal
import subprocess
import sys
import time
from collections import defaultdict

import numpy as np
import pytest
from conftest import SETTINGS, real

import dsslam

mcap_reader = pytest.importorskip("mcap.reader")
from mcap.exceptions import McapError  # noqa: E402
from mcap_ros2.decoder import DecoderFactory  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402
from test_run import PROGRAM, program  # noqa: E402

SECOND = 1_000_000_000
QUICK = [part for name, value in SETTINGS.items() for part in ("--set", f"{name}={value}")]
# From the axes of a camera to those of ROS.
TURN = np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]])


def ns(stamp):
    return stamp.sec * SECOND + stamp.nanosec


def decoded(data, is_whole=True):
    """Messages by topic; of a file that was cut, those before the cut."""
    if is_whole:
        reader = mcap_reader.make_reader(io.BytesIO(data), decoder_factories=[DecoderFactory()], validate_crcs=True)
        assert reader.get_summary() is not None
    else:
        reader = mcap_reader.NonSeekingReader(io.BytesIO(data), decoder_factories=[DecoderFactory()])
    found = defaultdict(list)
    try:
        for _, channel, message, content in reader.iter_decoded_messages(log_time_order=is_whole):
            stamp = content.transforms[0].header.stamp if channel.topic == "/tf" else content.header.stamp
            assert message.log_time == message.publish_time == ns(stamp)
            found[channel.topic].append(content)
    except (McapError, EOFError, ValueError):
        assert not is_whole
    return found


def rotation(q):
    x, y, z, w = q.x, q.y, q.z, q.w
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def matrix(position, orientation):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation(orientation), (position.x, position.y, position.z)
    return pose


def of_pose(pose):
    return matrix(pose.position, pose.orientation)


def of_transform(transform):
    return matrix(transform.translation, transform.rotation)


def rows(file):
    """A TUM trajectory: stamps in nanoseconds, and the numbers of each pose as ROS has them: position, quaternion x, y, z, w."""
    lines = [line.split() for line in file.read_text().splitlines() if not line.startswith("#")]
    stamps = [int(line[0].replace(".", "")) for line in lines]
    values = [[float(v) for v in line[1:]] for line in lines]
    return stamps, [[z, -x, -y, qz, -qx, -qy, qw] for x, y, z, qx, qy, qz, qw in values]


def numbers(pose):
    p, q = pose.position, pose.orientation
    return [p.x, p.y, p.z, q.x, q.y, q.z, q.w]


def check_path(path, file):
    """The path is the trajectory, to the last digit that the file has."""
    stamps, poses = rows(file)
    assert [ns(pose.header.stamp) for pose in path.poses] == stamps
    np.testing.assert_allclose([numbers(pose.pose) for pose in path.poses], poses, rtol=0, atol=6e-13)


@pytest.fixture(scope="module")
def town(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mcap")
    assert program("synth", folder / "town", "--frames", 40).returncode == 0
    more = ["--mcap", folder / "town.mcap", "--out", folder / "run", "--save-map", folder / "town.dsmap", *QUICK]
    ran = program("run", folder / "town", "--quiet", *more)
    assert ran.returncode == 0, ran.stderr
    return folder


@pytest.fixture(scope="module")
def live(town):
    return decoded((town / "town.mcap").read_bytes())


def test_types_are_those_of_ros(town):
    reader = mcap_reader.make_reader(io.BytesIO((town / "town.mcap").read_bytes()))
    assert reader.get_header().profile == "ros2"
    store = get_typestore(Stores.ROS2_JAZZY)
    schemas = reader.get_summary().schemas.values()
    assert len(schemas) == 6

    def parts(text):
        """The types of a definition: name and fields."""
        first, *rest = text.replace(f"{'=' * 80}\n", "\0").split("\0")
        named = [part.split("\n", 1) for part in rest]
        return first.split("\n"), {name: fields.split("\n") for name, fields in named}

    for schema in schemas:
        assert schema.encoding == "ros2msg"
        expected, _ = store.generate_msgdef(schema.name, ros_version=2)
        assert parts(schema.data.decode().strip()) == parts(expected.strip())
    assert {channel.message_encoding for channel in reader.get_summary().channels.values()} == {"cdr"}


def test_each_frame_has_its_stamp_and_the_chain_of_transforms_leads_to_its_pose(town, live):
    stamps, _ = rows(town / "run" / "trajectory.tum.txt")
    assert len(stamps) == 40
    for topic in ["/odometry", "/pose"]:
        assert [ns(message.header.stamp) for message in live[topic]] == stamps
    optical = np.eye(4)
    optical[:3, :3] = TURN
    for tf, odometry, pose in zip(live["/tf"], live["/odometry"], live["/pose"], strict=True):
        links = [(link.header.frame_id, link.child_frame_id) for link in tf.transforms]
        assert links == [("map", "odom"), ("odom", "base_link"), ("base_link", "camera_optical_frame")]
        to_odom, to_base, to_camera = (of_transform(link.transform) for link in tf.transforms)
        assert (odometry.header.frame_id, odometry.child_frame_id, pose.header.frame_id) == ("odom", "base_link", "map")
        np.testing.assert_array_equal(to_base, of_pose(odometry.pose.pose))
        np.testing.assert_allclose(to_odom @ to_base, of_pose(pose.pose.pose), rtol=0, atol=1e-9)
        np.testing.assert_allclose(to_camera, optical, rtol=0, atol=1e-15)


def test_velocities_are_those_of_the_odometry(live):
    odometry = live["/odometry"]
    for before, now in zip(odometry, odometry[1:]):
        seconds = (ns(now.header.stamp) - ns(before.header.stamp)) / SECOND
        moved = np.linalg.inv(of_pose(now.pose.pose)) @ of_pose(before.pose.pose)
        v = now.twist.twist.linear
        np.testing.assert_allclose([v.x, v.y, v.z], -moved[:3, 3] / seconds, rtol=0, atol=1e-7)
    # The town is driven through forward, at some meters a second.
    assert 3 < v.x < 30 and abs(v.y) < 1 and abs(v.z) < 1


def test_the_last_path_is_the_final_trajectory_and_the_last_points_are_the_map(town, live):
    check_path(live["/path"][-1], town / "run" / "trajectory.tum.txt")
    assert live["/path"][-1].header.frame_id == "map"
    cloud = live["/map_points"][-1]
    fields = [(field.name, field.offset, field.datatype) for field in cloud.fields]
    assert fields == [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("rgb", 12, 7), ("activation", 16, 7), ("trust", 20, 7), ("observations", 24, 6)]
    kind = np.dtype([("at", "<f4", 3), ("rgb", "u1", 4), ("activation", "<f4"), ("trust", "<f4"), ("observations", "<u4")])
    points = np.frombuffer(bytes(cloud.data), kind)
    map = dsslam.Map.load(town / "town.dsmap")
    assert cloud.width == len(points) == map.n_points and cloud.point_step == kind.itemsize
    np.testing.assert_array_equal(points["at"], (map.points @ TURN.T).astype(np.float32))
    np.testing.assert_array_equal(points["activation"], map.activation)
    assert 0 < points["trust"].min() < points["trust"].max() <= 1
    assert points["observations"].sum() == len(map.observations["point"])
    assert np.ptp(points["rgb"][:, 0]) > 50, "gray values of the images"


def test_the_cameras_are_described(live):
    (left,), (right,) = live["/camera_info"], live["/right/camera_info"]
    assert left.header.frame_id == right.header.frame_id == "camera_optical_frame"
    assert left.p[0] == left.k[0] > 100 and left.p[3] == 0
    assert right.p[3] == pytest.approx(-right.p[0] * 0.54, rel=0.5) and right.p[3] < 0


def test_equal_runs_give_equal_bytes(town):
    for schedule in ["lockstep", "sequential"]:
        again = town / f"{schedule}.mcap"
        ran = program("run", town / "town", "--quiet", "--schedule", schedule, "--mcap", again, "--out", town / schedule, *QUICK)
        assert ran.returncode == 0, ran.stderr
        assert again.read_bytes() == (town / "town.mcap").read_bytes()
    done = dsslam.run(town / "town", settings=SETTINGS, mcap=town / "module.mcap")
    assert (town / "module.mcap").read_bytes() == (town / "town.mcap").read_bytes() and done.n_tracked == 40


def test_a_cut_file_is_readable_as_far_as_it_goes(town):
    data = (town / "town.mcap").read_bytes()
    seen = []
    for tenths in range(11):
        found = decoded(data[: len(data) * tenths // 10], is_whole=False)
        seen.append(len(found["/odometry"]))
        assert len(found["/tf"]) == len(found["/odometry"])
    assert seen == sorted(seen) and seen[0] == 0 and seen[-1] == 40 and len(set(seen)) >= 4


def test_a_killed_run_leaves_what_it_had(town, tmp_path):
    file = tmp_path / "killed.mcap"
    command = [*PROGRAM, "run", town / "town", "--quiet", "--schedule", "live", "--realtime", "--mcap", file, "--out", tmp_path / "out", *QUICK]
    with subprocess.Popen([str(part) for part in command], stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as running:
        begun, size = time.monotonic(), 0
        # The header and two chunks of ten frames.
        while size < 20_000 and time.monotonic() < begun + 60 and running.poll() is None:
            time.sleep(0.02)
            size = file.stat().st_size if file.exists() else 0
        assert running.poll() is None, "killed in the middle"
        running.send_signal(signal.SIGKILL)
    found = decoded(file.read_bytes(), is_whole=False)
    assert 10 <= len(found["/odometry"]) < 40
    listed = program("inspect", "bag", file)
    assert "/odometry" in listed.stdout and "cut short" in listed.stdout + listed.stderr


@pytest.mark.parametrize("has_map", [False, True])
def test_results_are_exported(town, has_map):
    out = town / "export.mcap"
    more = ["--map", town / "town.dsmap"] if has_map else []
    ran = program("export", town / "run", "--to", "mcap", "--out", out, *more)
    assert ran.returncode == 0, ran.stderr
    check_results(decoded(out.read_bytes()), town / "run" / "trajectory.tum.txt")
    assert len(decoded(out.read_bytes())["/map_points"]) == int(has_map)


def check_results(found, trajectory):
    stamps, poses = rows(trajectory)
    assert [ns(message.header.stamp) for message in found["/odometry"]] == stamps
    np.testing.assert_allclose([numbers(m.pose.pose) for m in found["/odometry"]], poses, rtol=0, atol=6e-13)
    np.testing.assert_allclose([numbers(m.pose.pose) for m in found["/pose"]], poses, rtol=0, atol=6e-13)
    check_path(found["/path"][-1], trajectory)


def test_a_map_is_exported_with_its_keyframes(town):
    out = town / "map.mcap"
    ran = program("export", town / "town.dsmap", "--to", "mcap", "--out", out)
    assert ran.returncode == 0, ran.stderr
    found = decoded(out.read_bytes())
    map = dsslam.Map.load(town / "town.dsmap")
    assert len(found["/odometry"]) == map.n_keyframes
    ahead = [m.pose.pose.position.x for m in found["/odometry"]]
    np.testing.assert_allclose(ahead, map.keyframe_poses[:, 2, 3], rtol=0, atol=1e-12)


def test_results_of_the_module(town, tmp_path):
    done = dsslam.run(town / "town", settings=SETTINGS)
    done.save_mcap(tmp_path / "m.mcap")
    done.save_trajectory(tmp_path / "t.txt", "tum")
    check_results(decoded((tmp_path / "m.mcap").read_bytes()), tmp_path / "t.txt")


def test_pushed_frames_keep_their_nanoseconds(world, tmp_path):
    slam = dsslam.Slam(camera=world.camera, settings=SETTINGS)
    stamps = [1_403_636_579_763_555_584 + i * 100_000_001 for i in range(6)]
    motions = [slam.track(t_ns, *world.images(i)).motion for i, t_ns in enumerate(stamps)]
    assert motions[0] is None and all(0.2 < motion[2, 3] < 3 for motion in motions[1:]), "forward"
    slam.finish().save_mcap(tmp_path / "m.mcap")
    found = decoded((tmp_path / "m.mcap").read_bytes())
    assert [ns(message.header.stamp) for message in found["/odometry"]] == stamps


def test_real_euroc_stamps_are_exact(tmp_path):
    folder = real("euroc_MH01_200")
    dsslam.run(folder, settings=SETTINGS, max_frames=25, mcap=tmp_path / "m.mcap")
    names = sorted(int(file.stem) for file in (folder / "mav0" / "cam0" / "data").glob("*.png"))
    stamps = [ns(message.header.stamp) for message in decoded((tmp_path / "m.mcap").read_bytes())["/odometry"]]
    assert len(stamps) > 15 and set(stamps) <= set(names[:25])


def test_a_file_that_cannot_be_written_is_named(town, tmp_path):
    ran = program("run", town / "town", "--quiet", "--mcap", tmp_path, *QUICK)
    assert ran.returncode == 3 and f"{tmp_path}: cannot be written: it is a folder" in ran.stderr
    with pytest.raises(dsslam.Error, match="cannot be written"):
        dsslam.run(town / "town", settings=SETTINGS, mcap=tmp_path)


@pytest.mark.skipif(sys.platform != "linux", reason="needs /dev/full")
def test_a_full_disk_costs_the_file_and_not_the_results(town, tmp_path):
    out = tmp_path / "out"
    link = tmp_path / "full.mcap"
    link.symlink_to("/dev/full")
    ran = program("run", town / "town", "--quiet", "--mcap", link, "--out", out, *QUICK)
    assert ran.returncode == 3 and f"{link}: cannot be written: No space left" in ran.stderr
    assert (out / "trajectory.tum.txt").read_bytes() == (town / "run" / "trajectory.tum.txt").read_bytes()


def covariances(file):
    """Covariances of the frames with a pose in `frames.csv`, along the axes of the camera; None where there is none."""
    axes = ["x", "y", "z", "rx", "ry", "rz"]
    found = []
    with open(file, newline="") as text:
        for row in csv.DictReader(text):
            if row["state"] != "tracked":
                continue
            matrix = np.zeros((6, 6))
            for i, a in enumerate(axes):
                for j, b in enumerate(axes[i:], i):
                    if row[f"cov_{a}{b}"]:
                        matrix[i, j] = matrix[j, i] = float(row[f"cov_{a}{b}"])
            found.append(matrix)
    return found


@pytest.mark.parametrize("topics", ["live", "exported"])
def test_covariances_are_those_of_the_table_along_the_axes_of_the_parent(town, live, topics):
    found = live
    if topics == "exported":
        out = town / "covariances.mcap"
        assert program("export", town / "run", "--to", "mcap", "--out", out).returncode == 0
        found = decoded(out.read_bytes())
    table = covariances(town / "run" / "frames.csv")
    assert len(table) == 40 and sum(matrix.any() for matrix in table) >= 38
    for topic in ["/odometry", "/pose"]:
        for message, of_camera in zip(found[topic], table, strict=True):
            turn = np.kron(np.eye(2), rotation(message.pose.pose.orientation) @ TURN)
            matrix = np.array(message.pose.covariance).reshape(6, 6)
            np.testing.assert_allclose(matrix, turn @ of_camera @ turn.T, rtol=1e-9, atol=1e-12)
    last = found["/odometry"][-1]
    assert np.linalg.eigvalsh(np.array(last.twist.covariance).reshape(6, 6)).min() > 0


def test_corrections_of_the_map_go_into_the_odometry_frame(tmp_path):
    """KITTI's calibration is refined during the run, which moves the map under the camera: the odometry does not jump."""
    folder = real("kitti06_first51")
    dsslam.run(folder, "kitti", mcap=tmp_path / "m.mcap")
    found = decoded((tmp_path / "m.mcap").read_bytes())
    at = np.array([of_pose(message.pose.pose)[:3, 3] for message in found["/odometry"]])
    in_map = np.array([of_pose(message.pose.pose)[:3, 3] for message in found["/pose"]])
    corrected = np.array([of_transform(message.transforms[0].transform)[:3, 3] for message in found["/tf"]])
    # The car drives steadily: steps change by little from frame to frame.
    changes = [np.linalg.norm(np.diff(path, 2, axis=0), axis=1).max() for path in (at, in_map)]
    assert len(at) == 51 and changes[0] < 0.1
    assert np.linalg.norm(corrected[-1]) > 0.01, "the map was corrected"
    assert changes[0] <= changes[1] + 1e-3
