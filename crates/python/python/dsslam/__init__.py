"""Visual SLAM: push images, get poses and a map.

>>> import dsslam
>>> world = dsslam.World("town")
>>> slam = dsslam.Slam(camera=world.camera)
>>> for i in range(3):
...     left, right = world.images(i)
...     result = slam.track(world.t_ns(i), left, right)
>>> result.state, result.pose.shape
('tracked', (4, 4))
>>> times, poses = slam.finish().trajectory()
>>> poses.shape
(3, 4, 4)

Poses are ``world_from_cam``: 4x4 matrices that turn points of the left camera (x right, y down, z forward) into points of the world,
in meters; with one camera the unit of length is free. Times are whole nanoseconds. Equal frames, configuration and seed give equal
bits, those of the program ``dsslam``, except with the schedules ``live`` and ``realtime``.
"""

import importlib.util
import os
import pathlib
import re
import sys
import threading

from . import _dsslam
from ._dsslam import (
    PRESETS,
    Camera,
    Error,
    Finished,
    Map,
    Result,
    Slam,
    World,
    __version__,
    activation,
    evaluate,
)

__all__ = [
    "PRESETS",
    "Camera",
    "Error",
    "Finished",
    "Map",
    "Result",
    "Slam",
    "World",
    "__version__",
    "activation",
    "evaluate",
    "main",
    "render",
    "run",
]


def _onnxruntime():
    """The library in the package ``onnxruntime``, which need not be imported for that; None if it is missing or too old."""
    spec = importlib.util.find_spec("onnxruntime")
    for folder in (spec.submodule_search_locations or []) if spec else []:
        for file in sorted(pathlib.Path(folder, "capi").glob("libonnxruntime.so.*"), reverse=True):
            if tuple(int(part) for part in re.findall(r"\d+", file.name)[:2]) >= (1, 24):
                return str(file)
    return None


# A library that the environment names goes first.
if not os.environ.get("ORT_DYLIB_PATH"):
    _library = _onnxruntime()
    if _library:
        _dsslam.use_onnxruntime(_library)


def run(
    path,
    config=None,
    *,
    settings=None,
    sensor=None,
    calibration=None,
    ground_truth=None,
    topics=None,
    max_frames=None,
    map=None,
    localize=False,
    vocabulary=None,
    network=None,
    schedule=None,
    observer=None,
    mcap=None,
):
    """Run over a folder of images, a bag, a video or a camera, and return its results (`Finished`).

    Without ``config`` the built-in configuration that goes with the layout of the folder is taken. ``observer(kind, what)`` is called
    with ``("notice", text)`` for what to know before the run (later in `Finished.notices`), such as which configuration was chosen, with
    ``("frame", Result)`` for each frame, and with an event and its text for what else happens; what it raises ends the run.
    Ctrl-C ends the run; the results so far are returned with ``interrupted`` set. ``mcap`` names a file that poses, transforms, path and
    points are written into while the run goes on, for Foxglove and ROS 2.

    >>> import dsslam
    >>> dsslam.run("no such folder")
    Traceback (most recent call last):
    dsslam.Error: no such folder: no such folder
    """
    stop = _dsslam.Stop()
    ended = threading.Event()
    outcome = {}

    def work():
        try:
            outcome["finished"] = _dsslam.run(
                os.fspath(path),
                config,
                stop,
                settings=settings,
                sensor=sensor,
                calibration=calibration,
                ground_truth=ground_truth,
                topics=topics,
                max_frames=max_frames,
                map=map,
                localize=localize,
                vocabulary=vocabulary,
                network=network,
                schedule=schedule,
                observer=observer,
                mcap=mcap,
            )
        except BaseException as error:  # handed to the caller's thread
            outcome["error"] = error
        finally:
            ended.set()

    # The run is on another thread, so that this one can take Ctrl-C.
    threading.Thread(target=work, name="dsslam.run").start()
    while not ended.is_set():
        try:
            ended.wait(0.1)
        except KeyboardInterrupt:
            stop.set()
    if "error" in outcome:
        raise outcome["error"]
    return outcome["finished"]


def render(preset="town", *, seed=1, rounds=1, relit=False, frames=None):
    """Yield the frames of a rendered town: dicts of ``t_ns``, ``left``, ``right``, ``depth`` (meters), ``labels`` and ``pose``.

    >>> import dsslam
    >>> frame = next(dsslam.render("quiet"))
    >>> frame["left"].shape == frame["depth"].shape
    True
    """
    world = World(preset, seed=seed, rounds=rounds, relit=relit)
    for i in range(len(world) if frames is None else min(frames, len(world))):
        yield world.frame(i)


def main():
    """The program ``dsslam``."""
    library = None if os.environ.get("ORT_DYLIB_PATH") else _onnxruntime()
    if library:
        os.environ["ORT_DYLIB_PATH"] = library
    return _dsslam.main(["dsslam", *sys.argv[1:]])
