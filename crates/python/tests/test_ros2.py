"""The ROS 2 node of `examples/ros2` without ROS.

Messages are those of the package `rosbags`, which has ROS 2's definitions: a field that no message has is an error, and what is published
is serialized as ROS 2 would. `rclpy`, `tf2_ros` and `launch` are stand-ins with the few calls that the node makes: names and types of
topics, services and parameters are checked, what DDS, the executor and tf2 do with them is not.
"""

import importlib
import pathlib
import sys
import types

import numpy as np
import pytest
from conftest import ROOT, png, real
from ros_messages import SECOND, blank, image, message_class, serialized

import dsslam

FOLDER = ROOT / "examples" / "ros2"


@pytest.fixture(scope="module")
def logic():
    sys.path.insert(0, str(FOLDER))
    yield importlib.import_module("dsslam_ros")
    sys.path.remove(str(FOLDER))


@pytest.fixture(scope="module")
def town(tmp_path_factory):
    """The first 15 frames, with CameraInfo of what `synth` writes of the cameras."""
    from test_run import program

    folder = tmp_path_factory.mktemp("ros") / "town"
    assert program("synth", folder, "--frames", 15).returncode == 0
    rows = [[float(v) for v in line.split()[1:]] for line in (folder / "calib.txt").read_text().splitlines()[:2]]
    world = dsslam.World("town")
    frames = [(world.t_ns(i) + 1_700_000_000 * SECOND, *world.images(i)) for i in range(15)]
    height, width = frames[0][1].shape
    infos = {}
    for side, p in zip(["left", "right"], rows):
        info = blank("sensor_msgs/msg/CameraInfo")
        info.width, info.height, info.p = width, height, np.array(p)
        infos[side] = info
    return frames, infos


def pushed(frames, camera):
    slam = dsslam.Slam(camera=camera, schedule="lockstep")
    return [slam.track(t_ns, left, right) for t_ns, left, right in frames]


def test_pairs_are_the_nearest_within_the_tolerance(logic):
    pairs = logic.Pairs(0.01, 4)
    ms = 1_000_000
    assert pairs.add(0, 0, "l0") == []
    assert pairs.add(1, 4 * ms, "r0") == [(0, "l0", "r0")]
    assert pairs.add(0, 100 * ms, "l1") == [] and pairs.add(0, 200 * ms, "l2") == []
    assert pairs.add(1, 203 * ms, "r2") == [(200 * ms, "l2", "r2")], "r1 was lost"
    assert pairs.add(1, 203 * ms, "again") == [], "repeated"
    assert pairs.n_alone == 1
    assert pairs.add(0, 300 * ms, "l3") == [] and pairs.add(1, 311 * ms, "r3") == [], "11 ms apart"
    for i in range(10):
        pairs.add(0, (400 + i) * ms, "waits")
    assert len(pairs.waiting[0]) == 4, "bounded"
    nearer = logic.Pairs(0.01, 4)
    nearer.add(0, 0, "early"), nearer.add(0, 8 * ms, "near")
    assert nearer.add(1, 9 * ms, "right") == [(8 * ms, "near", "right")]


@pytest.mark.parametrize(
    "encoding, kind, channels",
    [("mono8", "u1", 1), ("rgb8", "u1", 3), ("bgr8", "u1", 3), ("rgba8", "u1", 4), ("bgra8", "u1", 4), ("mono16", "u2", 1)],
)
def test_images_of_all_encodings_are_read_with_their_padding(logic, encoding, kind, channels):
    random = np.random.default_rng(1)
    shape = (5, 7) if channels == 1 else (5, 7, channels)
    pixels = random.integers(0, 256 ** int(kind[1]), shape).astype(kind)
    found = logic.brightness_or_color(image(0, pixels, encoding, padding=2))
    expected = {"mono16": pixels >> 8, "mono8": pixels}.get(encoding, pixels[..., 2::-1] if encoding.startswith("bgr") else pixels[..., :3])
    np.testing.assert_array_equal(found, expected)
    assert found.dtype == np.uint8


def test_depth_is_in_meters_and_wrong_images_are_named(logic):
    np.testing.assert_array_equal(logic.meters(image(0, np.array([[1500, 0]], np.uint16), "16UC1")), np.array([[1.5, 0]], np.float32))
    np.testing.assert_array_equal(logic.meters(image(0, np.array([[1.5, np.nan]], np.float32), "32FC1")), np.array([[1.5, 0]], np.float32))
    for wrong, read, message in [
        (image(0, np.zeros((2, 2), np.uint8), "yuv422"), logic.array, "encoding: found 'yuv422', expected one of mono8, "),
        (image(0, np.zeros((2, 2), np.uint8), "mono8"), logic.meters, "encoding: found 'mono8' for depth"),
        (image(0, np.zeros((2, 2), np.float32), "32FC1"), logic.brightness_or_color, "encoding: found '32FC1' for an image"),
    ]:
        with pytest.raises(ValueError, match=message):
            read(wrong)
    short = image(0, np.zeros((2, 2), np.uint8), "mono8")
    short.data = short.data[:3]
    with pytest.raises(ValueError, match="image: found 3 bytes with step 2, expected 2 rows of at least 2 bytes"):
        logic.array(short)


def test_exchanged_cameras_are_named(logic, town):
    _, infos = town
    with pytest.raises(ValueError, match="found the baseline -?0 m in P, expected more than 0: left and right may be exchanged"):
        logic.camera(logic.Parameters(), infos["right"], infos["left"])


def run(logic, town, parameters, **more):
    frames, infos = town
    tracker = logic.Tracker(parameters, **more)
    found = []
    for i, (t_ns, left, right) in enumerate(frames):
        assert tracker.image("left", image(t_ns, left, "mono8")) == []
        if i == 0:
            # Without a calibration nothing is tracked yet.
            assert tracker.image("right", image(t_ns + 1, right, "mono8")) == []
            for side, info in infos.items():
                tracker.camera_info(side, info)
        else:
            found += tracker.image("right", image(t_ns + 2_000_000, right, "mono8"))
    return tracker, found


def test_a_stereo_camera_gives_the_poses_of_the_module_in_the_axes_of_the_robot(logic, town):
    frames, infos = town
    tracker, found = run(logic, town, logic.Parameters(schedule="lockstep"))
    results = pushed(frames[1:], logic.camera(logic.Parameters(), infos["left"], infos["right"]))
    assert [located.t_ns for located in found] == [result.t_ns for result in results if result.is_tracked]
    assert len(found) == 14
    turn = logic.BODY_FROM_OPTICAL
    for located, result in zip(found, results):
        np.testing.assert_allclose(located.map_from_base, turn @ result.pose @ turn.T, rtol=0, atol=1e-9)
    last = found[-1]
    assert last.odom_from_base[0, 3] > 5 and abs(last.odom_from_base[2, 3]) < 0.5, "forward is x, up is z"
    assert 2 < last.velocity[0] < 30 and abs(last.velocity[2]) < 1
    # Odometry follows the camera from frame to frame; what the map was corrected by is in map_from_odom.
    steps = np.array([np.linalg.inv(a.odom_from_base) @ b.odom_from_base for a, b in zip(found, found[1:])])
    expected = np.array([turn @ result.motion @ turn.T for result in results[1:]])
    np.testing.assert_allclose(steps, expected, rtol=0, atol=1e-9)


def test_depth_and_a_camera_that_is_mounted_elsewhere(logic):
    folder = real("tum_fr1_desk")
    info = blank("sensor_msgs/msg/CameraInfo")
    info.width, info.height, info.distortion_model = 640, 480, "plumb_bob"
    info.k = np.array([517.3, 0, 318.6, 0, 516.5, 255.3, 0, 0, 1])
    info.d = np.array([0.2624, -0.9531, -0.0054, 0.0026, 1.1633])
    mounted = np.eye(4)
    mounted[:3, :3] = logic.BODY_FROM_OPTICAL[:3, :3]
    mounted[:3, 3] = 0.5, 0.1, 1.2
    asked = []
    parameters = logic.Parameters(sensor="rgbd", config="tum-rgbd", rectified=False, sync_tolerance=0.02, schedule="lockstep")
    tracker = logic.Tracker(parameters, base_from_camera=lambda frame: asked.append(frame) or mounted)
    tracker.camera_info("left", info)
    frames = []
    for name, file, encoding, n in [("left", "rgb.txt", "rgb8", 30), ("depth", "depth.txt", "32FC1", 12)]:
        lines = [line.split()[:2] for line in (folder / file).read_text().splitlines() if line[0] != "#"]
        frames += [(round(float(time) * 1e6) * 1000, name, encoding, file) for time, file in lines[:n]]
    found = []
    for t_ns, name, encoding, file in sorted(frames):
        pixels = png(folder / file)
        pixels = pixels if name == "left" else (pixels / 5000).astype(np.float32)
        found += tracker.image(name, image(t_ns, pixels, encoding))
    # Color began half a second before depth.
    assert len(found) >= 10 and tracker.pairs.n_alone >= 10 and asked == ["camera"]
    np.testing.assert_allclose(found[0].map_from_base, np.eye(4), rtol=0, atol=1e-12)
    moved = np.linalg.norm(found[-1].map_from_base[:3, 3])
    assert 0.01 < moved < 0.5, "a hand moves"


def test_covariances_move_to_the_base(logic):
    # What is known of the camera along its axis of sight (z) is known of the base along x; a turn moves what lies beside it.
    covariance = np.diag([1.0, 2, 9, 0, 0, 0])
    found = logic.moved(covariance, logic.BODY_FROM_OPTICAL, np.eye(4))
    np.testing.assert_allclose(np.diag(found), [9, 1, 2, 0, 0, 0], atol=1e-12)
    mounted = logic.BODY_FROM_OPTICAL.copy()
    mounted[:3, 3] = 2, 0, 0
    turned = logic.moved(np.diag([0.0, 0, 0, 0, 0.01, 0]), mounted, np.eye(4))
    # The camera, 2 m ahead, knows its heading to 0.1 rad: the base lies 0.2 m to the side of where it is thought to be.
    np.testing.assert_allclose(np.diag(turned), [0, 0.04, 0, 0, 0, 0.01], atol=1e-12)


def test_messages_have_the_fields_of_ros(logic, town):
    kinds = types.SimpleNamespace(
        Odometry=message_class("nav_msgs/msg/Odometry"),
        Path=message_class("nav_msgs/msg/Path"),
        PoseStamped=message_class("geometry_msgs/msg/PoseStamped"),
        TransformStamped=message_class("geometry_msgs/msg/TransformStamped"),
    )
    parameters = logic.Parameters(schedule="lockstep", odom_frame="o", map_frame="m", base_frame="b")
    tracker, found = run(logic, town, parameters)
    located = found[-1]
    odometry = serialized(logic.odometry(kinds, parameters, located))
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("o", "b")
    assert odometry.header.stamp.sec * SECOND + odometry.header.stamp.nanosec == located.t_ns
    p = odometry.pose.pose.position
    np.testing.assert_array_equal([p.x, p.y, p.z], located.odom_from_base[:3, 3])
    links = [serialized(link) for link in logic.transforms(kinds, parameters, located)]
    assert [(link.header.frame_id, link.child_frame_id) for link in links] == [("m", "o"), ("o", "b")]
    path = serialized(logic.path(kinds, parameters, tracker.path, located.t_ns))
    assert len(path.poses) == len(found) and path.header.frame_id == "m"
    for switch, left in [("publish_map_to_odom_tf", "o"), ("publish_odom_to_base_tf", "m")]:
        off = logic.Parameters(**{**vars(parameters), switch: False})
        assert [link.header.frame_id for link in logic.transforms(kinds, off, located)] == [left]
    q = logic.quaternion(logic.BODY_FROM_OPTICAL[:3, :3])
    np.testing.assert_allclose(q, [0.5, -0.5, 0.5, -0.5] if q[3] < 0 else [-0.5, 0.5, -0.5, 0.5])


class FakeRclpy:
    """The calls of rclpy and tf2_ros that the node makes, with what they were given."""

    def __init__(self):
        self.published, self.subscribed, self.served, self.sent, self.said = {}, {}, {}, [], []
        outer = self

        class Node:
            def __init__(self, name):
                self.name, self.values = name, {}

            def declare_parameter(self, name, value):
                self.values[name] = outer.overrides.get(name, value)
                return self.get_parameter(name)

            def get_parameter(self, name):
                return types.SimpleNamespace(value=self.values[name])

            def get_logger(self):
                say = lambda text, **_: outer.said.append(text)  # noqa: E731
                return types.SimpleNamespace(info=say, error=say)

            def create_publisher(self, kind, topic, depth):
                outer.published[topic] = []
                return types.SimpleNamespace(publish=outer.published[topic].append)

            def create_subscription(self, kind, topic, callback, qos):
                outer.subscribed[topic] = (kind.__msgtype__, callback)

            def create_service(self, kind, name, callback):
                outer.served[name] = callback

        class TransformException(Exception):
            pass

        def lookup_transform(self, target, source, time):
            raise TransformException

        empty = types.SimpleNamespace
        self.modules = {
            "rclpy": empty(time=empty(Time=lambda: None)),
            "rclpy.node": empty(Node=Node),
            "rclpy.qos": empty(qos_profile_sensor_data="sensor data"),
            "tf2_ros": empty(
                TransformBroadcaster=lambda node: empty(sendTransform=self.sent.extend),
                Buffer=type("Buffer", (), {"lookup_transform": lookup_transform}),
                TransformListener=lambda buffer, node: None,
                TransformException=TransformException,
            ),
            "std_srvs.srv": empty(Trigger=empty()),
        }
        for package, names in [
            ("geometry_msgs", ["PoseStamped", "TransformStamped"]),
            ("nav_msgs", ["Odometry", "Path"]),
            ("sensor_msgs", ["CameraInfo", "Image"]),
        ]:
            self.modules[f"{package}.msg"] = empty(**{name: message_class(f"{package}/msg/{name}") for name in names})
        self.overrides = {}


@pytest.fixture
def fake(logic, monkeypatch):
    fake = FakeRclpy()
    for name, module in fake.modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.delitem(sys.modules, "dsslam_node", raising=False)
    fake.shell = importlib.import_module("dsslam_node")
    return fake


def test_the_shell_takes_images_and_answers_services(fake, town, tmp_path):
    frames, infos = town
    fake.overrides = {"schedule": "lockstep", "map_file": str(tmp_path / "town.dsmap"), "path_every": 5}
    node = fake.shell.DsslamNode()
    assert {topic: kind for topic, (kind, _) in fake.subscribed.items()} == {
        "left/image": "sensor_msgs/msg/Image",
        "right/image": "sensor_msgs/msg/Image",
        "left/camera_info": "sensor_msgs/msg/CameraInfo",
        "right/camera_info": "sensor_msgs/msg/CameraInfo",
    }
    assert sorted(fake.served) == ["~/load_map", "~/localize", "~/reset", "~/save_map"]

    def answer(name):
        reply = fake.served[f"~/{name}"](None, types.SimpleNamespace(success=None, message=None))
        return reply.success, reply.message

    def show(some):
        for t_ns, left, right in some:
            for side, pixels in [("left", left), ("right", right)]:
                fake.subscribed[f"{side}/image"][1](image(t_ns, pixels, "mono8"))

    assert answer("save_map") == (False, "no image has been tracked yet")
    for side, info in infos.items():
        fake.subscribed[f"{side}/camera_info"][1](info)
    show(frames[:8])
    assert len(fake.published["~/odometry"]) == 8 and len(fake.published["~/path"]) == 2 and len(fake.sent) == 16
    for message in [*fake.published["~/odometry"], *fake.published["~/path"], *fake.sent]:
        serialized(message)
    before = fake.published["~/odometry"][-1].pose.pose.position.x
    assert answer("save_map") == (True, f"{tmp_path / 'town.dsmap'}: written")
    show(frames[8:12])
    after = fake.published["~/odometry"][-1].pose.pose.position.x
    assert len(fake.published["~/odometry"]) > 8 and after >= before, "it is found in the map again, and odometry goes on"
    assert answer("localize") == (True, f"{tmp_path / 'town.dsmap'}: localizing in it")
    assert answer("load_map") == (True, f"{tmp_path / 'town.dsmap'}: loaded")
    assert answer("reset") == (True, "reset")
    show(frames[12:])
    assert fake.published["~/odometry"][-1].pose.pose.position.x < before, "odom begins anew"
    node.get_parameter  # the parameter may be set later
    node.values["map_file"] = str(tmp_path / "missing.dsmap")
    succeeded, message = answer("load_map")
    assert not succeeded and "missing.dsmap" in message
    wrong = image(0, np.zeros((2, 2), np.uint8), "yuv422")
    fake.subscribed["left/image"][1](wrong)
    fake.subscribed["right/image"][1](wrong)
    assert any(text.startswith("the frame at") or text.startswith("encoding: found 'yuv422'") for text in fake.said)


def test_parameters_of_the_file_are_those_of_the_node(logic):
    from ruamel.yaml import YAML

    file = YAML(typ="safe").load((FOLDER / "params.yaml").read_text())
    assert file["/**"]["ros__parameters"] == vars(logic.Parameters())


def test_the_launch_file_starts_the_node_with_its_parameters(monkeypatch):
    empty = types.SimpleNamespace
    node = lambda **kw: ("node", kw)  # noqa: E731
    monkeypatch.setitem(sys.modules, "launch", empty(LaunchDescription=list))
    monkeypatch.setitem(sys.modules, "launch.actions", empty(DeclareLaunchArgument=lambda name, **kw: ("argument", name)))
    monkeypatch.setitem(sys.modules, "launch.substitutions", empty(LaunchConfiguration=lambda name: f"${name}"))
    monkeypatch.setitem(sys.modules, "launch_ros.actions", empty(Node=node))
    spec = importlib.util.spec_from_file_location("launched", FOLDER / "dsslam.launch.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    *arguments, (_, started) = module.generate_launch_description()
    assert [name for _, name in arguments] == ["params", "left", "right", "depth", "image"]
    program = pathlib.Path(started["executable"])
    assert program.is_file() and program.stat().st_mode & 0o111
    names = {"left/image", "right/image", "depth/image", "left/camera_info", "right/camera_info"}
    assert {name for name, _ in started["remappings"]} == names
