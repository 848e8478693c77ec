"""Track an OpenCV capture: a camera (its number) or a video file, with one camera.

    python 02_capture_loop.py 0 fx fy cx cy
    python 02_capture_loop.py video.mp4 fx fy cx cy

Ctrl-C ends the loop; the trajectory is written to capture.tum.txt.
"""

import sys
import time

import cv2

import dsslam

source = int(sys.argv[1]) if sys.argv[1].isdigit() else sys.argv[1]
fx, fy, cx, cy = map(float, sys.argv[2:6])
capture = cv2.VideoCapture(source)
if not capture.isOpened():
    sys.exit(f"{source}: cannot be opened")
width = int(capture.get(cv2.CAP_PROP_FRAME_WIDTH))
height = int(capture.get(cv2.CAP_PROP_FRAME_HEIGHT))
is_file = isinstance(source, str)

camera = dsslam.Camera.mono(fx, fy, cx, cy, width=width, height=height)
# OpenCV's images are BGR. A camera does not wait: with "realtime" frames are skipped rather than queued.
slam = dsslam.Slam(camera=camera, color="bgr", schedule=None if is_file else "realtime")
rate = capture.get(cv2.CAP_PROP_FPS) or 30.0
n = 0
try:
    while True:
        there, image = capture.read()
        if not there:
            break
        t_ns = round(n / rate * 1e9) if is_file else time.monotonic_ns()
        seen = slam.track(t_ns, image)
        n += 1
        print(f"{seen.index}: {seen.state} {seen.position if seen.is_tracked else seen.reason}")
except KeyboardInterrupt:
    pass
done = slam.finish()
done.save_trajectory("capture.tum.txt")
print(f"{done}; written: capture.tum.txt")
