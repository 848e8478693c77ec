"""Augmentation: a random window of a scene, stretched to the network's input, with changes of light, noise and blur.

The windows are chosen so that the scale and aspect of a KITTI frame at network size are covered, and so is a whole frame
of any aspect squeezed to the network's input, which is what the SLAM system feeds.
"""

import cv2
import numpy as np

from .data import IGNORED
from .network import HEIGHT, STRIDE, WIDTH


def window(rng: np.random.Generator, aspect: float, least: float = 0.55) -> tuple[float, float, float, float]:
    """Window (x, y, width, height) as shares of the frame; its true aspect lies between the frame's and KITTI's.

    It has at least the share `least` of the frame's width.

    Half of the windows have about the network's aspect (KITTI's), the others any between the frame's own and that.
    """
    target = WIDTH / HEIGHT
    if rng.random() < 0.5:
        shape = target * np.exp(rng.uniform(-0.18, 0.18))
    else:
        shape = np.exp(rng.uniform(np.log(min(aspect, target) * 0.9), np.log(target * 1.1)))
    width = rng.uniform(least, 1.0)
    height = min(1.0, width * aspect / shape)
    return rng.uniform(0, 1 - width), rng.uniform(0, 1 - height), width, height


def warp(image: np.ndarray, labels: np.ndarray, box: tuple, flip: bool) -> tuple[np.ndarray, np.ndarray]:
    """Cuts the window: image [H, W] uint8 -> [96, 320], labels (nearest neighbour) -> [48, 160]."""
    rows, cols = image.shape
    x, y, width, height = box[0] * cols, box[1] * rows, box[2] * cols, box[3] * rows

    def matrix(out_w: int, out_h: int) -> np.ndarray:
        sx, sy = width / out_w, height / out_h
        left, step = (x + width - 0.5 * sx - 0.5, -sx) if flip else (x + 0.5 * sx - 0.5, sx)
        return np.array([[step, 0, left], [0, sy, y + 0.5 * sy - 0.5]])

    if max(width / WIDTH, height / HEIGHT) > 1.0:
        blur = [max(0.01, 0.5 * np.sqrt(max(s * s - 1, 0))) for s in (width / WIDTH, height / HEIGHT)]
        image = cv2.GaussianBlur(image, (0, 0), blur[0], sigmaY=blur[1]) if max(blur) > 0.3 else image
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    out = cv2.warpAffine(image, matrix(WIDTH, HEIGHT), (WIDTH, HEIGHT), flags=flags, borderMode=cv2.BORDER_REFLECT)
    size = (WIDTH // STRIDE, HEIGHT // STRIDE)
    flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    return out, cv2.warpAffine(labels, matrix(*size), size, flags=flags, borderMode=cv2.BORDER_CONSTANT,
                               borderValue=IGNORED)


def light(rng: np.random.Generator, image: np.ndarray) -> np.ndarray:
    """Gamma, contrast, brightness, a gradient of light, blur and noise: uint8 [H, W] -> float32 [H, W] in 0..1."""
    out = image.astype(np.float32) / 255.0
    if rng.random() < 0.7:
        out = out ** np.float32(np.exp(rng.uniform(-0.6, 0.6)))
    if rng.random() < 0.7:
        out = (out - 0.5) * np.float32(rng.uniform(0.6, 1.4)) + np.float32(0.5 + rng.uniform(-0.15, 0.15))
    if rng.random() < 0.3:
        ramp = np.linspace(-1, 1, out.shape[1], dtype=np.float32)[None] * np.float32(rng.uniform(-0.3, 0.3))
        ramp = ramp + np.linspace(-1, 1, out.shape[0], dtype=np.float32)[:, None] * np.float32(rng.uniform(-0.3, 0.3))
        out = out * (1 + ramp)
    if rng.random() < 0.25:
        out = cv2.GaussianBlur(out, (0, 0), rng.uniform(0.4, 1.2))
    if rng.random() < 0.5:
        out = out + rng.standard_normal(out.shape, dtype=np.float32) * np.float32(rng.uniform(0.0, 0.05))
    return np.clip(out, 0.0, 1.0)


def sample(rng: np.random.Generator, image: np.ndarray, labels: np.ndarray, aspect: float) -> tuple[np.ndarray, np.ndarray]:
    """One training sample: image float32 [96, 320], stability map uint8 [48, 160]."""
    image, labels = warp(image, labels, window(rng, aspect), bool(rng.random() < 0.5))
    return light(rng, image), labels


def repaint(rng: np.random.Generator, image: np.ndarray, objects: np.ndarray) -> np.ndarray:
    """Gives each connected region of `objects` (bool [H, W]) another brightness and contrast, some are inverted.

    The paint and the lighting of a vehicle then say nothing about whether it moves. uint8 [H, W] -> uint8 [H, W].
    """
    count, regions = cv2.connectedComponents(objects.astype(np.uint8))
    gain = rng.uniform(0.5, 1.5, count) * np.where(rng.random(count) < 0.3, -1.0, 1.0)
    shift = rng.uniform(70.0, 180.0, count) - 127.0 * gain
    gain[0], shift[0] = 1.0, 0.0
    changed = image * gain.astype(np.float32)[regions] + shift.astype(np.float32)[regions]
    return np.clip(changed, 0.0, 255.0).astype(np.uint8)


def street_sample(
    rng: np.random.Generator, image: np.ndarray, labels: np.ndarray, objects: np.ndarray, aspect: float
) -> tuple[np.ndarray, np.ndarray]:
    """One sample of a frame with maps refined by motion: as `sample`, but never mirrored (the side of the road tells
    who drives), half of them nearly the whole frame, and half of them with repainted `objects`.
    """
    image = repaint(rng, image, objects) if rng.random() < 0.5 else image
    image, labels = warp(image, labels, window(rng, aspect, 0.55 if rng.random() < 0.5 else 0.9), False)
    return light(rng, image), labels


def whole(image: np.ndarray) -> np.ndarray:
    """The whole frame as the SLAM system feeds it: uint8 [H, W] -> float32 [96, 320] in 0..1."""
    shrink = image.shape[1] >= WIDTH and image.shape[0] >= HEIGHT
    image = cv2.resize(image, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA if shrink else cv2.INTER_LINEAR)
    return image.astype(np.float32) / 255.0
