"""Batches for the matching loss: triplets with dense descriptors and matches, frames with motion labels."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from .augment import warp, window

#: Files that `dsfeat.prepare` writes into the cache.
TRIPLETS, MOTION = "triplets.npz", "motion.npz"
#: Weight of a moving point against a static one in the motion loss.
MOVING_WEIGHT = 3.0


@dataclass
class Matches:
    """Matches of image pairs: points [B, N, 2] in -1..1 in each, errors [B, N] in 0..1, `valid` [B, N]."""

    points_1: torch.Tensor
    points_2: torch.Tensor
    errors: torch.Tensor
    valid: torch.Tensor


@dataclass
class TripletBatch:
    """Images [B, 3, 96, 320] uint8 (query, positive, negative), descriptors [B, 3, C, h, w], matches of q-p and q-n."""

    images: np.ndarray
    descriptors: np.ndarray
    positive: Matches
    negative: Matches


@dataclass
class MotionBatch:
    """Images [B, 96, 320] uint8, points [B, N, 2] in -1..1, targets and weights [B, N] (0 outside the window)."""

    images: np.ndarray
    points: torch.Tensor
    targets: torch.Tensor
    weights: torch.Tensor


def mirrored(points: np.ndarray, flip: bool) -> np.ndarray:
    """Points [..., 2k] in -1..1 with x negated where the images are mirrored."""
    if not flip:
        return points
    out = points.copy()
    out[..., ::2] *= -1.0
    return out


def windowed(rng: np.random.Generator, image: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A random, perhaps mirrored window of a frame [H, W] at the network's size, and the points [N, 2] in it (-1..1 inside)."""
    box = window(rng, image.shape[1] / image.shape[0])
    flip = bool(rng.random() < 0.5)
    shown = warp(image, np.zeros((1, 1), np.uint8), box, flip)[0]
    x, y, width, height = box
    share = 0.5 * (points + 1.0)
    placed = 2.0 * (share - np.array([x, y], np.float32)) / np.array([width, height], np.float32) - 1.0
    return shown, mirrored(placed.astype(np.float32), flip)


class Matching:
    """The prepared triplets and motion labels, drawn at random.

    Triplets are mirrored at random but never cropped, for their descriptors are those of the whole frame.

    `triplets`: images [N, 96, 320] uint8, descriptors [N, h, w, C] float16, index [T, 3], points [T, 2, K, 4],
    errors [T, 2, K] (-1 unused), source [T]. `frames`: images [N, H, W] uint8, points [N, M, 2] in -1..1,
    labels [N, M] (0 moving, 1 static, 2 unknown or unused).
    """

    def __init__(self, triplets: dict[str, np.ndarray], frames: dict[str, np.ndarray]):
        self.triplets = triplets
        self.frames = frames
        sources = triplets["source"]
        self.by_source = [np.flatnonzero(sources == s) for s in np.unique(sources)]
        moving = (frames["labels"] == 0).sum(axis=1)
        # Frames without movers teach that parked cars are static; those with movers are drawn as often.
        self.by_traffic = [x for x in (np.flatnonzero(moving >= 5), np.flatnonzero(moving < 5)) if len(x)]

    @classmethod
    def load(cls, cache: Path) -> "Matching":
        """Reads what `dsfeat.prepare` wrote."""
        for name in (TRIPLETS, MOTION):
            if not (cache / name).is_file():
                raise SystemExit(f"{cache / name}: not there; run `python -m dsfeat.prepare` first")
        with np.load(cache / TRIPLETS) as file:
            triplets = {k: file[k] for k in file.files}
        with np.load(cache / MOTION) as file:
            return cls(triplets, {k: file[k] for k in file.files})

    def triplet_batch(self, rng: np.random.Generator, size: int) -> TripletBatch:
        """`size` triplets, each source of triplets equally often."""
        rows = [(g := self.by_source[rng.integers(len(self.by_source))])[rng.integers(len(g))] for _ in range(size)]
        flips = rng.random(size) < 0.5
        index = self.triplets["index"][rows]
        images = self.triplets["images"][index]
        descriptors = self.triplets["descriptors"][index].astype(np.float32).transpose(0, 1, 4, 2, 3)
        images = np.stack([x[..., ::-1] if f else x for x, f in zip(images, flips)])
        descriptors = np.stack([x[..., ::-1] if f else x for x, f in zip(descriptors, flips)])
        points = np.stack([mirrored(x, f) for x, f in zip(self.triplets["points"][rows], flips)])
        errors = torch.from_numpy(self.triplets["errors"][rows])
        points = torch.from_numpy(points)
        pairs = [
            Matches(points[:, k, :, :2], points[:, k, :, 2:], errors[:, k].clamp(min=0.0), errors[:, k] >= 0.0)
            for k in (0, 1)
        ]
        return TripletBatch(images, descriptors, *pairs)

    def motion_batch(self, rng: np.random.Generator, size: int) -> MotionBatch:
        """`size` frames with motion labels, with and without movers in turn."""
        groups = self.by_traffic
        rows = [(g := groups[i % len(groups)])[rng.integers(len(g))] for i in range(size)]
        shown = [windowed(rng, self.frames["images"][i], self.frames["points"][i]) for i in rows]
        points = np.stack([x[1] for x in shown])
        labels = torch.from_numpy(self.frames["labels"][rows])
        inside = torch.from_numpy(np.abs(points).max(axis=2) < 1.0)
        weights = torch.where(labels == 0, MOVING_WEIGHT, 1.0) * ((labels != 2) & inside)
        return MotionBatch(np.stack([x[0] for x in shown]), torch.from_numpy(points), (labels == 1).float(), weights)
