"""Wrong arguments are refused by name, with what was found and what was expected."""

import numpy as np
import pytest
from conftest import SETTINGS

import dsslam

GRAY = np.zeros((376, 1241), np.uint8)
PINHOLE = (700.0, 700.0, 600.0, 180.0)
SIZE = {"width": 1241, "height": 376}

CAMERAS = [
    (lambda: dsslam.Camera.stereo(0.0, 1, 1, 1, baseline=1, **SIZE), ValueError, "fx: found 0, expected pixels above 0"),
    (lambda: dsslam.Camera.mono(1, -2, 1, 1, **SIZE), ValueError, "fy: found -2, expected pixels above 0"),
    (lambda: dsslam.Camera.mono(1, 2, float("nan"), 1, **SIZE), ValueError, "cx: found NaN, expected pixels"),
    (
        lambda: dsslam.Camera.stereo(*PINHOLE, baseline=0, **SIZE),
        ValueError,
        "baseline: found 0, expected meters above 0",
    ),
    (
        lambda: dsslam.Camera.mono(*PINHOLE, width=0, height=4),
        ValueError,
        "size: found 0 x 4 pixels, expected some",
    ),
    (
        lambda: dsslam.Camera.mono(*PINHOLE, **SIZE, distortion=[0.0] * 6),
        ValueError,
        "distortion: found 6 values, expected at most 5 finite ones: k1, k2, p1, p2, k3",
    ),
    (
        lambda: dsslam.Camera.from_file("x.yaml", "lidar"),
        ValueError,
        'sensor: found "lidar", expected "stereo", "rgbd" or "mono"',
    ),
]

SLAMS = [
    (
        lambda: dsslam.Slam("kitti"),
        TypeError,
        'camera: found none, expected a dsslam.Camera, such as Camera.from_file("cameras.yaml")',
    ),
    (
        lambda: dsslam.Slam(camera=camera(), schedule="fast"),
        ValueError,
        'schedule: found "fast", expected "lockstep", "sequential", "live" or "realtime"',
    ),
    (lambda: dsslam.Slam(camera=camera(), color="hsv"), ValueError, 'color: found "hsv", expected "rgb" or "bgr"'),
    (
        lambda: dsslam.Slam(camera=camera(), localize=True),
        ValueError,
        "localize: found no map, expected one to localize in",
    ),
    (lambda: dsslam.World("village"), ValueError, None),
    (lambda: dsslam.World("town").images(10**6), IndexError, None),
    (lambda: dsslam.World(rounds=0), ValueError, "rounds: found 0, expected at least 1"),
    (lambda: dsslam.evaluate(3, "x"), TypeError, None),
    (
        lambda: dsslam.evaluate((np.zeros(1), np.zeros((1, 2, 4))), "x"),
        ValueError,
        "est: found shape [1, 2, 4], expected (N, 4, 4)",
    ),
    (
        lambda: dsslam.evaluate((np.zeros(2), np.eye(4)[None]), "x"),
        ValueError,
        "est: found 2 times and 1 poses, expected as many of both, sorted by time",
    ),
]

FRAMES = [
    (lambda s: s.track(0, [1, 2], GRAY), TypeError, "left: found list, expected a numpy array of uint8"),
    (
        lambda s: s.track(0, GRAY.astype(np.float32), GRAY),
        TypeError,
        "left: found dtype float32, expected a numpy array of uint8",
    ),
    (
        lambda s: s.track(0, GRAY, GRAY.astype(np.uint16)),
        TypeError,
        "right: found dtype uint16, expected a numpy array of uint8",
    ),
    (
        lambda s: s.track(0, np.zeros((3, 4, 2), np.uint8), GRAY),
        ValueError,
        "left: found shape [3, 4, 2], expected (height, width) or (height, width, 3)",
    ),
    (
        lambda s: s.track(0, GRAY, GRAY, depth=np.zeros((1, 2, 3), np.uint16)),
        ValueError,
        "depth: found shape [1, 2, 3], expected (height, width)",
    ),
    (
        lambda s: s.track(0, GRAY, GRAY, depth=np.zeros((1, 2), np.int32)),
        TypeError,
        "depth: found dtype int32, expected uint16 or float32",
    ),
    (
        lambda s: s.track(0, GRAY, GRAY, mask=np.zeros((376, 1241, 3), np.uint8)),
        ValueError,
        "mask: found shape [376, 1241, 3], expected (height, width)",
    ),
    (
        lambda s: s.track(0, GRAY),
        dsslam.Error,
        "the frame at 0 ns: found no right image, expected one with sensor stereo",
    ),
    (
        lambda s: s.track(0, GRAY[:100], GRAY),
        dsslam.Error,
        "the frame at 0 ns: found 1241x100 pixels in the left image, expected 1241x376 as the camera has",
    ),
    (
        lambda s: s.track(0, GRAY, GRAY, depth=np.zeros((376, 1241), np.uint16)),
        dsslam.Error,
        "the frame at 0 ns: found a depth image, expected none with sensor stereo",
    ),
    (
        lambda s: (s.track(5, GRAY, GRAY), s.track(5, GRAY, GRAY)),
        dsslam.Error,
        "the frame at 5 ns: expected a time after that of the last frame, 5 ns",
    ),
    (lambda s: s.track("now", GRAY, GRAY), TypeError, None),
    (lambda s: s.track(0.5, GRAY, GRAY), TypeError, None),
]


def camera():
    return dsslam.Camera.stereo(*PINHOLE, baseline=0.5, **SIZE)


@pytest.mark.parametrize("call, kind, message", CAMERAS + SLAMS)
def test_wrong_arguments(call, kind, message):
    with pytest.raises(kind) as raised:
        call()
    assert message is None or str(raised.value) == message


@pytest.mark.parametrize("call, kind, message", FRAMES)
def test_wrong_frames_and_the_next_one_may_come(call, kind, message):
    slam = dsslam.Slam(camera=camera(), settings=SETTINGS)
    with pytest.raises(kind) as raised:
        call(slam)
    assert message is None or str(raised.value) == message
    assert slam.track(10, GRAY, GRAY).state == "not_ready"


def test_files_are_named(tmp_path):
    missing = tmp_path / "missing"
    for call in [
        lambda: dsslam.run(missing),
        lambda: dsslam.Map.load(missing),
        lambda: dsslam.Camera.from_file(missing),
        lambda: dsslam.Slam(camera=camera(), map=missing),
        lambda: dsslam.Slam(camera=camera(), vocabulary=missing),
        lambda: dsslam.evaluate(missing, missing),
    ]:
        with pytest.raises(dsslam.Error) as raised:
            call()
        assert str(missing) in str(raised.value)


def test_a_wrong_setting_names_its_key_and_the_nearest_one():
    with pytest.raises(dsslam.Error) as raised:
        dsslam.Slam(camera=camera(), settings={"features.kep": 500})
    assert "features.kep" in str(raised.value) and "features.keep" in str(raised.value)
