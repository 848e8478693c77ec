"""Batches for the matching loss: triplets with dense descriptors and matches, frames with maps refined by motion."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from .augment import street_sample
from .motion import MOVED, STILL

#: Files that `dsfeat.prepare` writes into the cache.
TRIPLETS, MOTION, VEHICLES = "triplets.npz", "motion.npz", "vehicles.npz"


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
    """Images [B, 96, 320] float32, maps refined by motion [B, 48, 160] (values of `dsfeat.motion`)."""

    images: np.ndarray
    maps: torch.Tensor


def arrays(path: Path) -> dict[str, np.ndarray]:
    """All arrays of a file that `dsfeat.prepare` wrote."""
    if not path.is_file():
        raise SystemExit(f"{path}: not there; run `python -m dsfeat.prepare` first")
    with np.load(path) as file:
        return {k: file[k] for k in file.files}


def mirrored(points: np.ndarray, flip: bool) -> np.ndarray:
    """Points [..., 2k] in -1..1 with x negated where the images are mirrored."""
    if not flip:
        return points
    out = points.copy()
    out[..., ::2] *= -1.0
    return out


class Triplets:
    """The prepared triplets, drawn at random.

    Triplets are mirrored at random but never cropped, for their descriptors are those of the whole frame.

    `triplets`: images [N, 96, 320] uint8, descriptors [N, h, w, C] float16, index [T, 3], points [T, 2, K, 4],
    errors [T, 2, K] (-1 unused), source [T].
    """

    def __init__(self, triplets: dict[str, np.ndarray]):
        self.triplets = triplets
        sources = triplets["source"]
        self.by_source = [np.flatnonzero(sources == s) for s in np.unique(sources)]

    @classmethod
    def load(cls, cache: Path) -> "Triplets":
        """Reads what `dsfeat.prepare triplets` wrote."""
        return cls(arrays(cache / TRIPLETS))

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


class Matching(Triplets):
    """The prepared triplets and motion labels. `frames`: images and maps [N, H, W] uint8."""

    def __init__(self, triplets: dict[str, np.ndarray], frames: dict[str, np.ndarray]):
        super().__init__(triplets)
        self.frames = frames
        moving = (frames["maps"] == MOVED).mean(axis=(1, 2))
        # Frames without movers teach that parked cars are static; those with movers are drawn as often.
        self.by_traffic = [x for x in (np.flatnonzero(moving >= 0.002), np.flatnonzero(moving < 0.002)) if len(x)]

    @classmethod
    def load(cls, cache: Path) -> "Matching":
        """Reads what `dsfeat.prepare` wrote."""
        return cls(arrays(cache / TRIPLETS), arrays(cache / MOTION))

    def motion_batch(self, rng: np.random.Generator, size: int) -> MotionBatch:
        """`size` augmented frames with refined maps, with and without movers in turn."""
        groups = self.by_traffic
        rows = [(g := groups[i % len(groups)])[rng.integers(len(g))] for i in range(size)]
        images, maps = self.frames["images"], self.frames["maps"]
        aspect = images.shape[2] / images.shape[1]
        found = [street_sample(rng, images[i], maps[i], maps[i] != STILL, aspect) for i in rows]
        return MotionBatch(np.stack([x[0] for x in found]), torch.from_numpy(np.stack([x[1] for x in found])))
