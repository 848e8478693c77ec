"""What the ROS 2 node does, without ROS: images are paired, tracked and turned into messages. `dsslam_node.py` is the shell around it."""

import collections
import dataclasses

import numpy as np

import dsslam

SECOND = 1_000_000_000

# From the axes of a camera (x right, y down, z forward) to those of a body (x forward, y left, z up), REP-103.
BODY_FROM_OPTICAL = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])


@dataclasses.dataclass
class Parameters:
    """The node's parameters with their defaults; names and values are those of `params.yaml`."""

    sensor: str = "stereo"  # stereo, rgbd or mono
    config: str = ""  # built-in configuration or file; empty: the default
    calibration: str = ""  # calibration file; empty: the camera_info topics
    rectified: bool = True  # whether the images are: then P of camera_info counts, else K and D
    sync_tolerance: float = 0.01  # how far the stamps of a pair may be apart, seconds
    queue_size: int = 10  # images that wait for their partners
    map_frame: str = "map"
    odom_frame: str = "odom"
    base_frame: str = "base_link"
    camera_frame: str = ""  # empty: the frame_id of the images
    publish_map_to_odom_tf: bool = True
    publish_odom_to_base_tf: bool = True
    path_every: int = 10  # the path is published with every n-th frame
    path_length: int = 2000  # poses that it keeps
    map_file: str = ""  # what the services save, load and localize in
    schedule: str = "live"  # lockstep waits for mapping and gives equal bits each time


def nanoseconds(stamp):
    return stamp.sec * SECOND + stamp.nanosec


class Pairs:
    """Brings two streams together by their stamps, each message used once, the nearest first, at most `tolerance_s` apart."""

    def __init__(self, tolerance_s, size):
        self.tolerance_ns = round(tolerance_s * SECOND)
        self.waiting = (collections.deque(maxlen=size), collections.deque(maxlen=size))
        self.n_alone = 0

    def add(self, side, t_ns, message):
        """Takes a message of stream 0 or 1; returns the pairs that are complete now."""
        queue = self.waiting[side]
        if queue and queue[-1][0] >= t_ns:
            return []  # repeated, or out of order
        self.n_alone += len(queue) == queue.maxlen
        queue.append((t_ns, message))
        found = []
        while all(self.waiting):
            (a, left), (b, right) = self.waiting[0][0], self.waiting[1][0]
            early = self.waiting[0] if a < b else self.waiting[1]
            other = max(a, b)
            # One that comes later in the same stream may be nearer.
            has_nearer = len(early) > 1 and abs(early[1][0] - other) < abs(a - b)
            if abs(a - b) > self.tolerance_ns or has_nearer:
                early.popleft()
                self.n_alone += 1
                continue
            self.waiting[0].popleft()
            self.waiting[1].popleft()
            found.append((a, left, right))
        return found


# Encodings of sensor_msgs/Image: numpy type, channels, whether blue comes first.
ENCODINGS = {
    "mono8": ("u1", 1, False),
    "8UC1": ("u1", 1, False),
    "mono16": ("u2", 1, False),
    "rgb8": ("u1", 3, False),
    "bgr8": ("u1", 3, True),
    "8UC3": ("u1", 3, True),
    "rgba8": ("u1", 4, False),
    "bgra8": ("u1", 4, True),
    "16UC1": ("u2", 1, False),
    "32FC1": ("f4", 1, False),
}


def array(message):
    """The pixels of a sensor_msgs/Image, without a copy where its rows allow it: (height, width) or (height, width, channels)."""
    if message.encoding not in ENCODINGS:
        raise ValueError(f"encoding: found {message.encoding!r}, expected one of {', '.join(ENCODINGS)}")
    kind, channels, _ = ENCODINGS[message.encoding]
    kind = np.dtype((">" if message.is_bigendian else "<") + kind)
    row = message.width * channels * kind.itemsize
    data = np.frombuffer(message.data, np.uint8)
    if message.step < row or len(data) < message.step * message.height:
        raise ValueError(
            f"image: found {len(data)} bytes with step {message.step}, expected {message.height} rows of at least {row} bytes"
        )
    rows = data[: message.step * message.height].reshape(message.height, message.step)[:, :row]
    pixels = np.ascontiguousarray(rows) if kind.itemsize > 1 else rows
    pixels = pixels.view(kind)
    return pixels if channels == 1 else pixels.reshape(message.height, message.width, channels)


def brightness_or_color(message):
    """The pixels of an image as `dsslam.Slam` takes them: uint8, gray or red first."""
    pixels = array(message)
    if pixels.dtype.itemsize == 2:
        return (pixels >> 8).astype(np.uint8)
    if pixels.dtype != np.uint8:
        raise ValueError(f"encoding: found {message.encoding!r} for an image, expected one of 8 or 16 bits")
    if pixels.ndim == 3:
        return pixels[:, :, 2::-1] if ENCODINGS[message.encoding][2] else pixels[:, :, :3]
    return pixels


def meters(message):
    """The depths of an image, meters; 0 where they are not known (16UC1 is in millimeters, REP-118)."""
    pixels = array(message)
    if message.encoding == "16UC1":
        return pixels.astype(np.float32) / np.float32(1000)
    if message.encoding == "32FC1":
        return np.nan_to_num(pixels.astype(np.float32), nan=0.0, posinf=0.0, neginf=0.0)
    raise ValueError(f"encoding: found {message.encoding!r} for depth, expected 16UC1 (millimeters) or 32FC1 (meters)")


def camera(parameters, left, right=None):
    """The camera of CameraInfo messages, or of the calibration file."""
    if parameters.calibration:
        return dsslam.Camera.from_file(parameters.calibration, parameters.sensor)
    size = {"width": left.width, "height": left.height}
    if parameters.sensor == "stereo":
        if not parameters.rectified:
            raise ValueError("rectified: found false with sensor stereo, expected rectified images or a calibration file")
        baseline = -right.p[3] / right.p[0]
        if not baseline > 0:
            raise ValueError(
                f"camera_info of the right camera: found the baseline {baseline:g} m in P, expected more than 0: "
                "left and right may be exchanged, or the pair is not calibrated"
            )
        return dsslam.Camera.stereo(left.p[0], left.p[5], left.p[2], left.p[6], baseline=baseline, **size)
    if parameters.rectified:
        intrinsics, lens = (left.p[0], left.p[5], left.p[2], left.p[6]), []
    else:
        if left.distortion_model not in ("", "plumb_bob") or len(left.d) > 5:
            raise ValueError(
                f"camera_info: found distortion_model {left.distortion_model!r} with {len(left.d)} coefficients, expected "
                "plumb_bob, rectified images or a calibration file"
            )
        intrinsics, lens = (left.k[0], left.k[4], left.k[2], left.k[5]), list(left.d)
    make = dsslam.Camera.rgbd if parameters.sensor == "rgbd" else dsslam.Camera.mono
    return make(*intrinsics, distortion=lens, **size)


def inverse(pose):
    turned = np.eye(4)
    turned[:3, :3] = pose[:3, :3].T
    turned[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return turned


def quaternion(rotation):
    """x, y, z, w of a rotation matrix; w is not negative."""
    # The largest of the four is found first, so that nothing small is divided by.
    r = rotation
    squares = np.array([1 + r[0, 0] - r[1, 1] - r[2, 2], 1 - r[0, 0] + r[1, 1] - r[2, 2], 1 - r[0, 0] - r[1, 1] + r[2, 2], 1 + np.trace(r)])
    i = int(np.argmax(squares))
    q = np.empty(4)
    q[i] = np.sqrt(squares[i]) / 2
    if i == 3:
        q[:3] = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / (4 * q[3])
    else:
        j, k = (i + 1) % 3, (i + 2) % 3
        q[j] = (r[j, i] + r[i, j]) / (4 * q[i])
        q[k] = (r[k, i] + r[i, k]) / (4 * q[i])
        q[3] = (r[k, j] - r[j, k]) / (4 * q[i])
    q /= np.linalg.norm(q)
    return -q if q[3] < 0 else q


@dataclasses.dataclass
class Located:
    """A frame with a pose, in the frames of the robot."""

    t_ns: int
    odom_from_base: np.ndarray
    map_from_odom: np.ndarray
    covariance: np.ndarray  # 6x6 along and about the axes of odom; zeros where it is not known
    velocity: np.ndarray  # of the base, along and about its axes: 3 linear, 3 angular

    @property
    def map_from_base(self):
        return self.map_from_odom @ self.odom_from_base


def moved(covariance, base_from_cam, odom_from_base):
    """A covariance along and about the axes of the camera, as that of the base along and about the axes of odom."""
    rotation, at = base_from_cam[:3, :3], base_from_cam[:3, 3]
    x, y, z = at
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    adjoint = np.zeros((6, 6))
    adjoint[:3, :3] = adjoint[3:, 3:] = rotation
    adjoint[:3, 3:] = cross @ rotation
    turn = np.kron(np.eye(2), odom_from_base[:3, :3]) @ adjoint
    return turn @ covariance @ turn.T


def rotation_vector(rotation):
    x, y, z, w = quaternion(rotation)
    length = np.linalg.norm([x, y, z])
    return np.array([x, y, z]) * (2 * np.arctan2(length, w) / length if length > 1e-12 else 2.0)


class Tracker:
    """SLAM between messages in and poses out. `base_from_camera(frame_id)` gives the camera's place on the robot, 4x4, or None."""

    def __init__(self, parameters, base_from_camera=lambda frame_id: None, say=lambda text: None):
        self.parameters, self.base_from_camera, self.say = parameters, base_from_camera, say
        self.pairs = Pairs(parameters.sync_tolerance, parameters.queue_size)
        self.infos, self.slam, self.base_from_cam, self.state = {}, None, None, None
        self.begin()

    def begin(self):
        """Where the robot is now becomes the origin of odom."""
        self.odom_from_base, self.last_ns, self.n_located, self.submap = np.eye(4), None, 0, None
        self.path = collections.deque(maxlen=self.parameters.path_length)

    def camera_info(self, side, message):
        """Takes the calibration of the left (or only) camera or of the right one."""
        self.infos[side] = message

    def image(self, side, message):
        """Takes an image: "left" (also the only one), "right" or "depth"; returns the frames that were located."""
        t_ns = nanoseconds(message.header.stamp)
        if self.parameters.sensor == "mono":
            return [found for found in [self.track(t_ns, message, None)] if found]
        found = self.pairs.add(int(side != "left"), t_ns, message)
        return [located for pair in found if (located := self.track(*pair))]

    def ready(self, message):
        """Whether the camera is known; the SLAM then begins."""
        if self.slam is None:
            needed = {"left", "right"} if self.parameters.sensor == "stereo" else {"left"}
            if not self.parameters.calibration and not needed <= self.infos.keys():
                return False
            seen = camera(self.parameters, self.infos.get("left"), self.infos.get("right"))
            # Depth comes in millimeters or as floats: millimeters reach 65 m.
            settings = {"camera.depth_units_per_metre": 1000.0} if self.parameters.sensor == "rgbd" else None
            self.slam = dsslam.Slam(self.parameters.config or None, seen, settings=settings, schedule=self.parameters.schedule)
        if self.base_from_cam is None:
            frame = self.parameters.camera_frame or message.header.frame_id
            placed = self.base_from_camera(frame)
            if placed is None:
                self.say(f"no transform from {frame} to {self.parameters.base_frame}: the camera is taken to look forward from its origin")
                placed = BODY_FROM_OPTICAL
            self.base_from_cam = placed
        return True

    def track(self, t_ns, left, second):
        if not self.ready(left):
            return None
        kind = {"stereo": "right", "rgbd": "depth"}.get(self.parameters.sensor)
        extra = {kind: brightness_or_color(second) if kind == "right" else meters(second)} if kind else {}
        result = self.slam.track(t_ns, brightness_or_color(left), **extra)
        if result.state != self.state:
            self.say(f"{result.state}: {result.reason}" if result.reason else result.state)
            self.state = result.state
        return self.located(result) if result.is_tracked else None

    def located(self, result):
        if None not in (self.submap, result.submap) and result.submap != self.submap:
            self.say(f"sub-map {result.submap}: its coordinates are unrelated to those before; the path begins anew")
            self.path.clear()
        self.submap = result.submap if result.submap is not None else self.submap
        base_from_cam = self.base_from_cam
        velocity = np.zeros(6)
        if result.motion is not None:
            motion = base_from_cam @ result.motion @ inverse(base_from_cam)
            self.odom_from_base = self.odom_from_base @ motion
            seconds = (result.t_ns - self.last_ns) / SECOND
            velocity[:3] = motion[:3, :3].T @ motion[:3, 3] / seconds
            velocity[3:] = rotation_vector(motion[:3, :3]) / seconds
        self.last_ns = result.t_ns
        # The world is the camera at the first frame, the map the base there.
        map_from_base = base_from_cam @ result.pose @ inverse(base_from_cam)
        covariance = getattr(result, "covariance", None)
        covariance = np.zeros((6, 6)) if covariance is None else moved(covariance, base_from_cam, self.odom_from_base)
        map_from_odom = map_from_base @ inverse(self.odom_from_base)
        found = Located(result.t_ns, self.odom_from_base.copy(), map_from_odom, covariance, velocity)
        self.path.append((found.t_ns, map_from_base))
        self.n_located += 1
        return found

    # What the services do; each returns what to answer, and raises what went wrong.

    def file(self):
        if not self.parameters.map_file:
            raise ValueError("map_file: found none, expected the file of a map")
        return self.parameters.map_file

    def running(self):
        if self.slam is None:
            raise RuntimeError("no image has been tracked yet")
        return self.slam

    def save_map(self):
        """Writes the map and goes on in it; the camera is found in it again."""
        file = self.file()
        self.running().save(file)
        self.slam.load(file)
        return f"{file}: written"

    def load_map(self):
        """Goes on in the map of the file and adds to it."""
        self.running().load(self.file())
        return f"{self.file()}: loaded"

    def localize(self):
        """Only finds the camera in the map of the file from now on."""
        self.running().localize(self.file())
        return f"{self.file()}: localizing in it"

    def reset(self):
        """Forgets everything."""
        self.running().reset()
        self.begin()
        return "reset"


# From poses to messages; `types` has the classes of the messages under their names.


def stamped(header, t_ns, frame):
    header.stamp.sec, header.stamp.nanosec = t_ns // SECOND, t_ns % SECOND
    header.frame_id = frame


def place(message, pose):
    """Fills a geometry_msgs/Pose."""
    message.position.x, message.position.y, message.position.z = (float(v) for v in pose[:3, 3])
    turn(message.orientation, pose)


def turn(message, pose):
    message.x, message.y, message.z, message.w = (float(v) for v in quaternion(pose[:3, :3]))


def odometry(types, parameters, located):
    message = types.Odometry()
    stamped(message.header, located.t_ns, parameters.odom_frame)
    message.child_frame_id = parameters.base_frame
    place(message.pose.pose, located.odom_from_base)
    message.pose.covariance = located.covariance.reshape(-1)
    twist = message.twist.twist
    twist.linear.x, twist.linear.y, twist.linear.z = (float(v) for v in located.velocity[:3])
    twist.angular.x, twist.angular.y, twist.angular.z = (float(v) for v in located.velocity[3:])
    return message


def transforms(types, parameters, located):
    """map -> odom and odom -> base, those that are to be published."""
    wanted = [
        (parameters.publish_map_to_odom_tf, parameters.map_frame, parameters.odom_frame, located.map_from_odom),
        (parameters.publish_odom_to_base_tf, parameters.odom_frame, parameters.base_frame, located.odom_from_base),
    ]
    messages = []
    for _, parent, child, pose in (link for link in wanted if link[0]):
        message = types.TransformStamped()
        stamped(message.header, located.t_ns, parent)
        message.child_frame_id = child
        at = message.transform.translation
        at.x, at.y, at.z = (float(v) for v in pose[:3, 3])
        turn(message.transform.rotation, pose)
        messages.append(message)
    return messages


def path(types, parameters, poses, t_ns):
    message = types.Path()
    stamped(message.header, t_ns, parameters.map_frame)
    for then_ns, pose in poses:
        one = types.PoseStamped()
        stamped(one.header, then_ns, parameters.map_frame)
        place(one.pose, pose)
        message.poses.append(one)
    return message
