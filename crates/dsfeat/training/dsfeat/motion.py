"""Motion labels without masks: which points of a stereo frame move, from residuals against the camera's own motion.

Corners are followed into the right image (depth) and over some frames; the camera's motion comes from RANSAC over the
points with equal votes for all parts of the image; a point whose later place and disparity are those of a static point
is labelled static, one that is clearly elsewhere moving, all others unknown. A static label is given only where a moving
vehicle would have been noticed. This is eq. 4's re-projection error with depth: the epipolar error of two views alone
cannot see a car that drives along our own direction, for it moves along the epipolar lines.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from .data import TOWN_MOVING, TOWN_PARKED

STATIC, MOVING, UNKNOWN = 1, 0, 2
#: Values of a refined stability map.
MOVED, STILL, IGNORED, STANDING = 0, 1, 2, 3
#: A pixel of a dynamic class follows a labelled point within this distance, pixels.
REACH_PX = 50.0
#: A region of a dynamic class is completed where this share of it is labelled and this share of that alike.
KNOWN, AGREED = 0.3, 0.97
#: Corners per frame.
CORNERS = 1400
#: Deviation of a tracked place, pixels.
SIGMA_PX = 0.4
#: Normalised residuals below the first are static, above the second moving; a mover has at least this many pixels.
STATIC_BELOW, MOVING_ABOVE, MOVING_PX = 2.5, 6.0, 3.0
#: A static label needs that a vehicle of this speed (m/s) would show a normalised residual of at least `NOTICED`.
SPEED, NOTICED = 5.0, 4.0
#: A car does not drive sideways: a camera motion with more is that of a vehicle across the view (metres, share of the way).
SIDEWAYS_M, SIDEWAYS_SHARE = 0.15, 0.3
#: Cells of the image that vote for the camera's motion, and the points of each: `FEW` where a vehicle leaves few cells.
CELLS, VOTES, FEW = (16, 6), 3, 12
#: With fewer voters than this every cell has `FEW` points.
ENOUGH = 60
#: The camera's motion comes from points off the vehicles if there are at least this many.
OFF_VEHICLES = 25


@dataclass
class Rig:
    """Rectified stereo camera: focal length, principal point (pixels), baseline (metres), seconds per frame."""

    focal: float
    centre: tuple[float, float]
    baseline: float
    interval: float = 0.1


def read_rig(calib: str) -> Rig:
    """Rig of a KITTI calibration text (lines P0 and P1)."""
    rows = {line.split(":")[0]: [float(x) for x in line.split(":")[1].split()] for line in calib.splitlines() if ":" in line}
    p0, p1 = rows["P0"], rows["P1"]
    return Rig(p0[0], (p0[2], p0[6]), -p1[3] / p1[0])


def follow(one: np.ndarray, two: np.ndarray, points: np.ndarray, guess: np.ndarray | None = None):
    """Lucas-Kanade there and back: points [N, 2] float32 in `two` and whether each came back to its place."""
    flags = cv2.OPTFLOW_USE_INITIAL_FLOW if guess is not None else 0
    start = None if guess is None else guess.copy()
    options = dict(winSize=(15, 15), maxLevel=4, criteria=(3, 20, 0.03))
    there, ok, _ = cv2.calcOpticalFlowPyrLK(one, two, points, start, flags=flags, **options)
    back, ok_back, _ = cv2.calcOpticalFlowPyrLK(two, one, there, points.copy(), flags=cv2.OPTFLOW_USE_INITIAL_FLOW, **options)
    good = (ok[:, 0] == 1) & (ok_back[:, 0] == 1) & (np.linalg.norm(back - points, axis=1) < 0.6)
    return there, good


def disparity(left: np.ndarray, right: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Disparity [N] of points of the left image and whether it is believable."""
    there, good = follow(left, right, points)
    d = points[:, 0] - there[:, 0]
    return d, good & (np.abs(there[:, 1] - points[:, 1]) < 1.0) & (d > 0.5)


def backproject(rig: Rig, points: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Points [N, 2] with disparities [N] -> [N, 3] metres in the camera."""
    z = rig.focal * rig.baseline / d
    return np.stack([(points[:, 0] - rig.centre[0]) * z / rig.focal, (points[:, 1] - rig.centre[1]) * z / rig.focal, z], 1)


def project(rig: Rig, xyz: np.ndarray) -> np.ndarray:
    """Points [N, 3] -> (u, v, disparity) [N, 3]."""
    z = np.maximum(xyz[:, 2], 0.1)
    return np.stack([
        rig.focal * xyz[:, 0] / z + rig.centre[0], rig.focal * xyz[:, 1] / z + rig.centre[1], rig.focal * rig.baseline / z,
    ], 1)


def camera_motion(rig: Rig, xyz: np.ndarray, before: np.ndarray, after: np.ndarray, size: tuple[int, int]):
    """Rotation [3, 3] and translation [3] of the later camera from the earlier one, or None.

    At most `VOTES` points of each cell of the image take part, so that one large vehicle cannot outvote the street.
    """
    cell = np.minimum((before / np.array(size) * np.array(CELLS)).astype(int), np.array(CELLS) - 1) @ np.array([1, CELLS[0]])
    order = np.argsort(cell, kind="stable")
    first = np.searchsorted(cell[order], cell[order])
    rank = np.arange(len(order)) - first
    voters = order[rank < VOTES]
    if len(voters) < ENOUGH:
        voters = order[rank < FEW]
    if len(voters) < 20:
        return None
    k = np.array([[rig.focal, 0, rig.centre[0]], [0, rig.focal, rig.centre[1]], [0, 0, 1]])
    cv2.setRNGSeed(1)
    ok, rotation, translation, inliers = cv2.solvePnPRansac(
        xyz[voters], after[voters].astype(np.float64), k, None, iterationsCount=400, reprojectionError=1.5, flags=cv2.SOLVEPNP_AP3P
    )
    if not ok or inliers is None or len(inliers) < max(15, 0.4 * len(voters)):
        return None
    chosen = voters[inliers[:, 0]]
    rotation, translation = cv2.solvePnPRefineLM(xyz[chosen], after[chosen].astype(np.float64), k, None, rotation, translation)
    if abs(translation[0, 0]) > SIDEWAYS_M + SIDEWAYS_SHARE * abs(translation[2, 0]):
        return None
    return cv2.Rodrigues(rotation)[0], translation[:, 0]


def classify(rig: Rig, pose, points: np.ndarray, d: np.ndarray, after: np.ndarray, d_after: np.ndarray, seconds: float) -> np.ndarray:
    """STATIC, MOVING or UNKNOWN [N] of tracked points: places and disparities before and after `seconds`."""
    rotation, translation = pose

    def later(places: np.ndarray, disparities: np.ndarray, step=(0.0, 0.0, 0.0)) -> np.ndarray:
        return project(rig, (backproject(rig, places, disparities) + np.array(step)) @ rotation.T + translation)

    expected = later(points, d)
    spread = 0.5 * np.abs(later(points, d + SIGMA_PX) - later(points, np.maximum(d - SIGMA_PX, 0.1)))
    sigma = np.sqrt(2 * SIGMA_PX**2 + spread**2)
    residual = np.column_stack([after, d_after]) - expected
    worst = (np.abs(residual) / sigma).max(axis=1)
    way = SPEED * seconds
    noticed = np.min([
        (np.abs(later(points, d, step) - expected) / sigma).max(axis=1)
        for step in ((way, 0, 0), (-way, 0, 0), (0, 0, way), (0, 0, -way))
    ], axis=0)
    labels = np.full(len(points), UNKNOWN, np.uint8)
    labels[(worst < STATIC_BELOW) & (noticed > NOTICED)] = STATIC
    labels[(worst > MOVING_ABOVE) & (np.abs(residual).max(axis=1) > MOVING_PX)] = MOVING
    return labels


def supported(points: np.ndarray, labels: np.ndarray, radius: float = 40.0) -> np.ndarray:
    """Labels without lonely movers: a mover needs two other movers within `radius`, more than static points there."""
    moving, static = points[labels == MOVING], points[labels == STATIC]
    out = labels.copy()
    for i in np.flatnonzero(labels == MOVING):
        near = (np.linalg.norm(moving - points[i], axis=1) < radius).sum() - 1
        against = (np.linalg.norm(static - points[i], axis=1) < radius).sum()
        if near < 2 or near < 0.7 * against:
            out[i] = UNKNOWN
    return out


def values_at(kinds: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Values of a map [H, W] at points [N, 2], pixels: [N]."""
    column, row = np.rint(points).astype(int).T
    return kinds[row.clip(0, kinds.shape[0] - 1), column.clip(0, kinds.shape[1] - 1)]


def completed(labels: np.ndarray) -> np.ndarray:
    """Map [H, W] in which the rest of a connected region of a dynamic class follows what is labelled of it.

    Only where at least `KNOWN` of the region is labelled and nearly all of that (`AGREED`) alike: smooth flanks of trucks,
    parts of parked cars that leave the view at once.
    """
    count, regions = cv2.connectedComponents((labels != STILL).astype(np.uint8))
    every, moved, standing = (
        np.bincount(regions[chosen], minlength=count) for chosen in (labels != STILL, labels == MOVED, labels == STANDING)
    )
    known = moved + standing
    table = np.full(count, IGNORED, np.uint8)
    enough = known >= KNOWN * np.maximum(every, 1)
    table[enough & (moved >= AGREED * known)] = MOVED
    table[enough & (standing >= AGREED * known)] = STANDING
    return np.where(labels == IGNORED, table[regions], labels).astype(np.uint8)


def exact(mask: np.ndarray) -> np.ndarray:
    """Refined stability map [H, W] of a rendered town's mask, in which nothing is ignored."""
    out = np.full(mask.shape, STILL, np.uint8)
    out[mask == TOWN_MOVING], out[mask == TOWN_PARKED] = MOVED, STANDING
    return out


def refined(kinds: np.ndarray, points: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """Stability map [H, W] of a semantic map `kinds` (0 dynamic class, 1 static) after the motion labels.

    Each pixel of a dynamic class follows the nearest labelled point on such a class within `REACH_PX`: MOVED where it
    moves, STANDING where it stands still, IGNORED where no point is near and `completed` finds nothing. All other pixels
    are STILL.
    """
    dynamic = kinds == 0
    on = (values_at(kinds, points) == 0) & (labels != UNKNOWN)
    out = np.where(dynamic, IGNORED, STILL).astype(np.uint8)
    if not on.any():
        return out
    column, row = np.rint(points).astype(int).T
    seeds = np.ones(kinds.shape, np.uint8)
    seeds[row[on], column[on]] = 0
    value = np.zeros(kinds.shape, np.uint8)
    value[row[on], column[on]] = np.where(labels[on] == MOVING, MOVED, STANDING)
    distance, index = cv2.distanceTransformWithLabels(seeds, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
    table = np.zeros(int(index.max()) + 1, np.uint8)
    table[index[seeds == 0]] = value[seeds == 0]
    near = dynamic & (distance < REACH_PX)
    out[near] = table[index[near]]
    return completed(out)


def corners_of(image: np.ndarray, kinds: np.ndarray | None) -> np.ndarray:
    """Corners [N, 2] of an image; with `kinds` (0 dynamic class) as many are looked for on those classes as elsewhere."""
    if kinds is None:
        found = [cv2.goodFeaturesToTrack(image, CORNERS, 0.004, 6)]
    else:
        on = cv2.erode((kinds == 0).astype(np.uint8), np.ones((3, 3), np.uint8))
        found = [
            cv2.goodFeaturesToTrack(image, CORNERS // 2, 0.004, 6, mask=(kinds != 0).astype(np.uint8)),
            cv2.goodFeaturesToTrack(image, CORNERS // 2, 0.002, 5, mask=on) if on.any() else None,
        ]
    return np.concatenate([np.zeros((0, 2), np.float32), *(f[:, 0] for f in found if f is not None)])


def judged(rig: Rig, tracks: np.ndarray, seconds: float, size: tuple[int, int], kinds: np.ndarray | None):
    """Labels tracks [N, 6] (place and disparity before and after): points [N, 2], labels [N], or None (see `label_frame`)."""
    if len(tracks) < 50:
        return None
    points, d, after, d_after = tracks[:, :2], tracks[:, 2], tracks[:, 3:5], tracks[:, 5]
    voters = np.arange(len(points))
    if kinds is not None:
        off = np.flatnonzero(values_at(kinds, points) != 0)
        voters = off if len(off) >= OFF_VEHICLES else voters
    pose = camera_motion(rig, backproject(rig, points[voters], d[voters]), points[voters], after[voters], size)
    if pose is None:
        return None
    return points, supported(points, classify(rig, pose, points, d, after, d_after, seconds))


def label_frame(rig: Rig, lefts: list[np.ndarray], rights: dict[int, np.ndarray], kinds: np.ndarray | None = None):
    """Labels the corners of the first left image by its motion: points [N, 2] pixels, labels [N].

    `rights` are the right images of the first frame and of those at which the motion is judged; a corner has a label for
    each of them. With `kinds` [H, W] (0 dynamic class) the camera's motion comes from the points off the dynamic classes, so
    that a truck may fill most of the view. None where the camera's motion cannot be found.
    """
    points = corners_of(lefts[0], kinds)
    if len(points) < 50:
        return None
    d, good = disparity(lefts[0], rights[0], points)
    start, after = np.column_stack([points, d])[good], points[good]
    size = (lefts[0].shape[1], lefts[0].shape[0])
    found = []
    for k in range(1, len(lefts)):
        if len(after) < 50:
            break
        after, good = follow(lefts[k - 1], lefts[k], after)
        start, after = start[good], after[good]
        if k in rights and len(after):
            d_after, good = disparity(lefts[k], rights[k], after)
            tracks = np.column_stack([start, after, d_after])[good]
            found.append(judged(rig, tracks, rig.interval * k, size, kinds))
    found = [f for f in found if f is not None]
    return tuple(np.concatenate(x) for x in zip(*found)) if found else None
