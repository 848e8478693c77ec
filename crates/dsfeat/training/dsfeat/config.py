"""Settings of one training run, read from a JSON file; unknown keys are refused."""

import json
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path

from .network import DILATIONS, WIDTHS


@dataclass
class Config:
    """All that determines a run besides the data. Defaults are the paper's where it gives a value."""

    #: Use the matching loss (eq. 2 to 7); without it the run is the semantic-only baseline.
    hybrid: bool = False
    seed: int = 1
    #: Channels and dilations of the network (`dsfeat.network.DSFeat`).
    widths: list[int] = field(default_factory=lambda: list(WIDTHS))
    dilations: list[int] = field(default_factory=lambda: list(DILATIONS))
    epochs: int = 50
    #: Optimisation steps of one epoch before, between and after the milestones: an epoch is a fixed number of samples, not
    #: one pass over the data, and the epochs of the small rates, which change little, are short.
    steps: list[int] = field(default_factory=lambda: [80, 60, 20, 10])
    #: Labelled images per step.
    batch: int = 6
    rate: float = 1e-3
    #: The rate is multiplied by 0.1 after these epochs.
    milestones: list[int] = field(default_factory=lambda: [20, 30, 40])
    #: The semantic loss has weight `decay ** epoch`, the matching loss the rest.
    decay: float = 0.9
    #: The semantic loss keeps at least this weight: it is the only one that sees labelled photographs.
    floor: float = 0.0
    #: Weight of dynamic pixels in the semantic loss (static pixels have 1).
    dynamic_weight: float = 2.0
    #: Hybrid only: labelled images and frames with maps refined by motion per step, triplets in every n-th step.
    hybrid_batch: int = 4
    motion_frames: int = 3
    triplets: int = 1
    triplet_every: int = 2
    #: Margins of the triplet loss for the dense and the sparse distance.
    margin_dense: float = 0.2
    margin_sparse: float = 0.3
    #: Weights of moved pixels and of pixels on standing vehicles in the motion loss (others have 1).
    moved_weight: float = 5.0
    standing_weight: float = 3.0
    #: Weights of dense triplet loss, sparse triplet loss and motion loss within the matching loss.
    weight_dense: float = 0.25
    weight_sparse: float = 0.25
    weight_motion: float = 1.0
    #: Rendered towns of the semantic stage, by their names in the cache.
    towns: list[str] = field(default_factory=lambda: ["town_busy_201", "town_crossing_202"])
    #: Share of each data set in a batch of labelled images.
    mix: dict[str, float] = field(
        default_factory=lambda: {
            "cityscapes_train": 0.4, "idd_train": 0.25, "camvid_train": 0.1, "kitti_train": 0.1, "town": 0.15,
        }
    )

    def steps_in(self, epoch: int) -> int:
        """Optimisation steps of an epoch."""
        return self.steps[sum(epoch >= m for m in self.milestones)]

    def write(self, path: Path) -> None:
        """Writes all settings in force."""
        path.write_text(json.dumps(asdict(self), indent=1) + "\n")


def read(path: Path) -> Config:
    """Reads a JSON file of some of the settings.

    Raises SystemExit naming the unknown keys.
    """
    values = json.loads(path.read_text())
    unknown = sorted(set(values) - {f.name for f in fields(Config)})
    if unknown:
        raise SystemExit(f"{path}: unknown keys {', '.join(unknown)}")
    config = Config(**values)
    if len(config.steps) != len(config.milestones) + 1:
        raise SystemExit(f"{path}: steps needs {len(config.milestones) + 1} numbers, one more than milestones")
    return config


def trial(config):
    """The same run (of either network) cut to two epochs of three steps: whether all that it needs is there."""
    return replace(config, epochs=2, steps=[3] * len(config.steps))
