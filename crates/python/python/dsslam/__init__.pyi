"""Types of the module dsslam. Images are arrays of shape (height, width) or (height, width, 3), uint8, of any stride."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypedDict

import numpy as np
from numpy.typing import NDArray

_Path = str | PathLike[str]
_Settings = Mapping[str, bool | int | float | str]
_Sensor = Literal["stereo", "rgbd", "mono"]
_Schedule = Literal["lockstep", "sequential", "live", "realtime"]
_Color = Literal["rgb", "bgr"]
_Image = NDArray[np.uint8]

__version__: str
PRESETS: list[str]
"""Names of the built-in configurations."""

class Error(RuntimeError):
    """What DSSLAM cannot use. The message says what was found and what was expected."""

class Camera:
    """Sensor, image size and calibration of the camera that images are pushed from. Lengths in pixels, baselines in meters."""

    @staticmethod
    def stereo(
        fx: float, fy: float, cx: float, cy: float, *, baseline: float, width: int, height: int
    ) -> Camera:
        """Two cameras whose images are rectified."""
    @staticmethod
    def rgbd(
        fx: float,
        fy: float,
        cx: float,
        cy: float,
        *,
        width: int,
        height: int,
        distortion: Sequence[float] = ...,
        baseline: float = 0.08,
    ) -> Camera:
        """A camera with registered depth. ``distortion``: k1, k2, p1, p2, k3."""
    @staticmethod
    def mono(
        fx: float, fy: float, cx: float, cy: float, *, width: int, height: int, distortion: Sequence[float] = ...
    ) -> Camera:
        """One camera; the unit of length of its map is free."""
    @staticmethod
    def from_file(file: _Path, sensor: _Sensor | None = None) -> Camera:
        """The cameras of a calibration file; raw images are rectified where that is needed."""
    @staticmethod
    def from_config(config: _Path, sensor: _Sensor, settings: _Settings | None = None) -> Camera:
        """The camera of a configuration's section ``camera``."""
    @staticmethod
    def of_dataset(
        folder: _Path,
        config: _Path | None = None,
        *,
        sensor: _Sensor | None = None,
        calibration: _Path | None = None,
        settings: _Settings | None = None,
    ) -> Camera:
        """The cameras of a dataset, so that its raw images can be pushed one by one."""
    @property
    def sensor(self) -> _Sensor: ...
    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""

class Result:
    """What tracking made of a frame. Later corrections of the map move its pose; `Finished` has the final ones."""

    t_ns: int
    index: int
    state: Literal["not_ready", "tracked", "lost", "dropped"]
    reason: str | None
    """Why the frame has no pose, in words."""
    is_tracked: bool
    pose: NDArray[np.float64] | None
    """``world_from_cam``, 4x4; meters."""
    position: NDArray[np.float64] | None
    """The camera's center in the world, meters."""
    quaternion: NDArray[np.float64] | None
    """Rotation ``world_from_cam`` as x, y, z, w."""
    motion: NDArray[np.float64] | None
    """Pose in the camera of the last frame that had one, 4x4: an odometry without the jumps of corrections."""
    covariance: NDArray[np.float64] | None
    """How far the pose may be off, seen from the camera 10 frames before (fewer after a start): 6x6, along and about the axes of the
    camera, translation first; m2, m rad, rad2. None without a pose, and for a frame that starts a map."""
    covariance_world: NDArray[np.float64] | None
    """The same along and about the axes of the world, as ROS has it."""
    quality: float
    """How far to trust the frame, from 0 (no pose) to 1."""
    quality_reasons: list[str]
    """What lowers the quality, the strongest first: few_inliers, badly_spread, large_covariance, mostly_far, large_residuals,
    just_relocalized, without_motion_model, turning_on_the_spot."""
    residual_px: float | None
    """Robust standard deviation of a residual, pixels at octave 0."""
    submap: int | None
    """The sub-map of the pose; poses of different sub-maps are in unrelated frames."""
    keyframe: bool
    keyframe_reason: str | None
    relocalized: bool
    inliers: int
    matches: int
    features: int
    with_depth: int
    n_keyframes: int
    n_points: int
    track_ms: float

class Map:
    """Keyframes, points and observations as arrays."""

    @staticmethod
    def load(file: _Path) -> Map: ...
    n_keyframes: int
    n_points: int
    points: NDArray[np.float64]
    """Positions, (N, 3), meters."""
    point_ids: NDArray[np.uint32]
    point_normals: NDArray[np.float64]
    """Mean viewing directions, (N, 3)."""
    activation: NDArray[np.float32]
    """How far the network trusts each point, (N,), 0 to 1."""
    descriptors: NDArray[np.uint8]
    """ORB descriptors, (N, 32)."""
    keyframe_ids: NDArray[np.uint32]
    keyframe_frames: NDArray[np.uint32]
    """Number of the frame that each keyframe was."""
    keyframe_times: NDArray[np.float64]
    """Seconds."""
    keyframe_poses: NDArray[np.float64]
    """``world_from_cam``, (K, 4, 4)."""
    keyframe_submaps: NDArray[np.uint32]
    @property
    def observations(self) -> _Observations: ...

class _Observations(TypedDict):
    point: NDArray[np.uint32]
    """Row of the point, (M,)."""
    keyframe: NDArray[np.uint32]
    """Row of the keyframe, (M,)."""
    pixel: NDArray[np.float32]
    """Undistorted pixel, (M, 2)."""
    right_column: NDArray[np.float32]
    """Column in the right image, (M,); NaN where unknown."""
    octave: NDArray[np.uint8]

class Finished:
    """Final poses, map and loops of a run."""

    n_frames: int
    n_tracked: int
    sensor: _Sensor
    interrupted: bool
    failure: str | None
    notices: list[str]
    """What to know of how the run was set up, such as which configuration was chosen."""
    frames: list[dict[str, Any]]
    """Per frame: index, time_s, t_ns, state, reason, inliers, submap, quality, quality_reasons, covariance and pose (None without one
    of its own)."""
    loops: list[dict[str, Any]]
    map: Map
    evaluation: dict[str, Any] | None
    """Errors against the ground truth of the dataset, as in evaluation.json."""

    def trajectory(self, *, body: bool = False) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Times (seconds) and poses ``world_from_cam`` (N, 4, 4) of the tracked frames; with ``body`` those of the body."""
    def save(self, file: _Path) -> str:
        """Write the map; return the SHA-256 of its file."""
    def save_mcap(self, file: _Path) -> None:
        """Write final poses and points as ROS 2 messages, for Foxglove and ROS 2."""
    def save_trajectory(
        self, file: _Path, format: Literal["tum", "kitti", "euroc"] = "tum", *, body: bool = False
    ) -> None: ...

class Slam:
    """SLAM on images that are pushed one frame after another. Safe to use from several threads, one call at a time."""

    def __init__(
        self,
        config: _Path | None = None,
        camera: Camera | None = None,
        *,
        settings: _Settings | None = None,
        map: _Path | None = None,
        localize: bool = False,
        vocabulary: _Path | None = None,
        network: _Path | None = None,
        schedule: _Schedule | None = None,
        color: _Color = "rgb",
    ) -> None:
        """``config``: a built-in configuration or a file; ``settings``: values over it, such as ``{"features.keep": 500}``.
        ``map``: a map to start with, with ``localize`` only to find the camera in. ``color``: order of color images."""
    def track(
        self,
        t_ns: int,
        left: _Image,
        right: _Image | None = None,
        depth: NDArray[np.uint16] | NDArray[np.float32] | None = None,
        mask: NDArray[np.uint8] | NDArray[np.bool_] | None = None,
    ) -> Result:
        """Take the images of the next frame. ``depth``: meters as floats, or uint16 in the configuration's units. No feature is taken
        where ``mask`` is 0."""
    def finish(self) -> Finished:
        """Let mapping finish and return the results; later calls return them again."""
    def save(self, file: _Path) -> str:
        """Finish and write the map; return the SHA-256 of its file."""
    def load(self, file: _Path) -> None:
        """Start again with the map of a file."""
    def localize(self, file: _Path) -> None:
        """Start again, only to find the camera in the map of a file."""
    def reset(self) -> None:
        """Forget everything and start again."""
    notices: list[str]
    config: str
    """The configuration in force as YAML."""
    is_finished: bool
    def __enter__(self) -> Slam: ...
    def __exit__(self, *args: object) -> None: ...

class World:
    """A rendered town: stereo images with depth, labels and true poses."""

    def __init__(
        self,
        preset: Literal["town", "quiet", "busy", "crossing", "facades"] = "town",
        *,
        seed: int = 1,
        rounds: int = 1,
        relit: bool = False,
    ) -> None: ...
    def __len__(self) -> int: ...
    @property
    def camera(self) -> Camera: ...
    def t_ns(self, i: int) -> int: ...
    def pose(self, i: int) -> NDArray[np.float64]: ...
    def images(self, i: int) -> tuple[_Image, _Image]: ...
    def frame(self, i: int) -> dict[str, Any]: ...

def run(
    path: _Path,
    config: _Path | None = None,
    *,
    settings: _Settings | None = None,
    sensor: _Sensor | None = None,
    calibration: _Path | None = None,
    ground_truth: _Path | None = None,
    topics: str | None = None,
    max_frames: int | None = None,
    map: _Path | None = None,
    localize: bool = False,
    vocabulary: _Path | None = None,
    network: _Path | None = None,
    schedule: _Schedule | None = None,
    observer: Callable[[str, Result | str], object] | None = None,
    mcap: _Path | None = None,
) -> Finished: ...
def evaluate(
    est: Finished | _Path | tuple[NDArray[np.float64], NDArray[np.float64]],
    gt: Finished | _Path | tuple[NDArray[np.float64], NDArray[np.float64]],
    *,
    alignment: Literal["se3", "sim3", "none"] = "se3",
    lengths_m: Sequence[float] | None = None,
) -> dict[str, Any]:
    """ATE, drift, RPE and coverage of ``est`` against ``gt``, as in evaluation.json."""

def activation(image: _Image, *, network: _Path | None = None, color: _Color = "rgb") -> NDArray[np.float32]:
    """How far the network trusts each place of an image, 0 to 1; coarser than the image."""

def render(
    preset: str = "town", *, seed: int = 1, rounds: int = 1, relit: bool = False, frames: int | None = None
) -> Iterator[dict[str, Any]]:
    """Yield the frames of a rendered town."""

def main() -> int: ...
