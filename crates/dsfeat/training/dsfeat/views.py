"""Views of labeled frames for the network with two answers: a window, a lens, a size, a light.

A view's window runs from a half of the frame to all of it, in nearly the frame's proportions; half of them see as much of the
frame as fits. The light goes from glaring sun with hard shade to night.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from .streets import MOVING, STANDING

#: How far a view's proportions may differ from the frame's: the logarithm of a factor.
STRETCH = 0.2
#: Maps have the image's size divided by this.
STRIDE = 2


@dataclass
class View:
    """`image` float32 [H, W] in 0..1, `codes` uint8 [H/2, W/2], `box` = (x, y, width, height) as shares of the frame."""

    image: np.ndarray
    codes: np.ndarray
    box: np.ndarray


def window(rng: np.random.Generator, aspect: float, least: float, shape: float) -> tuple[float, float, float, float]:
    """A window of a frame of `aspect` for a view of aspect `shape`, with at least the share `least` of the frame's width where
    the frame is high enough for that.
    """
    wide = rng.uniform(max(least, 0.88) if rng.random() < 0.5 else least, 1.0)
    shape *= np.exp(rng.uniform(-STRETCH, STRETCH))
    wide = min(wide, shape / aspect)
    height = min(1.0, wide * aspect / shape)
    return rng.uniform(0, 1 - wide), rng.uniform(0, 1 - height), wide, height


def grid(box: tuple[float, float, float, float], size: tuple[int, int], source: tuple[int, int], bend: float):
    """Where the pixels of a view of `size` = (rows, columns) lie in the source: x and y maps, float32.

    `bend` is the strength of a radial distortion about the view's middle.
    """
    rows, columns = size
    u = ((np.arange(columns, dtype=np.float32) + 0.5) / columns * 2 - 1)[None, :]
    v = ((np.arange(rows, dtype=np.float32) + 0.5) / rows * 2 - 1)[:, None]
    factor = 1 + bend * (u * u + v * v - 1)
    x = box[0] + box[2] * (0.5 + 0.5 * u * factor)
    y = box[1] + box[3] * (0.5 + 0.5 * v * factor)
    return (x * source[1] - 0.5).astype(np.float32), (y * source[0] - 0.5).astype(np.float32)


def smoothed(image: np.ndarray, shrink: tuple[float, float]) -> np.ndarray:
    """Blurs an image that is about to get smaller by these factors (x, y)."""
    x, y = (0.45 * np.sqrt(max(s * s - 1, 0)) for s in shrink)
    return cv2.GaussianBlur(image, (0, 0), max(x, 0.05), sigmaY=max(y, 0.05)) if max(x, y) > 0.3 else image


def curve(rng: np.random.Generator, out: np.ndarray) -> np.ndarray:
    """Exposure, contrast and gamma; a few are night (dark and noisy), a few are burnt out."""
    kind = rng.random()
    if kind < 0.08:
        out = np.clip(out, 0, 1) ** np.float32(rng.uniform(1.5, 2.6)) * np.float32(rng.uniform(0.3, 0.8))
        return out + rng.standard_normal(out.shape, dtype=np.float32) * np.float32(rng.uniform(0.01, 0.05))
    if kind < 0.16:
        return out * np.float32(rng.uniform(1.3, 2.2))
    out = out ** np.float32(np.exp(rng.uniform(-0.6, 0.6)))
    return (out - 0.5) * np.float32(rng.uniform(0.65, 1.4)) + np.float32(0.5 + rng.uniform(-0.15, 0.15))


def shade(rng: np.random.Generator, out: np.ndarray) -> np.ndarray:
    """One to three shadows or sunny patches with edges like those of houses and trees."""
    rows, columns = out.shape
    mask = np.zeros(out.shape, np.float32)
    for _ in range(rng.integers(1, 4)):
        middle = rng.uniform((0, 0.2), (1, 1)) * (columns, rows)
        angle = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(3, 8)))
        reach = rng.uniform(0.1, 0.9, len(angle))[:, None] * (0.5 * columns, 0.7 * rows)
        points = middle + reach * np.stack([np.cos(angle), np.sin(angle)], 1)
        cv2.fillPoly(mask, [points.astype(np.int32)], 1.0)
    if rng.random() < 0.5:
        mask = cv2.GaussianBlur(mask, (0, 0), rng.uniform(0.5, 4.0))
    return out * (1 + mask * np.float32(rng.uniform(-0.7, -0.2) if rng.random() < 0.6 else rng.uniform(0.3, 1.2)))


def glare(rng: np.random.Generator, out: np.ndarray) -> np.ndarray:
    """Light that falls into the lens: a bright veil about one point."""
    rows, columns = out.shape
    x = (np.arange(columns, dtype=np.float32) - rng.uniform(0, columns))[None] / columns
    y = (np.arange(rows, dtype=np.float32) - rng.uniform(-0.2, 0.6) * rows)[:, None] / columns
    veil = np.exp(-(x * x + y * y) / np.float32(2 * rng.uniform(0.04, 0.3) ** 2))
    return out + veil * np.float32(rng.uniform(0.2, 0.9)) * (1 - np.clip(out, 0, 1))


def light(rng: np.random.Generator, image: np.ndarray) -> np.ndarray:
    """Another light: uint8 [H, W] -> float32 [H, W] in 0..1."""
    out = image.astype(np.float32) / 255.0
    if rng.random() < 0.8:
        out = curve(rng, out)
    if rng.random() < 0.3:
        out = shade(rng, out)
    if rng.random() < 0.1:
        out = glare(rng, out)
    if rng.random() < 0.25:
        out = cv2.GaussianBlur(out, (0, 0), rng.uniform(0.4, 1.1))
    if rng.random() < 0.4:
        out = out + rng.standard_normal(out.shape, dtype=np.float32) * np.float32(rng.uniform(0.0, 0.04))
    return np.clip(out, 0.0, 1.0)


def repainted(rng: np.random.Generator, image: np.ndarray, codes: np.ndarray) -> np.ndarray:
    """A rendered frame (uint8) whose vehicles have another paint: contrast and brightness of each connected region change."""
    count, found = cv2.connectedComponents(np.isin(codes, (STANDING, MOVING)).astype(np.uint8), connectivity=4)
    mean = np.bincount(found.ravel(), image.ravel(), count) / np.maximum(np.bincount(found.ravel(), minlength=count), 1)
    contrast, bright = rng.choice((1.0, 1.0, -1.0), count) * rng.uniform(0.3, 1.5, count), rng.uniform(-60, 60, count)
    contrast[0], bright[0] = 1.0, 0.0
    other = (image - mean[found]) * contrast[found] + mean[found] + bright[found]
    return np.clip(np.rint(other), 0, 255).astype(np.uint8)


def view(
    rng: np.random.Generator, image: np.ndarray, codes: np.ndarray, aspect: float, size: tuple[int, int], least: float, mirror: bool
) -> View:
    """One view of `size` = (rows, columns) of a frame (uint8) and its codes (0: ignored)."""
    x, y, wide, high = box = window(rng, aspect, least, size[1] / size[0])
    bend = rng.uniform(-0.06, 0.06) if rng.random() < 0.3 else 0.0
    flip = mirror and rng.random() < 0.5
    if flip:
        image, codes = np.ascontiguousarray(image[:, ::-1]), np.ascontiguousarray(codes[:, ::-1])
    shrink = (wide * image.shape[1] / size[1], high * image.shape[0] / size[0])
    shown = cv2.remap(smoothed(image, shrink), *grid(box, size, image.shape, bend), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    half = (size[0] // STRIDE, size[1] // STRIDE)
    found = cv2.remap(codes, *grid(box, half, codes.shape, bend), cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT, borderValue=0)
    return View(light(rng, shown), found, np.array(box, np.float32))


def whole(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """The whole frame as the program feeds it: uint8 [H, W] -> float32 of `size` in 0..1."""
    shrinks = image.shape[0] >= size[0] and image.shape[1] >= size[1]
    method = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    return cv2.resize(image, size[::-1], interpolation=method).astype(np.float32) / 255.0
