"""Trains the activation network.

    python -m dsfeat.train --config configs/hybrid.json --out runs/hybrid --cache CACHE

Each epoch ends with a checkpoint (`last.pt`); a stopped run continues from it with the same result, for every random
number comes from (seed, epoch, step). `log.csv` holds the losses, `curves.png` the training curves.
"""

import argparse
import csv
import os
import time
from pathlib import Path

import numpy as np
import torch

from . import losses
from .augment import light, sample
from .config import Config, read, trial
from .curves import plot
from .data import Scenes, add_folders, load, need
from .evaluate import quick
from .network import DSFeat
from .triplets import Matching, TripletBatch

COLUMNS = ["epoch", "rate", "weight_semantic", "loss", "semantic", "dense", "sparse", "motion", "seconds"]


def watched_towns(cache: Path) -> list[str]:
    """Rendered towns in the cache by which settings are chosen: seeds 900 to 909; later ones are for the last figures."""
    return sorted(p.stem for p in cache.glob("town_*_90?.npz"))


class Labelled:
    """Draws batches of augmented labelled images from several data sets in fixed shares."""

    def __init__(self, sets: dict[str, list[Scenes]], mix: dict[str, float]):
        self.sets = sets
        self.names = list(mix)
        shares = np.array([mix[n] for n in self.names])
        self.edges = np.cumsum(shares / shares.sum())

    def batch(self, key: tuple[int, ...], size: int) -> tuple[torch.Tensor, torch.Tensor]:
        """Images [size, 1, 96, 320] and maps [size, 48, 160]; which ones depends on `key` only."""
        rng = np.random.default_rng(key)
        # Evenly spread positions keep the shares in each batch as near to the mix as its size allows.
        places = (rng.random() + np.arange(size)) / size
        images, maps = [], []
        for place in places:
            scenes = self.sets[self.names[min(int(np.searchsorted(self.edges, place)), len(self.names) - 1)]]
            one = scenes[rng.integers(len(scenes))]
            i = rng.integers(len(one))
            image, labels = sample(rng, one.images[i], one.maps[i], one.aspect)
            images.append(image)
            maps.append(labels)
        return torch.from_numpy(np.stack(images))[:, None], torch.from_numpy(np.stack(maps))


def triplet_losses(maps: torch.Tensor, batch: TripletBatch, config: Config) -> tuple[torch.Tensor, torch.Tensor]:
    """Dense and sparse triplet loss (eq. 2 with eq. 3 and with eq. 4); `maps` are the activations [B, 3, 1, 48, 160]."""
    q, p, n = maps[:, 0], maps[:, 1], maps[:, 2]
    d = torch.from_numpy(batch.descriptors)
    dense = losses.triplet(
        losses.dense_distance(q, d[:, 0], p, d[:, 1]), losses.dense_distance(q, d[:, 0], n, d[:, 2]), config.margin_dense
    )
    pos, neg = batch.positive, batch.negative
    sparse = losses.triplet(
        losses.sparse_distance(q, pos.points_1, p, pos.points_2, pos.errors, pos.valid),
        losses.sparse_distance(q, neg.points_1, n, neg.points_2, neg.errors, neg.valid),
        config.margin_sparse,
    )
    return dense, sparse


def matching_losses(network: DSFeat, matching: Matching, config: Config, key: tuple[int, ...], extra: torch.Tensor):
    """Parts of the matching loss of one step, and the logits of the labelled images `extra` [B, 1, 96, 320].

    All images of the step pass the network together. Returns (logits of extra, dense, sparse, motion).
    """
    rng = np.random.default_rng(key)
    count = config.triplets if key[2] % config.triplet_every == 0 else 0
    frames = matching.motion_batch(rng, config.motion_frames)
    shown = [extra, torch.from_numpy(frames.images)[:, None]]
    if count:
        batch = matching.triplet_batch(rng, count)
        images = np.stack([light(rng, image) for image in batch.images.reshape(-1, *batch.images.shape[2:])])
        shown.append(torch.from_numpy(images)[:, None])
    logits = network(torch.cat(shown).contiguous(memory_format=torch.channels_last))
    ours, moving, theirs = torch.split(logits, [len(extra), config.motion_frames, 3 * count])
    motion = losses.motion(moving, frames.maps, config.moved_weight, config.standing_weight)
    if not count:
        return ours, torch.zeros(()), torch.zeros(()), motion
    maps = torch.sigmoid(theirs).reshape(count, 3, 1, *theirs.shape[2:])
    return ours, *triplet_losses(maps, batch, config), motion


def step_losses(network: DSFeat, labelled: Labelled, matching: Matching | None, config: Config, epoch: int, step: int):
    """All losses of one step: (total, semantic, dense, sparse, motion)."""
    zero = torch.zeros(())
    if matching is None:
        images, maps = labelled.batch((config.seed, epoch, step, 0), config.batch)
        logits = network(images.contiguous(memory_format=torch.channels_last))
        semantic = losses.semantic(logits, maps, config.dynamic_weight)
        return semantic, semantic, zero, zero, zero
    images, maps = labelled.batch((config.seed, epoch, step, 0), config.hybrid_batch)
    logits, dense, sparse, moving = matching_losses(network, matching, config, (config.seed, epoch, step, 1), images)
    semantic = losses.semantic(logits, maps, config.dynamic_weight)
    total = config.weight_dense * dense + config.weight_sparse * sparse + config.weight_motion * moving
    weight = losses.semantic_weight(epoch, config.decay, config.floor)
    return losses.hybrid(semantic, total, weight), semantic, dense, sparse, moving


def train_epoch(network: DSFeat, optimiser, labelled: Labelled, matching, config: Config, epoch: int) -> np.ndarray:
    """Runs one epoch; mean of (total, semantic, dense, sparse, motion) over its steps."""
    network.train()
    sums = np.zeros(5)
    steps = config.steps_in(epoch)
    for step in range(steps):
        found = step_losses(network, labelled, matching, config, epoch, step)
        optimiser.zero_grad(set_to_none=True)
        found[0].backward()
        optimiser.step()
        sums += [float(x.detach()) for x in found]
    return sums / steps


def save(path: Path, value: dict) -> None:
    """Writes a checkpoint so that a crash leaves the old one."""
    torch.save(value, path.with_suffix(".part"))
    os.replace(path.with_suffix(".part"), path)


def write_log(path: Path, rows: list[dict]) -> None:
    """All epochs so far as CSV."""
    names = COLUMNS + sorted({k for row in rows for k in row} - set(COLUMNS))
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(rows)


def run(config: Config, out: Path, cache: Path, threads: int) -> None:
    """Trains to the last epoch, continuing where `out` has a checkpoint."""
    torch.set_num_threads(threads)
    torch.use_deterministic_algorithms(True)
    torch.set_flush_denormal(True)
    torch.manual_seed(config.seed)
    out.mkdir(parents=True, exist_ok=True)
    config.write(out / "config.json")
    sets = {n: [load(n, cache)] for n in config.mix if n != "town"}
    if "town" in config.mix:
        sets["town"] = [load(n, cache) for n in config.towns]
    labelled = Labelled(sets, config.mix)
    matching = Matching.load(cache) if config.hybrid else None
    watched = [load(n, cache) for n in ("cityscapes_val", "camvid_val", "kitti_val", *watched_towns(cache))]
    network = DSFeat(tuple(config.widths), tuple(config.dilations)).to(memory_format=torch.channels_last)
    optimiser = torch.optim.Adam(network.parameters(), lr=config.rate)
    schedule = torch.optim.lr_scheduler.MultiStepLR(optimiser, config.milestones, 0.1)
    first, rows = 0, []
    if (out / "last.pt").is_file():
        state = torch.load(out / "last.pt", weights_only=True)
        network.load_state_dict(state["network"])
        optimiser.load_state_dict(state["optimiser"])
        schedule.load_state_dict(state["schedule"])
        first, rows = state["epoch"] + 1, state["rows"]
    for epoch in range(first, config.epochs):
        start = time.process_time()
        rate = optimiser.param_groups[0]["lr"]
        means = train_epoch(network, optimiser, labelled, matching, config, epoch)
        schedule.step()
        weight = losses.semantic_weight(epoch, config.decay, config.floor) if config.hybrid else 1.0
        row = dict(zip(COLUMNS, [epoch, rate, weight, *(float(x) for x in means), 0.0]))
        if epoch % 5 == 4 or epoch == 0:
            row.update(quick(network, watched))
        row["seconds"] = time.process_time() - start
        rows.append(row)
        print(" ".join(f"{k} {v:.4g}" for k, v in row.items()), flush=True)
        save(out / "last.pt", {
            "network": network.state_dict(), "optimiser": optimiser.state_dict(), "schedule": schedule.state_dict(),
            "epoch": epoch, "rows": rows, "widths": config.widths, "dilations": config.dilations,
        })
        write_log(out / "log.csv", rows)
    plot(rows, out / "curves.png", "hybrid" if config.hybrid else "semantic only")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", type=Path, required=True, help="JSON file of settings (configs/)")
    parser.add_argument("--out", type=Path, required=True, help="folder of the run: checkpoint, log, curves")
    parser.add_argument("--threads", type=int, default=1, help="processor threads; another number changes the last bits")
    parser.add_argument("--trial", action="store_true", help="two epochs of three steps, to see whether all is there")
    add_folders(parser)
    args = parser.parse_args()
    need(parser, args, "cache")
    config = read(args.config)
    run(trial(config) if args.trial else config, args.out, args.cache, args.threads)


if __name__ == "__main__":
    main()
