"""Matches between images: ORB with ratio test, fundamental matrix by RANSAC, epipolar errors (eq. 5 and 6)."""

from dataclasses import dataclass

import cv2
import numpy as np

#: ORB features per image, and Lowe's ratio for a match.
FEATURES, RATIO = 1000, 0.8
#: RANSAC's inlier threshold, pixels at the width that errors are scaled to.
INLIER_PX = 1.5
#: Errors are scaled to images of this width (KITTI's), cut at `LARGEST_PX` and divided by it: 0..1.
WIDTH_PX, LARGEST_PX = 1241.0, 10.0
#: Matches kept per pair.
KEPT = 192


@dataclass
class Features:
    """ORB key-points [N, 2] in pixels, descriptors [N, 32] uint8, and the image's (width, height)."""

    points: np.ndarray
    descriptors: np.ndarray
    size: tuple[int, int]


@dataclass
class Pair:
    """Matches of two images: points [M, 2] in each (pixels), two-sided epipolar errors [M] (scaled pixels, not cut)."""

    points_1: np.ndarray
    points_2: np.ndarray
    errors: np.ndarray

    @property
    def inliers(self) -> int:
        """Matches that obey the fundamental matrix."""
        return int((self.errors < INLIER_PX).sum())


def features(image: np.ndarray) -> Features:
    """ORB features of a grey image, at least 600 pixels wide for their sake."""
    height, width = image.shape
    scale = max(1.0, 640.0 / width)
    if scale > 1.0:
        image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_LINEAR)
    points, descriptors = cv2.ORB_create(FEATURES, 1.2, 8, fastThreshold=12).detectAndCompute(image, None)
    if descriptors is None:
        return Features(np.zeros((0, 2), np.float32), np.zeros((0, 32), np.uint8), (width, height))
    found = np.array([p.pt for p in points], np.float32)
    return Features((found + 0.5) / np.float32(scale) - 0.5, descriptors, (width, height))


def match(one: Features, two: Features) -> np.ndarray:
    """Mutual nearest neighbours that pass the ratio test, [M, 2] indices."""
    if len(one.points) < 2 or len(two.points) < 2:
        return np.zeros((0, 2), np.int64)
    matcher = cv2.BFMatcher(cv2.NORM_HAMMING)
    back = {m.queryIdx: m.trainIdx for m in matcher.match(two.descriptors, one.descriptors)}
    pairs = [
        (a.queryIdx, a.trainIdx)
        for a, b in matcher.knnMatch(one.descriptors, two.descriptors, k=2)
        if a.distance < RATIO * b.distance and back[a.trainIdx] == a.queryIdx
    ]
    return np.array(pairs, np.int64).reshape(-1, 2)


def epipolar_errors(f: np.ndarray, points_1: np.ndarray, points_2: np.ndarray) -> np.ndarray:
    """Mean of the distances of each point to the line of its partner, [M], pixels (eq. 6 both ways).

    The paper writes F^-1 for the way back; F has no inverse, the line in image 1 is that of F^T.
    """
    ones = np.ones((len(points_1), 1))
    a, b = np.hstack([points_1, ones]).astype(np.float64), np.hstack([points_2, ones]).astype(np.float64)
    forth, back = a @ f.T, b @ f
    product = np.abs(np.sum(forth * b, axis=1))
    return 0.5 * (product / np.linalg.norm(forth[:, :2], axis=1) + product / np.linalg.norm(back[:, :2], axis=1))


def pair(one: Features, two: Features) -> Pair:
    """Matches two images and measures the epipolar error of each match; fewer than 12 matches count as none."""
    indices = match(one, two)
    empty = np.zeros((0, 2), np.float32)
    if len(indices) < 12:
        return Pair(empty, empty, np.zeros(0, np.float32))
    a, b = one.points[indices[:, 0]], two.points[indices[:, 1]]
    scale = WIDTH_PX / one.size[0]
    cv2.setRNGSeed(1)
    f, _ = cv2.findFundamentalMat(a, b, cv2.FM_RANSAC, INLIER_PX / scale, 0.999, 1000)
    if f is None or f.shape != (3, 3):
        return Pair(empty, empty, np.zeros(0, np.float32))
    return Pair(a, b, (scale * epipolar_errors(f, a, b)).astype(np.float32))


def to_unit(points: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Pixels [..., 2] -> -1..1 from edge to edge of an image of `size` = (width, height)."""
    return ((2.0 * (points + 0.5)) / np.array(size, np.float32) - 1.0).astype(np.float32)


def packed(found: Pair, size_1: tuple[int, int], size_2: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Fixed-size arrays for training: points [KEPT, 4] in -1..1 (x1, y1, x2, y2), errors [KEPT] in 0..1, -1 if unused.

    Of more than KEPT matches evenly spread ones by error are taken.
    """
    order = np.argsort(found.errors, kind="stable")
    if len(order) > KEPT:
        order = order[np.linspace(0, len(order) - 1, KEPT).round().astype(int)]
    points, errors = np.zeros((KEPT, 4), np.float32), np.full(KEPT, -1.0, np.float32)
    points[: len(order), :2] = to_unit(found.points_1[order], size_1)
    points[: len(order), 2:] = to_unit(found.points_2[order], size_2)
    errors[: len(order)] = np.minimum(found.errors[order], LARGEST_PX) / LARGEST_PX
    return points, errors
